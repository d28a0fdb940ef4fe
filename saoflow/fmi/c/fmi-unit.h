/*
 * What the FMI 2.0 and 3.0 interfaces of a sheet share: an instance, its variables, its frames, its saved states.
 *
 * Included once, after `Callbacks` and the tables of the sheet (fmi-model.h). Everything is static: two units can be
 * linked into one program. All that changes lies in the instance, in memory of the importer or of calloc.
 */
#ifndef FMI_UNIT_H
#define FMI_UNIT_H

/* Messages are shorter than this. */
#define MESSAGE_LENGTH 320

/* How far a communication step may be from a whole number of frames, and a communication point from the unit's own
 * time, in frame periods: room for the rounding of an importer that adds up its steps, for nothing else. */
#define STEP_TOLERANCE 1e-6
#define POINT_TOLERANCE 1e-2
#define MOST_FRAMES 1e9

typedef struct {
    Memory memory;
    ModelState scratch; /* the state after a frame that is only looked at */
    Callbacks callbacks;
} Unit;

/* What the head of a serialised state holds. */
typedef struct {
    char mark[8];
    uint64_t size;
    uint64_t check;
} Seal;

/* Tells the importer why a call fails. Messages hold no percent sign: they may be taken for a format. */
static void report(const Unit *unit, const char *message);
static void *claim(const Callbacks *callbacks, size_t size);
static void release(const Callbacks *callbacks, void *memory);

/* ---- an instance */

static bool sameToken(const char *token)
{
    return token != NULL && strcmp(token, modelToken) == 0;
}

/* The state before the first frame, inputs of zero. */
static void restart(Unit *unit)
{
    Memory *memory = &unit->memory;
    memset(memory, 0, sizeof(Memory));
    modelInit(&memory->state);
    memory->mode = modeInstantiated;
    memory->stale = true;
}

static Unit *makeUnit(const Callbacks *callbacks)
{
    Unit *unit = (Unit *)claim(callbacks, sizeof(Unit));
    if (unit != NULL) {
        unit->callbacks = *callbacks;
        restart(unit);
    }
    return unit;
}

static bool inMode(const Unit *unit, unsigned int modes, const char *call)
{
    char message[MESSAGE_LENGTH];
    if (((unsigned int)unit->memory.mode & modes) != 0u) {
        return true;
    }
    (void)snprintf(message, sizeof message, "%s is not allowed in this mode of the unit", call);
    report(unit, message);
    return false;
}

static double unitTime(const Unit *unit)
{
    return unit->memory.start + (double)unit->memory.frames * modelPeriod;
}

/* Before the first step, outputs show what the first frame would give with the present inputs and state. */
static void settle(Unit *unit)
{
    Memory *memory = &unit->memory;
    if (memory->stale) {
        memcpy(&unit->scratch, &memory->state, sizeof(ModelState));
        modelStep(&unit->scratch, &memory->input, &memory->output);
        memory->stale = false;
    }
}

static bool beginInitialization(Unit *unit, double start, bool stopDefined, double stop)
{
    char message[MESSAGE_LENGTH];
    if (!(start - start <= 0.0) || (stopDefined && !(stop >= start))) {
        (void)snprintf(message, sizeof message, "a run from %.17g s to %.17g s is refused: times are finite and go on",
                       start, stop);
        report(unit, message);
        return false;
    }
    unit->memory.start = start;
    unit->memory.stop = stop;
    unit->memory.stopDefined = stopDefined;
    return true;
}

static void endInitialization(Unit *unit)
{
    settle(unit);
    unit->memory.mode = modeStepping;
}

/* ---- frames */

static double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

/* As many frames as the step holds, the inputs held; or nothing at all. */
static bool advance(Unit *unit, double point, double size)
{
    Memory *memory = &unit->memory;
    char message[MESSAGE_LENGTH];
    const double ratio = size / modelPeriod;
    const double here = unitTime(unit);
    uint64_t frames;
    uint64_t k;
    bool whole = ratio > 0.5 && ratio < MOST_FRAMES;
    frames = whole ? (uint64_t)(ratio + 0.5) : 0u;
    whole = whole && magnitude(size - (double)frames * modelPeriod) <= STEP_TOLERANCE * modelPeriod;
    if (!whole) {
        (void)snprintf(message, sizeof message,
                       "the step is refused, nothing is computed: the communication step size %.17g s is not a whole "
                       "multiple of the frame period %.17g s",
                       size, modelPeriod);
        report(unit, message);
        return false;
    }
    if (!(magnitude(point - here) <= POINT_TOLERANCE * modelPeriod)) {
        (void)snprintf(message, sizeof message,
                       "the step is refused, nothing is computed: the communication point %.17g s is not where the "
                       "unit stands, %.17g s",
                       point, here);
        report(unit, message);
        return false;
    }
    if (memory->stopDefined && here + size > memory->stop + POINT_TOLERANCE * modelPeriod) {
        (void)snprintf(message, sizeof message,
                       "the step is refused, nothing is computed: from %.17g s it goes beyond the stop time %.17g s",
                       here, memory->stop);
        report(unit, message);
        return false;
    }
    for (k = 0u; k < frames; ++k) {
        modelStep(&memory->state, &memory->input, &memory->output);
    }
    memory->frames += frames;
    return true;
}

