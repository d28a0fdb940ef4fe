/*
 * The interface of FMI 3.0 for co-simulation, over the generated code of one sheet.
 */
#include "fmi3-api.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Callbacks;

#include "fmi-model.h"
#include "fmi-unit.h"

static void report(const Unit *unit, const char *message)
{
    if (unit->callbacks.log != NULL) {
        unit->callbacks.log(unit->callbacks.environment, fmi3Error, "logStatusError", message);
    }
}

static void *claim(const Callbacks *callbacks, size_t size)
{
    (void)callbacks;
    return calloc(1u, size);
}

static void release(const Callbacks *callbacks, void *memory)
{
    (void)callbacks;
    free(memory);
}

static fmi3Status status(bool done)
{
    return done ? fmi3OK : fmi3Error;
}

static fmi3Status refuse(fmi3Instance instance, const char *message)
{
    if (instance != NULL) {
        report((const Unit *)instance, message);
    }
    return fmi3Error;
}

/* ---- the instance */

FMI3(const char *, fmi3GetVersion, (void))
{
    return "3.0";
}

FMI3(fmi3Status, fmi3SetDebugLogging,
     (fmi3Instance instance, fmi3Boolean loggingOn, size_t count, const fmi3String categories[]))
{
    (void)loggingOn; /* refusals are always logged; there is nothing else to log */
    (void)count;
    (void)categories;
    return status(instance != NULL);
}

FMI3(fmi3Instance, fmi3InstantiateCoSimulation,
     (fmi3String instanceName, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean loggingOn,
      fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed, const fmi3ValueReference intermediate[],
      size_t intermediateCount, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
      fmi3IntermediateUpdateCallback update))
{
    Callbacks callbacks;
    const char *problem = NULL;
    (void)instanceName;
    (void)resources;
    (void)visible;
    (void)loggingOn;
    (void)earlyReturnAllowed;
    (void)intermediate;
    (void)update;
    memset(&callbacks, 0, sizeof callbacks);
    callbacks.environment = environment;
    callbacks.log = log;
    if (!sameToken(token)) {
        problem = "the token is not that of this unit: modelDescription.xml and binary do not belong together";
    } else if (eventModeUsed || intermediateCount != 0u) {
        problem = "the unit has no event mode and no intermediate variables";
    }
    if (problem != NULL) {
        if (log != NULL) {
            log(environment, fmi3Error, "logStatusError", problem);
        }
        return NULL;
    }
    return makeUnit(&callbacks);
}

FMI3(fmi3Instance, fmi3InstantiateModelExchange,
     (fmi3String instanceName, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean loggingOn,
      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log))
{
    (void)instanceName;
    (void)token;
    (void)resources;
    (void)visible;
    (void)loggingOn;
    if (log != NULL) {
        log(environment, fmi3Error, "logStatusError", "the unit is for co-simulation only");
    }
    return NULL;
}

FMI3(fmi3Instance, fmi3InstantiateScheduledExecution,
     (fmi3String instanceName, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean loggingOn,
      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback clock,
      fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock))
{
    (void)instanceName;
    (void)token;
    (void)resources;
    (void)visible;
    (void)loggingOn;
    (void)clock;
    (void)lock;
    (void)unlock;
    if (log != NULL) {
        log(environment, fmi3Error, "logStatusError", "the unit is for co-simulation only");
    }
    return NULL;
}

FMI3(void, fmi3FreeInstance, (fmi3Instance instance))
{
    free(instance);
}

FMI3(fmi3Status, fmi3EnterInitializationMode,
     (fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance, fmi3Float64 startTime,
      fmi3Boolean stopTimeDefined, fmi3Float64 stopTime))
{
    Unit *unit = (Unit *)instance;
    (void)toleranceDefined;
    (void)tolerance;
    if (unit == NULL || !inMode(unit, modeInstantiated, "fmi3EnterInitializationMode") ||
        !beginInitialization(unit, startTime, stopTimeDefined, stopTime)) {
        return fmi3Error;
    }
    unit->memory.mode = modeInitializing;
    return fmi3OK;
}

