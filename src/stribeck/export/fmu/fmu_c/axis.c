/*
 * What a unit does with its axis, by the functions of axis_motion.h: it starts, passes steps and
 * tells. Where its values stand is said in axis_model.h.
 */
#include "axis.h"

#include <math.h>
#include <string.h>

#include "axis_motion.h"

static const double held[] = AXIS_HELD;

/* The inputs now, and after h seconds. */
static void inputs(axis *a, double h)
{
    static const int places[] = AXIS_PLACES;
    int i;
    memset(a->u, 0, sizeof a->u);
    a->u[2 * AXIS_ENABLED] = a->u[2 * AXIS_ENABLED + 1] = 1.0;
    for (i = 0; i < AXIS_INPUTS; i++) {
        double now = a->r[AXIS_FIRST_INPUT + i], *u = a->u + 2 * places[i];
        u[0] = now;
        u[1] = held[places[i]] > 0.0 ? now : now + h * a->rate[i];
    }
}

int axis_step(axis *a, double h)
{
    double room[AXIS_ROOM], n = ceil(h / a->r[AXIS_STEP] - 1e-9);
    static const int places[] = AXIS_PLACES;
    int i, passed;
    if (!(n <= AXIS_MOST_STEPS)) {
        return 1;
    }
    inputs(a, h);
    passed = motion_advance(a->r + AXIS_LAW, a->c, a->u, held, n > 1.0 ? (int)n : 1, h,
                            a->r[AXIS_TOLERANCE], a->memory, a->mode, room);
    for (i = 0; i < AXIS_INPUTS; i++) { /* where a changing input has got to, it stays */
        a->r[AXIS_FIRST_INPUT + i] = a->u[2 * places[i] + 1];
        a->rate[i] = 0.0;
    }
    return !passed;
}

void axis_start(axis *a)
{
    double room[AXIS_ROOM];
    inputs(a, 0.0);
    motion_start(a->r + AXIS_LAW, a->c, a->u, held, a->r[AXIS_POSITION_START],
                 a->r[AXIS_VELOCITY_START], a->memory, a->mode, room);
}

void axis_tell(axis *a)
{
    double room[AXIS_ROOM];
    inputs(a, 0.0);
    motion_tell(a->r + AXIS_LAW, a->c, a->u, held, a->memory, a->mode, room, a->r);
}

void axis_init(axis *a)
{
    static const double start[] = AXIS_START_VALUES;
    memset(a, 0, sizeof *a);
    memcpy(a->r, start, sizeof a->r);
    axis_set(a);
    axis_start(a);
}

void axis_set(axis *a)
{
    const double *r = a->r;
    double *c = a->c;
    AXIS_CONSTANTS_FROM(r)
}
