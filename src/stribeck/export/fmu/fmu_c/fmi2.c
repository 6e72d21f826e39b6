/*
 * The functions of FMI 2.0 for co-simulation over an axis. To link several units into one program,
 * define FMI2_FUNCTION_PREFIX as the model identifier and an underscore.
 */
#include "fmi2.h"

#include "axis.h"

#include <stdlib.h>
#include <string.h>

#ifndef FMI2_FUNCTION_PREFIX
#define FMI2_FUNCTION_PREFIX
#endif
#define JOINED_(a, b) a##b
#define JOINED(a, b) JOINED_(a, b)
#if defined(_WIN32)
#define SEEN __declspec(dllexport)
#elif defined(__GNUC__)
#define SEEN __attribute__((visibility("default")))
#else
#define SEEN
#endif
/* A public function, declared and begun. */
#define PUBLIC(type, name, given)                     \
    SEEN type JOINED(FMI2_FUNCTION_PREFIX, name) given; \
    SEEN type JOINED(FMI2_FUNCTION_PREFIX, name) given

/* How far a unit has come: made, being initialized, running. */
typedef enum { MADE, BEGINNING, RUNNING, ENDED } phase;

/* What goes on in a unit, and is restored with its state. */
typedef struct {
    axis axis;
    phase phase;
    double time;
} progress;

typedef struct {
    progress at;
    const fmi2CallbackFunctions *host;
    char *name;
    int told;
} unit;

static fmi2Status refused(const unit *of, const char *why)
{
    if (of->host != NULL && of->host->logger != NULL) {
        of->host->logger(of->host->componentEnvironment, of->name, fmi2Error, "logStatusError",
                         "%s", why);
    }
    return fmi2Error;
}

static int is_input(fmi2ValueReference r)
{
    return r >= AXIS_FIRST_INPUT && r < AXIS_FIRST_INPUT + AXIS_INPUTS;
}

/* In the middle of an initialization the start follows what is set. */
static void renewed(unit *of)
{
    axis_set(&of->at.axis);
    if (of->at.phase != RUNNING && of->at.phase != ENDED) {
        axis_start(&of->at.axis);
    }
    of->told = 0;
}

PUBLIC(const char *, fmi2GetTypesPlatform, (void))
{
    return "default";
}

PUBLIC(const char *, fmi2GetVersion, (void))
{
    return "2.0";
}

PUBLIC(fmi2Status, fmi2SetDebugLogging,
       (fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]))
{
    (void)c;
    (void)on;
    (void)n;
    (void)categories;
    return fmi2OK;
}

PUBLIC(fmi2Component, fmi2Instantiate,
       (fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
        const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging))
{
    unit *of = (unit *)calloc(1, sizeof *of);
    size_t length = name == NULL ? 0 : strlen(name);
    (void)resources;
    (void)visible;
    (void)logging;
    if (of == NULL) {
        return NULL;
    }
    of->host = host;
    of->name = (char *)calloc(length + 1, 1);
    if (of->name == NULL) {
        free(of);
        return NULL;
    }
    if (length > 0) {
        memcpy(of->name, name, length);
    }
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, AXIS_GUID) != 0) {
        (void)refused(of, type != fmi2CoSimulation ? "this unit is for co-simulation only"
                                                   : "the GUID is that of another unit");
        free(of->name);
        free(of);
        return NULL;
    }
    axis_init(&of->at.axis);
    return of;
}

PUBLIC(void, fmi2FreeInstance, (fmi2Component c))
{
    unit *of = (unit *)c;
    if (of != NULL) {
        free(of->name);
        free(of);
    }
}

