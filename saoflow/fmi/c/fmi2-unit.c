/*
 * The interface of FMI 2.0 for co-simulation, over the generated code of one sheet.
 */
#include "fmi2-api.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAME_LENGTH 128

typedef struct {
    const fmi2CallbackFunctions *functions;
    char name[NAME_LENGTH]; /* of the instance, for messages */
} Callbacks;

#include "fmi-model.h"
#include "fmi-unit.h"

static void report(const Unit *unit, const char *message)
{
    const fmi2CallbackFunctions *functions = unit->callbacks.functions;
    if (functions->logger != NULL) {
        functions->logger(functions->componentEnvironment, unit->callbacks.name, fmi2Error, "logStatusError", message);
    }
}

static void *claim(const Callbacks *callbacks, size_t size)
{
    return callbacks->functions->allocateMemory != NULL ? callbacks->functions->allocateMemory(1u, size)
                                                        : calloc(1u, size);
}

static void release(const Callbacks *callbacks, void *memory)
{
    if (callbacks->functions->allocateMemory == NULL) {
        free(memory);
    } else if (callbacks->functions->freeMemory != NULL) {
        callbacks->functions->freeMemory(memory);
    }
}

static fmi2Status status(bool done)
{
    return done ? fmi2OK : fmi2Error;
}

static fmi2Status refuse(fmi2Component component, const char *message)
{
    if (component != NULL) {
        report((const Unit *)component, message);
    }
    return fmi2Error;
}

/* ---- the instance */

FMI2(const char *, fmi2GetTypesPlatform, (void))
{
    return "default";
}

FMI2(const char *, fmi2GetVersion, (void))
{
    return "2.0";
}

FMI2(fmi2Status, fmi2SetDebugLogging,
     (fmi2Component component, fmi2Boolean loggingOn, size_t count, const fmi2String categories[]))
{
    (void)loggingOn; /* refusals are always logged; there is nothing else to log */
    (void)count;
    (void)categories;
    return status(component != NULL);
}

FMI2(fmi2Component, fmi2Instantiate,
     (fmi2String instanceName, fmi2Type type, fmi2String guid, fmi2String resources,
      const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean loggingOn))
{
    Callbacks callbacks;
    const char *problem = NULL;
    (void)resources;
    (void)visible;
    (void)loggingOn;
    if (functions == NULL) {
        return NULL;
    }
    memset(&callbacks, 0, sizeof callbacks);
    callbacks.functions = functions;
    (void)snprintf(callbacks.name, sizeof callbacks.name, "%s", instanceName != NULL ? instanceName : "");
    if (type != fmi2CoSimulation) {
        problem = "the unit is for co-simulation only";
    } else if (!sameToken(guid)) {
        problem = "the GUID is not that of this unit: modelDescription.xml and binary do not belong together";
    }
    if (problem != NULL) {
        if (functions->logger != NULL) {
            functions->logger(functions->componentEnvironment, callbacks.name, fmi2Error, "logStatusError", problem);
        }
        return NULL;
    }
    return makeUnit(&callbacks);
}

FMI2(void, fmi2FreeInstance, (fmi2Component component))
{
    if (component != NULL) {
        const Callbacks callbacks = ((Unit *)component)->callbacks;
        release(&callbacks, component);
    }
}

FMI2(fmi2Status, fmi2SetupExperiment,
     (fmi2Component component, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
      fmi2Boolean stopTimeDefined, fmi2Real stopTime))
{
    Unit *unit = (Unit *)component;
    (void)toleranceDefined;
    (void)tolerance;
    return status(unit != NULL && inMode(unit, modeInstantiated, "fmi2SetupExperiment") &&
                  beginInitialization(unit, startTime, stopTimeDefined != 0, stopTime));
}