/* ---- variables: a value reference is the number of a row */

static const Variable *variableOf(const Unit *unit, uint32_t reference, unsigned int kinds)
{
    char message[MESSAGE_LENGTH];
    if (reference >= modelVariableCount) {
        (void)snprintf(message, sizeof message, "there is no variable with value reference %lu",
                       (unsigned long)reference);
    } else if (((unsigned int)modelVariables[reference].kind & kinds) == 0u) {
        (void)snprintf(message, sizeof message, "the variable with value reference %lu is of another type",
                       (unsigned long)reference);
    } else {
        return &modelVariables[reference];
    }
    report(unit, message);
    return NULL;
}

/* Whether the variable may be set now. */
static bool settable(const Unit *unit, const Variable *variable, uint32_t reference)
{
    char message[MESSAGE_LENGTH];
    const unsigned int mode = (unsigned int)unit->memory.mode;
    const unsigned int modes = variable->role == roleInput ? modeInstantiated | modeInitializing | modeStepping
                               : variable->role == roleState ? modeInstantiated | modeInitializing
                                                             : 0u;
    if ((mode & modes) != 0u) {
        return true;
    }
    (void)snprintf(message, sizeof message, "the variable with value reference %lu cannot be set %s",
                   (unsigned long)reference, modes == 0u ? "at all" : "in this mode of the unit");
    report(unit, message);
    return false;
}

static const void *placeOf(const Unit *unit, const Variable *variable)
{
    return (const char *)&unit->memory + variable->offset;
}

static void *placeToSet(Unit *unit, const Variable *variable)
{
    if (unit->memory.mode != modeStepping) {
        unit->memory.stale = true;
    }
    return (char *)&unit->memory + variable->offset;
}

static double realOf(const Unit *unit, const Variable *variable, size_t element)
{
    if (variable->kind == kindTime) {
        return unitTime(unit);
    }
    if (variable->kind == kindConstant) {
        return modelConstants[variable->offset + element];
    }
    return (double)((const ModelReal *)placeOf(unit, variable))[element];
}

/* Outputs must be settled before they are read. */
static void prepare(Unit *unit, const Variable *variable)
{
    if (variable->role == roleOutput) {
        settle(unit);
    }
}

/* ---- saved states: copies of the memory */

static bool saveState(Unit *unit, void **saved)
{
    if (*saved == NULL) {
        *saved = claim(&unit->callbacks, sizeof(Memory));
    }
    if (*saved == NULL) {
        report(unit, "there is no memory for a saved state");
        return false;
    }
    memcpy(*saved, &unit->memory, sizeof(Memory));
    return true;
}

static bool restoreState(Unit *unit, const void *saved)
{
    if (saved == NULL) {
        report(unit, "there is no saved state to restore");
        return false;
    }
    memcpy(&unit->memory, saved, sizeof(Memory));
    return true;
}

static void freeState(Unit *unit, void **saved)
{
    if (saved != NULL && *saved != NULL) {
        release(&unit->callbacks, *saved);
        *saved = NULL;
    }
}

static uint64_t blend(uint64_t check, const unsigned char *bytes, size_t size)
{
    size_t i;
    for (i = 0u; i < size; ++i) { /* FNV-1a */
        check = (check ^ bytes[i]) * 0x100000001b3u;
    }
    return check;
}

static Seal sealOf(const unsigned char *memory)
{
    Seal seal;
    memset(&seal, 0, sizeof seal);
    memcpy(seal.mark, "saoflow", 8u);
    seal.size = sizeof(Memory);
    seal.check = blend(0xcbf29ce484222325u, (const unsigned char *)modelToken, sizeof modelToken);
    seal.check = blend(seal.check, memory, sizeof(Memory));
    return seal;
}

#define SERIALISED_SIZE (sizeof(Seal) + sizeof(Memory))

static bool serialise(const Unit *unit, const void *saved, unsigned char *bytes, size_t size)
{
    Seal seal;
    if (saved == NULL || bytes == NULL || size < SERIALISED_SIZE) {
        report(unit, "a state cannot be serialised: there is none, or the buffer is too small");
        return false;
    }
    seal = sealOf((const unsigned char *)saved);
    memcpy(bytes, &seal, sizeof seal);
    memcpy(bytes + sizeof seal, saved, sizeof(Memory));
    return true;
}

static bool deserialise(Unit *unit, const unsigned char *bytes, size_t size, void **saved)
{
    Seal seal;
    if (bytes != NULL && size >= SERIALISED_SIZE) {
        seal = sealOf(bytes + sizeof seal);
        if (memcmp(bytes, &seal, sizeof seal) == 0) {
            if (*saved == NULL) {
                *saved = claim(&unit->callbacks, sizeof(Memory));
            }
            if (*saved == NULL) {
                report(unit, "there is no memory for a saved state");
                return false;
            }
            memcpy(*saved, bytes + sizeof seal, sizeof(Memory));
            return true;
        }
    }
    report(unit, "the serialised state is damaged, or another unit's");
    return false;
}

#endif
