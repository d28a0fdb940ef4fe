/*
 * What a unit does not offer, as its description says. Every library exports these functions; here they refuse.
 *
 * Included once, at the end of fmi3-unit.c.
 */
#ifndef FMI3_REFUSALS_H
#define FMI3_REFUSALS_H

/* A sheet has no variables of these types: only the empty list is right. */
#define NO_VARIABLES(function, type)                                                                           \
    FMI3(fmi3Status, function,                                                                                 \
         (fmi3Instance instance, const fmi3ValueReference references[], size_t count, type values[],           \
          size_t valueCount))                                                                                  \
    {                                                                                                          \
        (void)references;                                                                                      \
        (void)values;                                                                                          \
        (void)valueCount;                                                                                      \
        return count == 0u ? fmi3OK : refuse(instance, #function ": the unit has no variables of this type");  \
    }

NO_VARIABLES(fmi3GetInt8, fmi3Int8)
NO_VARIABLES(fmi3GetUInt8, fmi3UInt8)
NO_VARIABLES(fmi3GetInt16, fmi3Int16)
NO_VARIABLES(fmi3GetUInt16, fmi3UInt16)
NO_VARIABLES(fmi3GetInt32, fmi3Int32)
NO_VARIABLES(fmi3GetUInt32, fmi3UInt32)
NO_VARIABLES(fmi3GetInt64, fmi3Int64)
NO_VARIABLES(fmi3GetUInt64, fmi3UInt64)
NO_VARIABLES(fmi3GetString, fmi3String)
NO_VARIABLES(fmi3SetInt8, const fmi3Int8)
NO_VARIABLES(fmi3SetUInt8, const fmi3UInt8)
NO_VARIABLES(fmi3SetInt16, const fmi3Int16)
NO_VARIABLES(fmi3SetUInt16, const fmi3UInt16)
NO_VARIABLES(fmi3SetInt32, const fmi3Int32)
NO_VARIABLES(fmi3SetUInt32, const fmi3UInt32)
NO_VARIABLES(fmi3SetInt64, const fmi3Int64)
NO_VARIABLES(fmi3SetUInt64, const fmi3UInt64)
NO_VARIABLES(fmi3SetString, const fmi3String)

#define MODE_NOT_OFFERED(function)                                                            \
    FMI3(fmi3Status, function, (fmi3Instance instance))                                       \
    {                                                                                         \
        return refuse(instance, #function ": the unit has no mode but initialization and step"); \
    }

MODE_NOT_OFFERED(fmi3EnterEventMode)
MODE_NOT_OFFERED(fmi3EnterStepMode)
MODE_NOT_OFFERED(fmi3EnterConfigurationMode)
MODE_NOT_OFFERED(fmi3ExitConfigurationMode)
MODE_NOT_OFFERED(fmi3EvaluateDiscreteStates)
MODE_NOT_OFFERED(fmi3EnterContinuousTimeMode)

FMI3(fmi3Status, fmi3UpdateDiscreteStates,
     (fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate, fmi3Boolean *terminateSimulation,
      fmi3Boolean *nominalsOfContinuousStatesChanged, fmi3Boolean *valuesOfContinuousStatesChanged,
      fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime))
{
    (void)discreteStatesNeedUpdate;
    (void)terminateSimulation;
    (void)nominalsOfContinuousStatesChanged;
    (void)valuesOfContinuousStatesChanged;
    (void)nextEventTimeDefined;
    (void)nextEventTime;
    return refuse(instance, "fmi3UpdateDiscreteStates: the unit has no event mode");
}

FMI3(fmi3Status, fmi3ActivateModelPartition,
     (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 activationTime))
{
    (void)clock;
    (void)activationTime;
    return refuse(instance, "fmi3ActivateModelPartition: the unit is for co-simulation only");
}

FMI3(fmi3Status, fmi3GetBinary,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, size_t sizes[], fmi3Binary values[],
      size_t valueCount))
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)valueCount;
    return count == 0u ? fmi3OK : refuse(instance, "fmi3GetBinary: the unit has no binary variables");
}

FMI3(fmi3Status, fmi3SetBinary,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const size_t sizes[],
      const fmi3Binary values[], size_t valueCount))
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)valueCount;
    return count == 0u ? fmi3OK : refuse(instance, "fmi3SetBinary: the unit has no binary variables");
}

/* Functions of model exchange, which every library exports. */
#define NO_CONTINUOUS_STATES(function, type)                                             \
    FMI3(fmi3Status, function, (fmi3Instance instance, type values[], size_t count))     \
    {                                                                                    \
        (void)values;                                                                    \
        (void)count;                                                                     \
        return refuse(instance, #function ": the unit is for co-simulation only");       \
    }

NO_CONTINUOUS_STATES(fmi3SetContinuousStates, const fmi3Float64)
NO_CONTINUOUS_STATES(fmi3GetContinuousStates, fmi3Float64)
NO_CONTINUOUS_STATES(fmi3GetContinuousStateDerivatives, fmi3Float64)
NO_CONTINUOUS_STATES(fmi3GetNominalsOfContinuousStates, fmi3Float64)
NO_CONTINUOUS_STATES(fmi3GetEventIndicators, fmi3Float64)

FMI3(fmi3Status, fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t *count))
{
    (void)count;
    return refuse(instance, "fmi3GetNumberOfContinuousStates: the unit is for co-simulation only");
}

