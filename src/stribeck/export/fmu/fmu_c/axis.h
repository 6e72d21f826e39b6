/*
 * An axis under friction that is stepped through time. SI throughout.
 *
 * axis_model.h says which drive moves it, which friction brakes it, and where its values stand.
 */
#ifndef AXIS_H
#define AXIS_H

#define AXIS_SLIDE 0 /* a slide pulled through a spring and a motor under P control */
#define AXIS_PARTS 1 /* a controller, a motor, a gear and a load; what is not there is neutral */

#include "axis_model.h"
#include "friction.h"

#define AXIS_BRISTLES (AXIS_STATES > 0 ? AXIS_STATES : 1)

/* All of an axis, without a pointer: a copy of it is a copy of its state. */
typedef struct {
    double r[AXIS_VALUES];        /* outputs, inputs, parameters, as value references count them */
    double rate[AXIS_INPUTS];     /* of inputs that change within a step, per second */
    double c[AXIS_WIDTH];         /* what the drive makes of its parameters */
    double q, v;                  /* position and velocity */
    double z[AXIS_BRISTLES];      /* states of the law */
    double load[5];               /* as the law reads them */
    double demand, before;        /* of a sampled controller, in force and computed last */
    double last, second;          /* positions that it read last and before that */
    double integral;              /* what it has integrated of its demand */
    double push;                  /* impulse beyond its level at a slide at rest */
    double slopes[2];             /* how steeply friction rose when it was last asked */
    double decay, spring;         /* the rates that follow from that, 1/s and 1/s^2 */
    friction_law law;
} axis;

/* The identified axis. */
void axis_init(axis *a);

/* Values have been set: make the drive's constants and the law's parameters of them. */
void axis_set(axis *a);

/* To the start: at rest as far as the force there lets bristles hold, or in steady motion. */
void axis_start(axis *a);

/* Pass h seconds; 0, or 1 where the motion runs away or takes too many steps. */
int axis_step(axis *a, double h);

/* Make the outputs of state and inputs. */
void axis_tell(axis *a);

#endif
