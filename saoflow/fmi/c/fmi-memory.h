/*
 * The memory of an instance, and how its variables are described. Included by fmi-model.h, after the types of the sheet.
 */
#ifndef FMI_MEMORY_H
#define FMI_MEMORY_H

/* Modes, kinds and roles; modes and kinds are bits, so that a set of them is a number. */
enum { modeInstantiated = 1, modeInitializing = 2, modeStepping = 4, modeTerminated = 8 };
enum { kindReal = 1, kindBoolean = 2, kindConstant = 4, kindTime = 8 };
enum { roleNone, roleInput, roleOutput, roleState };

/* Everything that changes: what a saved state holds. */
typedef struct {
    ModelState state;
    ModelInput input;
    ModelOutput output;
    double start;
    double stop;
    uint64_t frames;
    int mode;
    bool stopDefined;
    bool stale; /* the outputs do not show the inputs yet */
} Memory;

/* A variable: where its elements lie, from the start of Memory; for a constant, from the first constant. */
typedef struct {
    int kind;
    int role;
    size_t offset;
    size_t count;
} Variable;

#endif
