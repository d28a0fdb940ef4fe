/* An importer of FMI 3.0 that a sanitizer watches: a run with a refused step, saved states, and everything freed. */
#include "fmi3Functions.h"

#include <stdio.h>
#include <string.h>

static int messages;

static void count(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment;
    (void)category;
    if (status == fmi3Error && strchr(message, '%') == NULL) {
        ++messages;
    }
}

static int step(fmi3Instance unit, double time, double size)
{
    fmi3Boolean event, end, early;
    fmi3Float64 last;
    return (int)fmi3DoStep(unit, time, size, true, &event, &end, &early, &last);
}

int main(int argc, char **argv)
{
    const double period = 0.02;
    fmi3Instance unit;
    fmi3FMUState state = NULL, copy = NULL;
    fmi3Byte bytes[4096];
    size_t size = 0;
    int k, failures = 0;
    (void)argc;
    failures += fmi3InstantiateCoSimulation("one", "wrong", "", false, false, false, false, NULL, 0, NULL, count, NULL) != NULL;
    unit = fmi3InstantiateCoSimulation("one", argv[1], "", false, false, false, false, NULL, 0, NULL, count, NULL);
    if (unit == NULL) {
        return 2;
    }
    failures += fmi3EnterInitializationMode(unit, false, 0, 0, false, 0) != fmi3OK;
    failures += fmi3ExitInitializationMode(unit) != fmi3OK;
    for (k = 0; k < 10; ++k) {
        failures += step(unit, k * period, period) != fmi3OK;
    }
    failures += step(unit, 10 * period, 1.5 * period) != fmi3Error;
    failures += fmi3GetFMUState(unit, &state) != fmi3OK;
    failures += fmi3SerializedFMUStateSize(unit, state, &size) != fmi3OK || size > sizeof bytes;
    failures += fmi3SerializeFMUState(unit, state, bytes, size) != fmi3OK;
    failures += fmi3DeserializeFMUState(unit, bytes, size, &copy) != fmi3OK;
    failures += fmi3Reset(unit) != fmi3OK;
    failures += fmi3SetFMUState(unit, copy) != fmi3OK;
    failures += step(unit, 10 * period, period) != fmi3OK;
    failures += fmi3FreeFMUState(unit, &state) != fmi3OK || fmi3FreeFMUState(unit, &copy) != fmi3OK;
    failures += fmi3Terminate(unit) != fmi3OK;
    fmi3FreeInstance(unit);
    (void)printf("%d failures, %d messages\n", failures, messages);
    return failures != 0 || messages != 2;
}