FMI3(fmi3Status, fmi3ExitInitializationMode, (fmi3Instance instance))
{
    Unit *unit = (Unit *)instance;
    if (unit == NULL || !inMode(unit, modeInitializing, "fmi3ExitInitializationMode")) {
        return fmi3Error;
    }
    endInitialization(unit);
    return fmi3OK;
}

FMI3(fmi3Status, fmi3Terminate, (fmi3Instance instance))
{
    Unit *unit = (Unit *)instance;
    if (unit == NULL || !inMode(unit, modeStepping, "fmi3Terminate")) {
        return fmi3Error;
    }
    unit->memory.mode = modeTerminated;
    return fmi3OK;
}

FMI3(fmi3Status, fmi3Reset, (fmi3Instance instance))
{
    if (instance == NULL) {
        return fmi3Error;
    }
    restart((Unit *)instance);
    return fmi3OK;
}

/* ---- values: elements of arrays one after another, rows first */

/* Whether so many values belong to these variables. */
static bool fits(const Unit *unit, const uint32_t references[], size_t count, size_t values)
{
    char message[MESSAGE_LENGTH];
    size_t needed = 0u;
    size_t i;
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindReal | kindBoolean | kindConstant | kindTime);
        if (variable == NULL) {
            return false;
        }
        needed += variable->count;
    }
    if (needed == values) {
        return true;
    }
    (void)snprintf(message, sizeof message, "%lu values are given or asked for, the variables hold %lu",
                   (unsigned long)values, (unsigned long)needed);
    report(unit, message);
    return false;
}

/* The kinds of variable that fmi3GetFloat64 and fmi3GetFloat32 know. */
#define KINDS_64 (kindConstant | kindTime | (sizeof(ModelReal) == sizeof(fmi3Float64) ? kindReal : 0))
#define KINDS_32 (sizeof(ModelReal) == sizeof(fmi3Float64) ? 0 : kindReal)

#define REALS(get, set, type, kinds)                                                                              \
    FMI3(fmi3Status, get,                                                                                         \
         (fmi3Instance instance, const fmi3ValueReference references[], size_t count, type values[],              \
          size_t valueCount))                                                                                     \
    {                                                                                                             \
        Unit *unit = (Unit *)instance;                                                                            \
        size_t next = 0u;                                                                                         \
        size_t i;                                                                                                 \
        if (unit == NULL || !fits(unit, references, count, valueCount)) {                                         \
            return fmi3Error;                                                                                     \
        }                                                                                                         \
        for (i = 0u; i < count; ++i) {                                                                            \
            const Variable *variable = variableOf(unit, references[i], kinds);                                    \
            size_t k;                                                                                             \
            if (variable == NULL) {                                                                               \
                return fmi3Error;                                                                                 \
            }                                                                                                     \
            prepare(unit, variable);                                                                              \
            for (k = 0u; k < variable->count; ++k) {                                                              \
                values[next++] = (type)realOf(unit, variable, k);                                                 \
            }                                                                                                     \
        }                                                                                                         \
        return fmi3OK;                                                                                            \
    }                                                                                                             \
                                                                                                                  \
    FMI3(fmi3Status, set,                                                                                         \
         (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const type values[],        \
          size_t valueCount))                                                                                     \
    {                                                                                                             \
        Unit *unit = (Unit *)instance;                                                                            \
        size_t next = 0u;                                                                                         \
        size_t i;                                                                                                 \
        if (unit == NULL || !fits(unit, references, count, valueCount)) {                                         \
            return fmi3Error;                                                                                     \
        }                                                                                                         \
        for (i = 0u; i < count; ++i) {                                                                            \
            const Variable *variable = variableOf(unit, references[i], kinds);                                    \
            size_t k;                                                                                             \
            if (variable == NULL || !settable(unit, variable, references[i])) {                                   \
                return fmi3Error;                                                                                 \
            }                                                                                                     \
            for (k = 0u; k < variable->count; ++k) {                                                              \
                ((ModelReal *)placeToSet(unit, variable))[k] = (ModelReal)values[next++];                         \
            }                                                                                                     \
        }                                                                                                         \
        return fmi3OK;                                                                                            \
    }

