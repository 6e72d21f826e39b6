/*
 * An axis under friction that is stepped through time. SI throughout.
 *
 * axis_model.h says where its values stand, axis_motion.h how it moves.
 */
#ifndef AXIS_H
#define AXIS_H

#include "axis_model.h"

/* All of an axis, without a pointer: a copy of it is a copy of its state. */
typedef struct {
    double r[AXIS_VALUES];            /* outputs, inputs, parameters, as references count them */
    double rate[AXIS_INPUTS];         /* of inputs that change within a step, per second */
    double c[AXIS_WIDTH];             /* what the drive makes of its parameters */
    double u[2 * AXIS_PLACES_OF_INPUTS]; /* the inputs by their places, at both ends of a step */
    double memory[AXIS_MEMORY];       /* its state, and what its stepper and controller remember */
    int mode[AXIS_MODES];             /* where an axis of two masses rests, and its coupling is */
} axis;

/* The identified axis. */
void axis_init(axis *a);

/* Values have been set: make the drive's constants of them. */
void axis_set(axis *a);

/* To the start: at rest as far as the force there lets bristles hold, or in steady motion. */
void axis_start(axis *a);

/* Pass h seconds; 0, or 1 where the motion runs away or takes too many steps. */
int axis_step(axis *a, double h);

/* Make the outputs of state and inputs. */
void axis_tell(axis *a);

#endif