PUBLIC(fmi2Status, fmi2SetupExperiment,
       (fmi2Component c, fmi2Boolean tolerant, fmi2Real tolerance, fmi2Real start,
        fmi2Boolean ends, fmi2Real stop))
{
    unit *of = (unit *)c;
    (void)tolerant;
    (void)tolerance;
    (void)ends;
    (void)stop;
    of->at.time = start;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2EnterInitializationMode, (fmi2Component c))
{
    unit *of = (unit *)c;
    if (of->at.phase != MADE) {
        return refused(of, "the initialization has begun before");
    }
    of->at.phase = BEGINNING;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2ExitInitializationMode, (fmi2Component c))
{
    unit *of = (unit *)c;
    if (of->at.phase != BEGINNING) {
        return refused(of, "the initialization has not begun");
    }
    renewed(of);
    of->at.phase = RUNNING;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2Terminate, (fmi2Component c))
{
    ((unit *)c)->at.phase = ENDED;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2Reset, (fmi2Component c))
{
    unit *of = (unit *)c;
    memset(&of->at, 0, sizeof of->at);
    axis_init(&of->at.axis);
    of->told = 0;
    return fmi2OK;
}

/* Values */

PUBLIC(fmi2Status, fmi2GetReal,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]))
{
    unit *of = (unit *)c;
    size_t i;
    if (!of->told) {
        axis_tell(&of->at.axis);
        of->told = 1;
    }
    for (i = 0; i < n; i++) {
        if (r[i] >= AXIS_VALUES) {
            return refused(of, "there is no such value reference");
        }
        value[i] = of->at.axis.r[r[i]];
    }
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2SetReal,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]))
{
    unit *of = (unit *)c;
    size_t i;
    int parameters = 0;
    for (i = 0; i < n; i++) {
        if (r[i] >= AXIS_VALUES || r[i] < AXIS_FIRST_INPUT) {
            return refused(of, "only inputs and parameters can be set");
        }
        if (of->at.phase >= RUNNING && r[i] >= AXIS_POSITION_START && r[i] < AXIS_LAW) {
            return refused(of, "start, step and tolerance can be set before the start only");
        }
    }
    for (i = 0; i < n; i++) {
        of->at.axis.r[r[i]] = value[i];
        if (is_input(r[i])) {
            of->at.axis.rate[r[i] - AXIS_FIRST_INPUT] = 0.0;
        } else {
            parameters = 1;
        }
    }
    of->told = 0;
    if (parameters || of->at.phase < RUNNING) {
        renewed(of);
    }
    return fmi2OK;
}

/* Of other types there are no variables. */
static fmi2Status none(fmi2Component c, size_t n)
{
    return n == 0 ? fmi2OK : refused((unit *)c, "all variables are real");
}

PUBLIC(fmi2Status, fmi2GetInteger,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer value[]))
{
    (void)r;
    (void)value;
    return none(c, n);
}

PUBLIC(fmi2Status, fmi2GetBoolean,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean value[]))
{
    (void)r;
    (void)value;
    return none(c, n);
}

PUBLIC(fmi2Status, fmi2GetString,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String value[]))
{
    (void)r;
    (void)value;
    return none(c, n);
}

PUBLIC(fmi2Status, fmi2SetInteger,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer value[]))
{
    (void)r;
    (void)value;
    return none(c, n);
}

PUBLIC(fmi2Status, fmi2SetBoolean,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean value[]))
{
    (void)r;
    (void)value;
    return none(c, n);
}

PUBLIC(fmi2Status, fmi2SetString,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String value[]))
{
    (void)r;
    (void)value;
    return none(c, n);
}

PUBLIC(fmi2Status, fmi2SetRealInputDerivatives,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer order[],
        const fmi2Real value[]))
{
    unit *of = (unit *)c;
    size_t i;
    for (i = 0; i < n; i++) {
        if (!is_input(r[i]) || order[i] != 1) {
            return refused(of, "inputs have a first derivative, and nothing else has one");
        }
    }
    for (i = 0; i < n; i++) {
        of->at.axis.rate[r[i] - AXIS_FIRST_INPUT] = value[i];
    }
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2GetRealOutputDerivatives,
       (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer order[],
        fmi2Real value[]))
{
    (void)r;
    (void)order;
    (void)value;
    return n == 0 ? fmi2OK : refused((unit *)c, "derivatives of outputs are not told");
}

