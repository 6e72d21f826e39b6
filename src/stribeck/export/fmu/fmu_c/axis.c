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
    double coarse[AXIS_BRISTLES], half[AXIS_BRISTLES], fine[AXIS_BRISTLES];
    double u[AXIS_PLACES_OF_INPUTS], n = ceil(h / a->r[AXIS_STEP] - 1e-9);
    static const int places[] = AXIS_PLACES;
    int i, passed;
    if (!(n <= AXIS_MOST_STEPS)) {
        return 1;
    }
    inputs(a, h);
    passed = motion_advance(a->r + AXIS_LAW, a->c, a->u, held, n > 1.0 ? (int)n : 1, h,
                            a->r[AXIS_TOLERANCE], a->at, a->z, coarse, half, fine, u, a->load,
                            a->memory, a->last);
    for (i = 0; i < AXIS_INPUTS; i++) { /* where a changing input has got to, it stays */
        a->r[AXIS_FIRST_INPUT + i] = a->u[2 * places[i] + 1];
        a->rate[i] = 0.0;
    }
    return !passed;
}

void axis_start(axis *a)
{
    double relaxed[AXIS_BRISTLES], u[AXIS_PLACES_OF_INPUTS];
    a->at[0] = a->r[AXIS_POSITION_START];
    a->at[1] = a->r[AXIS_VELOCITY_START];
    inputs(a, 0.0);
    motion_start(a->r + AXIS_LAW, a->c, a->u, held, a->at, a->z, relaxed, u, a->load, a->memory,
                 a->last);
}

void axis_tell(axis *a)
{
    double out[AXIS_BRISTLES], u[AXIS_PLACES_OF_INPUTS];
    inputs(a, 0.0);
    a->r[AXIS_FRICTION] = motion_friction(a->r + AXIS_LAW, a->c, a->u, held, a->at, a->z, out, u,
                                          a->load);
    a->r[AXIS_POSITION] = a->at[0];
    a->r[AXIS_VELOCITY] = a->at[1];
    a->r[AXIS_DRIVE_FORCE] = a->load[AXIS_DRIVE];
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