FMI2(fmi2Status, fmi2EnterInitializationMode, (fmi2Component component))
{
    Unit *unit = (Unit *)component;
    if (unit == NULL || !inMode(unit, modeInstantiated, "fmi2EnterInitializationMode")) {
        return fmi2Error;
    }
    unit->memory.mode = modeInitializing;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2ExitInitializationMode, (fmi2Component component))
{
    Unit *unit = (Unit *)component;
    if (unit == NULL || !inMode(unit, modeInitializing, "fmi2ExitInitializationMode")) {
        return fmi2Error;
    }
    endInitialization(unit);
    return fmi2OK;
}

FMI2(fmi2Status, fmi2Terminate, (fmi2Component component))
{
    Unit *unit = (Unit *)component;
    if (unit == NULL || !inMode(unit, modeStepping, "fmi2Terminate")) {
        return fmi2Error;
    }
    unit->memory.mode = modeTerminated;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2Reset, (fmi2Component component))
{
    if (component == NULL) {
        return fmi2Error;
    }
    restart((Unit *)component);
    return fmi2OK;
}

/* ---- values */

FMI2(fmi2Status, fmi2GetReal,
     (fmi2Component component, const fmi2ValueReference references[], size_t count, fmi2Real values[]))
{
    Unit *unit = (Unit *)component;
    size_t i;
    if (unit == NULL) {
        return fmi2Error;
    }
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindReal | kindConstant | kindTime);
        if (variable == NULL) {
            return fmi2Error;
        }
        prepare(unit, variable);
        values[i] = realOf(unit, variable, 0u);
    }
    return fmi2OK;
}

FMI2(fmi2Status, fmi2SetReal,
     (fmi2Component component, const fmi2ValueReference references[], size_t count, const fmi2Real values[]))
{
    Unit *unit = (Unit *)component;
    size_t i;
    if (unit == NULL) {
        return fmi2Error;
    }
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindReal | kindConstant | kindTime);
        if (variable == NULL || !settable(unit, variable, references[i])) {
            return fmi2Error;
        }
        *(ModelReal *)placeToSet(unit, variable) = (ModelReal)values[i];
    }
    return fmi2OK;
}

FMI2(fmi2Status, fmi2GetBoolean,
     (fmi2Component component, const fmi2ValueReference references[], size_t count, fmi2Boolean values[]))
{
    Unit *unit = (Unit *)component;
    size_t i;
    if (unit == NULL) {
        return fmi2Error;
    }
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindBoolean);
        if (variable == NULL) {
            return fmi2Error;
        }
        prepare(unit, variable);
        values[i] = *(const bool *)placeOf(unit, variable) ? 1 : 0;
    }
    return fmi2OK;
}

FMI2(fmi2Status, fmi2SetBoolean,
     (fmi2Component component, const fmi2ValueReference references[], size_t count, const fmi2Boolean values[]))
{
    Unit *unit = (Unit *)component;
    size_t i;
    if (unit == NULL) {
        return fmi2Error;
    }
    for (i = 0u; i < count; ++i) {
        const Variable *variable = variableOf(unit, references[i], kindBoolean);
        if (variable == NULL || !settable(unit, variable, references[i])) {
            return fmi2Error;
        }
        *(bool *)placeToSet(unit, variable) = values[i] != 0;
    }
    return fmi2OK;
}