PUBLIC(fmi2Status, fmi2GetDirectionalDerivative,
       (fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
        const fmi2ValueReference known[], size_t knowns, const fmi2Real by[], fmi2Real value[]))
{
    (void)unknown;
    (void)unknowns;
    (void)known;
    (void)knowns;
    (void)by;
    (void)value;
    return refused((unit *)c, "directional derivatives are not told");
}

/* States */

PUBLIC(fmi2Status, fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate *state))
{
    unit *of = (unit *)c;
    if (*state == NULL) {
        *state = calloc(1, sizeof of->at);
    }
    if (*state == NULL) {
        return refused(of, "there is no memory for a state");
    }
    memcpy(*state, &of->at, sizeof of->at);
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate state))
{
    unit *of = (unit *)c;
    if (state == NULL) {
        return refused(of, "there is no state");
    }
    memcpy(&of->at, state, sizeof of->at);
    of->told = 0;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2FreeFMUstate, (fmi2Component c, fmi2FMUstate *state))
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate state, size_t *size))
{
    (void)c;
    (void)state;
    *size = sizeof(progress);
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2SerializeFMUstate,
       (fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size))
{
    if (state == NULL || size != sizeof(progress)) {
        return refused((unit *)c, "a state has another size");
    }
    memcpy(bytes, state, size);
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2DeSerializeFMUstate,
       (fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state))
{
    if (size != sizeof(progress)) {
        return refused((unit *)c, "a state has another size");
    }
    if (*state == NULL) {
        *state = calloc(1, size);
    }
    if (*state == NULL) {
        return refused((unit *)c, "there is no memory for a state");
    }
    memcpy(*state, bytes, size);
    return fmi2OK;
}

/* Time */

PUBLIC(fmi2Status, fmi2DoStep,
       (fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean sure))
{
    unit *of = (unit *)c;
    (void)sure;
    if (of->at.phase != RUNNING) {
        return refused(of, "a step comes after the initialization and before the end");
    }
    if (!(h >= 0.0)) {
        return refused(of, "a step cannot go back");
    }
    of->told = 0;
    if (axis_step(&of->at.axis, h)) {
        return refused(of, "the motion runs away, or takes too many steps: look at the parameters");
    }
    of->at.time = time + h;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2CancelStep, (fmi2Component c))
{
    return refused((unit *)c, "steps are not asynchronous");
}

static fmi2Status unknown(fmi2Component c)
{
    (void)refused((unit *)c, "there is no such status");
    return fmi2Discard;
}

PUBLIC(fmi2Status, fmi2GetStatus, (fmi2Component c, fmi2StatusKind kind, fmi2Status *value))
{
    (void)kind;
    (void)value;
    return unknown(c);
}

PUBLIC(fmi2Status, fmi2GetRealStatus, (fmi2Component c, fmi2StatusKind kind, fmi2Real *value))
{
    if (kind != fmi2LastSuccessfulTime) {
        return unknown(c);
    }
    *value = ((unit *)c)->at.time;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2GetIntegerStatus, (fmi2Component c, fmi2StatusKind kind, fmi2Integer *value))
{
    (void)kind;
    (void)value;
    return unknown(c);
}

PUBLIC(fmi2Status, fmi2GetBooleanStatus, (fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value))
{
    if (kind != fmi2Terminated) {
        return unknown(c);
    }
    *value = ((unit *)c)->at.phase == ENDED;
    return fmi2OK;
}

PUBLIC(fmi2Status, fmi2GetStringStatus, (fmi2Component c, fmi2StatusKind kind, fmi2String *value))
{
    (void)kind;
    (void)value;
    return unknown(c);
}