FMI3(fmi3Status, fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t *count))
{
    (void)count;
    return refuse(instance, "fmi3GetNumberOfEventIndicators: the unit is for co-simulation only");
}

FMI3(fmi3Status, fmi3CompletedIntegratorStep,
     (fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
      fmi3Boolean *terminateSimulation))
{
    (void)noSetFMUStatePriorToCurrentPoint;
    (void)enterEventMode;
    (void)terminateSimulation;
    return refuse(instance, "fmi3CompletedIntegratorStep: the unit is for co-simulation only");
}

FMI3(fmi3Status, fmi3SetTime, (fmi3Instance instance, fmi3Float64 time))
{
    (void)time;
    return refuse(instance, "fmi3SetTime: the unit is for co-simulation only");
}

/* Functions on clocks: one with one array of values, one with two. */
#define NO_CLOCKS(function, type)                                                                                     \
    FMI3(fmi3Status, function,                                                                                        \
         (fmi3Instance instance, const fmi3ValueReference references[], size_t count, type values[]))                 \
    {                                                                                                                 \
        (void)references;                                                                                             \
        (void)values;                                                                                                 \
        return count == 0u ? fmi3OK : refuse(instance, #function ": the unit has no clocks");                         \
    }

#define NO_CLOCKS_2(function, type, type2)                                                                            \
    FMI3(fmi3Status, function,                                                                                        \
         (fmi3Instance instance, const fmi3ValueReference references[], size_t count, type values[], type2 others[])) \
    {                                                                                                                 \
        (void)references;                                                                                             \
        (void)values;                                                                                                 \
        (void)others;                                                                                                 \
        return count == 0u ? fmi3OK : refuse(instance, #function ": the unit has no clocks");                         \
    }

NO_CLOCKS(fmi3GetClock, fmi3Clock)
NO_CLOCKS(fmi3SetClock, const fmi3Clock)
NO_CLOCKS(fmi3GetShiftDecimal, fmi3Float64)
NO_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64)
NO_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64)
NO_CLOCKS_2(fmi3GetIntervalDecimal, fmi3Float64, fmi3IntervalQualifier)
NO_CLOCKS_2(fmi3GetShiftFraction, fmi3UInt64, fmi3UInt64)
NO_CLOCKS_2(fmi3SetShiftFraction, const fmi3UInt64, const fmi3UInt64)
NO_CLOCKS_2(fmi3SetIntervalFraction, const fmi3UInt64, const fmi3UInt64)

FMI3(fmi3Status, fmi3GetIntervalFraction,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt64 counters[],
      fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]))
{
    (void)references;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return count == 0u ? fmi3OK : refuse(instance, "fmi3GetIntervalFraction: the unit has no clocks");
}

FMI3(fmi3Status, fmi3GetNumberOfVariableDependencies,
     (fmi3Instance instance, fmi3ValueReference reference, size_t *dependencies))
{
    (void)reference;
    (void)dependencies;
    return refuse(instance, "fmi3GetNumberOfVariableDependencies: dependencies are in modelDescription.xml");
}

FMI3(fmi3Status, fmi3GetVariableDependencies,
     (fmi3Instance instance, fmi3ValueReference dependent, size_t elementsOfDependent[],
      fmi3ValueReference independents[], size_t elementsOfIndependents[], fmi3DependencyKind kinds[], size_t count))
{
    (void)dependent;
    (void)elementsOfDependent;
    (void)independents;
    (void)elementsOfIndependents;
    (void)kinds;
    (void)count;
    return refuse(instance, "fmi3GetVariableDependencies: dependencies are in modelDescription.xml");
}

#define NO_DERIVATIVES(function)                                                                                      \
    FMI3(fmi3Status, function,                                                                                        \
         (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknownCount,                            \
          const fmi3ValueReference knowns[], size_t knownCount, const fmi3Float64 seed[], size_t seedCount,           \
          fmi3Float64 sensitivity[], size_t sensitivityCount))                                                        \
    {                                                                                                                 \
        (void)unknowns;                                                                                               \
        (void)unknownCount;                                                                                           \
        (void)knowns;                                                                                                 \
        (void)knownCount;                                                                                             \
        (void)seed;                                                                                                   \
        (void)seedCount;                                                                                              \
        (void)sensitivity;                                                                                            \
        (void)sensitivityCount;                                                                                       \
        return refuse(instance, #function ": the unit gives no derivatives");                                         \
    }

NO_DERIVATIVES(fmi3GetDirectionalDerivative)
NO_DERIVATIVES(fmi3GetAdjointDerivative)

FMI3(fmi3Status, fmi3GetOutputDerivatives,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int32 orders[],
      fmi3Float64 values[], size_t valueCount))
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    (void)valueCount;
    return refuse(instance, "fmi3GetOutputDerivatives: the unit gives no derivatives");
}

#endif