/* A sheet has no variables of these types: only the empty list is right. */
#define NO_VARIABLES(function, type)                                                                           \
    FMI2(fmi2Status, function,                                                                                 \
         (fmi2Component component, const fmi2ValueReference references[], size_t count, type values[]))        \
    {                                                                                                          \
        (void)references;                                                                                      \
        (void)values;                                                                                          \
        return count == 0u ? fmi2OK : refuse(component, #function ": the unit has no variables of this type"); \
    }

NO_VARIABLES(fmi2GetInteger, fmi2Integer)
NO_VARIABLES(fmi2SetInteger, const fmi2Integer)
NO_VARIABLES(fmi2GetString, fmi2String)
NO_VARIABLES(fmi2SetString, const fmi2String)

/* ---- saved states */

FMI2(fmi2Status, fmi2GetFMUstate, (fmi2Component component, fmi2FMUstate *state))
{
    return status(component != NULL && state != NULL && saveState((Unit *)component, state));
}

FMI2(fmi2Status, fmi2SetFMUstate, (fmi2Component component, fmi2FMUstate state))
{
    return status(component != NULL && restoreState((Unit *)component, state));
}

FMI2(fmi2Status, fmi2FreeFMUstate, (fmi2Component component, fmi2FMUstate *state))
{
    if (component == NULL) {
        return fmi2Error;
    }
    freeState((Unit *)component, state);
    return fmi2OK;
}

FMI2(fmi2Status, fmi2SerializedFMUstateSize, (fmi2Component component, fmi2FMUstate state, size_t *size))
{
    (void)state;
    if (component == NULL || size == NULL) {
        return fmi2Error;
    }
    *size = SERIALISED_SIZE;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2SerializeFMUstate, (fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size))
{
    return status(component != NULL && serialise((const Unit *)component, state, (unsigned char *)bytes, size));
}

FMI2(fmi2Status, fmi2DeSerializeFMUstate,
     (fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state))
{
    return status(component != NULL && state != NULL &&
                  deserialise((Unit *)component, (const unsigned char *)bytes, size, state));
}

/* ---- steps */

FMI2(fmi2Status, fmi2DoStep,
     (fmi2Component component, fmi2Real point, fmi2Real size, fmi2Boolean noSetFMUStatePriorToCurrentPoint))
{
    Unit *unit = (Unit *)component;
    (void)noSetFMUStatePriorToCurrentPoint;
    return status(unit != NULL && inMode(unit, modeStepping, "fmi2DoStep") && advance(unit, point, size));
}

FMI2(fmi2Status, fmi2CancelStep, (fmi2Component component))
{
    return refuse(component, "fmi2CancelStep: no step is under way");
}

FMI2(fmi2Status, fmi2GetStatus, (fmi2Component component, const fmi2StatusKind kind, fmi2Status *value))
{
    (void)kind;
    (void)value;
    (void)refuse(component, "fmi2GetStatus: no step is pending");
    return fmi2Discard;
}

FMI2(fmi2Status, fmi2GetRealStatus, (fmi2Component component, const fmi2StatusKind kind, fmi2Real *value))
{
    if (component == NULL || kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = unitTime((const Unit *)component);
    return fmi2OK;
}

FMI2(fmi2Status, fmi2GetIntegerStatus, (fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value))
{
    (void)component;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

FMI2(fmi2Status, fmi2GetBooleanStatus, (fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value))
{
    if (component == NULL || kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = 0;
    return fmi2OK;
}

FMI2(fmi2Status, fmi2GetStringStatus, (fmi2Component component, const fmi2StatusKind kind, fmi2String *value))
{
    (void)component;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

/* ---- what the unit does not offer, as its description says */

FMI2(fmi2Status, fmi2GetDirectionalDerivative,
     (fmi2Component component, const fmi2ValueReference unknowns[], size_t unknownCount,
      const fmi2ValueReference knowns[], size_t knownCount, const fmi2Real seed[], fmi2Real sensitivity[]))
{
    (void)unknowns;
    (void)unknownCount;
    (void)knowns;
    (void)knownCount;
    (void)seed;
    (void)sensitivity;
    return refuse(component, "fmi2GetDirectionalDerivative: the unit gives no derivatives");
}

FMI2(fmi2Status, fmi2SetRealInputDerivatives,
     (fmi2Component component, const fmi2ValueReference references[], size_t count, const fmi2Integer order[],
      const fmi2Real values[]))
{
    (void)references;
    (void)count;
    (void)order;
    (void)values;
    return refuse(component, "fmi2SetRealInputDerivatives: inputs are held during a step");
}

FMI2(fmi2Status, fmi2GetRealOutputDerivatives,
     (fmi2Component component, const fmi2ValueReference references[], size_t count, const fmi2Integer order[],
      fmi2Real values[]))
{
    (void)references;
    (void)count;
    (void)order;
    (void)values;
    return refuse(component, "fmi2GetRealOutputDerivatives: the unit gives no derivatives");
}