REALS(fmi3GetFloat64, fmi3SetFloat64, fmi3Float64, KINDS_64)
REALS(fmi3GetFloat32, fmi3SetFloat32, fmi3Float32, KINDS_32)

FMI3(fmi3Status, fmi3GetBoolean,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Boolean values[],
      size_t valueCount))
{
    Unit *unit = (Unit *)instance;
    size_t next = 0u;
    size_t i;
    if (unit == NULL || !fits(unit, references, count, valueCount)) {
        return fmi3Error;
    }
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindBoolean);
        size_t k;
        if (variable == NULL) {
            return fmi3Error;
        }
        prepare(unit, variable);
        for (k = 0u; k < variable->count; ++k) {
            values[next++] = ((const bool *)placeOf(unit, variable))[k];
        }
    }
    return fmi3OK;
}

FMI3(fmi3Status, fmi3SetBoolean,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Boolean values[],
      size_t valueCount))
{
    Unit *unit = (Unit *)instance;
    size_t next = 0u;
    size_t i;
    if (unit == NULL || !fits(unit, references, count, valueCount)) {
        return fmi3Error;
    }
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindBoolean);
        size_t k;
        if (variable == NULL || !settable(unit, variable, references[i])) {
            return fmi3Error;
        }
        for (k = 0u; k < variable->count; ++k) {
            ((bool *)placeToSet(unit, variable))[k] = values[next++];
        }
    }
    return fmi3OK;
}

/* ---- saved states */

FMI3(fmi3Status, fmi3GetFMUState, (fmi3Instance instance, fmi3FMUState *state))
{
    return status(instance != NULL && state != NULL && saveState((Unit *)instance, state));
}

FMI3(fmi3Status, fmi3SetFMUState, (fmi3Instance instance, fmi3FMUState state))
{
    return status(instance != NULL && restoreState((Unit *)instance, state));
}

FMI3(fmi3Status, fmi3FreeFMUState, (fmi3Instance instance, fmi3FMUState *state))
{
    if (instance == NULL) {
        return fmi3Error;
    }
    freeState((Unit *)instance, state);
    return fmi3OK;
}

FMI3(fmi3Status, fmi3SerializedFMUStateSize, (fmi3Instance instance, fmi3FMUState state, size_t *size))
{
    (void)state;
    if (instance == NULL || size == NULL) {
        return fmi3Error;
    }
    *size = SERIALISED_SIZE;
    return fmi3OK;
}

FMI3(fmi3Status, fmi3SerializeFMUState, (fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size))
{
    return status(instance != NULL && serialise((const Unit *)instance, state, bytes, size));
}

FMI3(fmi3Status, fmi3DeserializeFMUState,
     (fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state))
{
    return status(instance != NULL && state != NULL && deserialise((Unit *)instance, bytes, size, state));
}

/* ---- steps */

FMI3(fmi3Status, fmi3DoStep,
     (fmi3Instance instance, fmi3Float64 point, fmi3Float64 size, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn,
      fmi3Float64 *lastSuccessfulTime))
{
    Unit *unit = (Unit *)instance;
    bool done;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (unit == NULL || !inMode(unit, modeStepping, "fmi3DoStep")) {
        return fmi3Error;
    }
    done = advance(unit, point, size);
    *eventHandlingNeeded = false;
    *terminateSimulation = false;
    *earlyReturn = false;
    *lastSuccessfulTime = unitTime(unit);
    return status(done);
}

#include "fmi3-refusals.h"
