/*
 * The velocity w at the share t of a step of h seconds solves
 *
 *     (m + t h d + (t h)^2 k) w + t h F_f(w) = m v + t h F,
 *
 * d and k the damping and the stiffness of the drive; then v' = v + (w - v) / t, q' = q + h w.
 * Where a law has states, F_f(w) is its force after t h at constant w. t = 1/2 is the implicit
 * midpoint rule; one step and two of half its length are extrapolated to order 4. Where bristles
 * swing by y rad in a step, t = 1/2 + 0.003 y^4, which keeps their swing from growing. t = 1 is
 * backward Euler, for a velocity that decays within a step. Steps whose error by Simpson's rule
 * exceeds the tolerance are halved. A law without states stops at the instant at which its
 * velocity is zero and breaks away at that at which the force passes its level: both are located.
 * In between, where its velocity decays by little within a step, steps are explicit, by Nystroem's
 * method of order 4, halved where their error asks for it. Numbers by name, such as STIFF, stand in axis_model.h.
 */
#include "axis.h"

#include <math.h>
#include <string.h>

#include "axis_parts.h"

static double least(double a, double b)
{
    return b < a ? b : a;
}

static double most(double a, double b)
{
    return b > a ? b : a;
}

/* Friction at the end of a span h at speed v from the states z; their new values into out. */
static double rubs(axis *a, double v, double h, const double *z, double *out)
{
#if AXIS_STATES > 0
    double F;
    memcpy(a->law.z, z, sizeof a->law.z);
    F = friction_force(&a->law, v, h);
    memcpy(out, a->law.z, sizeof a->law.z);
    return F;
#else
    (void)z;
    (void)out;
    return friction_force(&a->law, v, h);
#endif
}

/* Mass, force, damping and stiffness of the drive under the inputs u; the law is told its loads. */
static void driven(axis *a, const double *u, double q, double v, double *m, double *F, double *d,
                   double *k)
{
    const double *c = a->c;
    double *load = a->load;
    load[2] = u[0];
    load[3] = q;
    load[4] = u[1];
    *m = c[0];
    *d = 0.0;
#if AXIS_DRIVE == AXIS_PARTS
    {
        double slope[2] = {0.0, 0.0}, share = 1.0, at = q, demand = a->demand, force = 0.0;
        if (AXIS_HAS_WAY) { /* the motor's position, and how fast that grows with the load's */
            at = axis_way(q, q, v, u, c, slope);
            share = slope[0];
            slope[0] = 0.0;
        }
        if (c[C_HOLD] == 0.0) {
            demand = u[U_FEED_FORWARD] + axis_demand(0.0, at, share * v, u, c, slope);
            if (!(fabs(demand) < c[C_LIMIT])) {
                demand = copysign(c[C_LIMIT], demand);
                slope[0] = slope[1] = 0.0;
            }
        }
        if (u[U_ENABLED] > 0.5) {
            force = axis_motor(demand + u[U_ADDED], at, share * v, u, c, slope);
            if (fabs(force) >= c[C_FORCE_LIMIT]) {
                force = copysign(c[C_FORCE_LIMIT], force);
                slope[0] = slope[1] = 0.0;
            }
            if (c[C_MOTOR_FRICTION] > 0.0) { /* the motor's own friction takes its share */
                if (fabs(force) <= c[C_MOTOR_FRICTION]) {
                    force = slope[0] = slope[1] = 0.0;
                } else {
                    force -= copysign(c[C_MOTOR_FRICTION], force);
                }
            }
        } else {
            slope[0] = slope[1] = 0.0;
        }
        load[0] = share * axis_transmission(force, at, share * v, u, c, slope);
        slope[0] *= share * share;
        slope[1] *= share * share;
        load[1] = u[U_EXTERNAL] + axis_position(0.0, q, v, u, c, slope);
        load[1] = axis_load(load[1], q, v, u, c, slope);
        *k = slope[0];
        *d = slope[1];
        *F = load[0] + *d * v + load[1];
    }
#else
    {
        double e = u[2] - q, gain = e > 0.0 ? c[1] : c[2], motor = gain * e + u[3];
        (void)v;
        *k = e > 0.0 ? c[3] : c[4];
        load[0] = *k * e + most(motor - c[5], 0.0) + least(motor + c[5], 0.0);
        load[1] = 0.0;
        *F = load[0];
        if (fabs(motor) > c[5]) {
            *k += gain;
        }
    }
#endif
#if AXIS_LOADED
    memcpy(a->law.load, load, sizeof a->law.load);
#endif
}

/* The root of M w + h s F_f(s w) - P near v by secants; nan if they do not lead there. */
static double quick(axis *a, double M, double P, double h, double s, double v, const double *z,
                    double *out, int at, double bottom)
{
    double w = v, g = M * w + h * s * rubs(a, s * w, h, z, out) - P;
    double slope = M + h * a->slopes[at], other = w - g / slope, g_other;
    int i;
    if (other > bottom && fabs(other - w) <= SAME * fabs(other) + NOISE * fabs(P) / slope) {
        return other;
    }
    for (i = 0; i < FEW; i++) {
        if (!(other > bottom) || other == w) {
            break;
        }
        g_other = M * other + h * s * rubs(a, s * other, h, z, out);
        g_other -= P;
        slope = (g_other - g) / (other - w);
        if (!(slope > 0.0)) {
            break;
        }
        w = other;
        g = g_other;
        other = w - g / slope;
        if (fabs(other - w) <= NEAR * fabs(other) + NOISE * fabs(P) / slope) {
            if (!(other > bottom)) {
                break;
            }
            a->slopes[at] = most((slope - M) / h, -0.5 * M / h);
            return other;
        }
    }
    a->slopes[at] = 0.0;
    return NAN;
}

/* The root of M w + h s F_f(s w) - P between two points of opposite sign: false position as
   improved by Anderson and Bjoerck (1973, doi 10.1007/BF01951936). */
static double root(axis *a, double M, double P, double h, double s, const double *z, double *out,
                   double low, double g_low, double high, double g_high)
{
    double w = low, g, m;
    int k, side = 0;
    if (g_low == 0.0) {
        return low;
    }
    if (g_high == 0.0) {
        return high;
    }
    for (k = 0; k < MOST; k++) {
        /* Past a score of tries, every other one halves the bracket. */
        w = low - g_low * (high - low) / (g_high - g_low);
        if (!(low < w && w < high) || (k > 20 && k % 2 != 0)) {
            w = 0.5 * (low + high);
        }
        g = M * w + h * s * rubs(a, s * w, h, z, out) - P;
        if (g == 0.0 || high - low <= FINE * (fabs(low) + fabs(high))) {
            return w;
        }
        if (g < 0.0) {
            if (side < 0) {
                m = 1.0 - g / g_low;
                g_high *= m > 0.0 ? m : 0.5;
            }
            if (w - low <= FINE * fabs(w) && k > 0) {
                return w;
            }
            low = w;
            g_low = g;
            side = -1;
        } else {
            if (side > 0) {
                m = 1.0 - g / g_high;
                g_low *= m > 0.0 ? m : 0.5;
            }
            if (high - w <= FINE * fabs(w) && k > 0) {
                return w;
            }
            high = w;
            g_high = g;
            side = 1;
        }
    }
    return w;
}

#if AXIS_STATES > 0
/* The velocity at the end of a step for a law with states: steps of growing length, downhill from
   the velocity before, until the residual changes sign. */
static double solved(axis *a, double M, double P, double h, double v, const double *z, double *out,
                     int at)
{
    double w = quick(a, M, P, h, 1.0, v, z, out, at, -HUGE_VAL), g, stride, other, g_other;
    int k;
    if (w == w) {
        return w;
    }
    w = v;
    g = M * w + h * rubs(a, w, h, z, out) - P;
    if (g == 0.0) {
        return w;
    }
    stride = -g / M;
    for (k = 0; k < MOST; k++) {
        other = w + stride;
        g_other = M * other + h * rubs(a, other, h, z, out) - P;
        if ((g_other >= 0.0) != (g > 0.0) || g_other == 0.0) {
            if (g > 0.0) {
                return root(a, M, P, h, 1.0, z, out, other, g_other, w, g);
            }
            return root(a, M, P, h, 1.0, z, out, w, g, other, g_other);
        }
        w = other;
        g = g_other;
        stride = 2.0 * stride;
    }
    return w;
}
#else
/* The velocity at the end of a step, of the same sign as P; 0 where it sticks. All is mirrored so
   that P > 0, and the largest root is taken: from a slide in progress the one that goes on. */
static double solved(axis *a, double M, double P, double h, double v, const double *z, double *out,
                     int at)
{
    double s = P > 0.0 ? 1.0 : -1.0, w, start, low, g_low, high, g_high, g;
    if (P == 0.0) {
        return 0.0;
    }
    P = s * P;
    if (s * v > 0.0) {
        w = quick(a, M, P, h, s, s * v, z, out, at, 0.0);
        if (w > 0.0) {
            return s * w;
        }
    }
    start = s * h * rubs(a, s * 0.0, h, z, out) - P;
    low = 0.0;
    g_low = start;
    high = P / M;
    w = s * v;
    if (!(0.0 < w && w < high)) {
        if (start >= 0.0) {
            return 0.0;
        }
        w = least(-start / M, 0.5 * high);
    }
    g = M * w + s * h * rubs(a, s * w, h, z, out) - P;
    if (g >= 0.0 && start >= 0.0) { /* a slide may go on where a start could not */
        g_high = g;
        while (g > 0.0) {
            high = w;
            g_high = g;
            w -= g / M;
            if (w <= 0.0) {
                return 0.0;
            }
            g = M * w + s * h * rubs(a, s * w, h, z, out) - P;
            if (high - w <= FINE * high) {
                return s * w;
            }
            if (g >= g_high) {
                return 0.0;
            }
        }
        low = w;
        g_low = g;
    } else if (g >= 0.0) {
        high = w;
        g_high = g;
    } else {
        low = w;
        g_low = g;
        g_high = s * h * rubs(a, s * high, h, z, out);
    }
    return s * root(a, M, P, h, s, z, out, low, g_low, high, g_high);
}
#endif

/* The velocity after a span, the share t of h, under the inputs u there; states after h. */
static double step(axis *a, const double *u, double span, double h, double q, double v,
                   double guess, const double *z, double *out, int at)
{
    double m, F, d, k, M, w = guess;
    int i;
    for (i = 0; i < (AXIS_LOADED ? 2 : 1); i++) { /* loads are those at the velocity looked for */
        double q_near = q + span * w;
        driven(a, u, q_near, w, &m, &F, &d, &k);
        k = most(k, -0.5 * m / (span * span));
        F += k * (q_near - q);
        M = m + span * d + span * span * k;
#if AXIS_DRIVE == AXIS_SLIDE
        if (a->c[6] > 0.0 || a->c[7] > 0.0) {
            /* The motor's inertia and damping, clamped: implicit, and beyond it a constant. */
            double back;
            w = solved(a, M + a->c[6] + span * a->c[7], (m + a->c[6]) * v + span * F, span, w, z,
                       out, at);
            back = a->c[6] * (w - v) / span + a->c[7] * w;
            if (fabs(back) > a->c[8]) {
                F -= back > 0.0 ? a->c[8] : -a->c[8];
                w = solved(a, M, m * v + span * F, span, w, z, out, at);
            }
        } else
#endif
        {
            w = solved(a, M, m * v + span * F, span, w, z, out, at);
        }
    }
    if (AXIS_STATES > 0) {
        (void)rubs(a, w, h, z, out);
    }
    return w;
}

/* The acceleration in an instant; at rest the sign of a zero says which way it goes. */
static double acceleration(axis *a, const double *u, double q, double v, const double *z,
                           double *out)
{
    double m, F, d, k;
    driven(a, u, q, v, &m, &F, &d, &k);
    F -= d * v + rubs(a, v, 0.0, z, out);
#if AXIS_DRIVE == AXIS_SLIDE
    if (a->c[6] > 0.0 || a->c[7] > 0.0) {
        double all = (F - a->c[7] * v) / (m + a->c[6]), back = a->c[6] * all + a->c[7] * v;
        return fabs(back) > a->c[8] ? (F - (back > 0.0 ? a->c[8] : -a->c[8])) / m : all;
    }
#endif
    return F / m;
}

static const int places[] = AXIS_PLACES, held[] = AXIS_HELD;

/* The inputs at a share of a span of h: those that are held keep their value. */
static void inputs(const axis *a, double h, double share, double *u)
{
    int i;
    for (i = 0; i < AXIS_PLACES_OF_INPUTS; i++) {
        u[i] = i == U_ENABLED ? 1.0 : 0.0;
    }
    for (i = 0; i < AXIS_INPUTS; i++) {
        u[places[i]] = a->r[AXIS_FIRST_INPUT + i];
        if (share > 0.0 && !held[i]) {
            u[places[i]] += share * (h * a->rate[i]);
        }
    }
}

#if AXIS_STATES == 0
/* How far the force on an axis at rest is beyond its breakaway level, and which way it goes. */
static double beyond(axis *a, double span, double share, double *way)
{
    double u[AXIS_PLACES_OF_INPUTS], m, F, d, k, none[1] = {0.0};
    inputs(a, span, share, u);
    driven(a, u, a->q, 0.0, &m, &F, &d, &k);
    *way = F > 0.0 ? 1.0 : -1.0;
    return *way * (F - rubs(a, *way * 0.0, 0.0, none, none));
}

/* Share of a span up to which an axis rests from the share `low` on, and which way it goes then;
   `high` where it rests all the time. By false position, Illinois. */
static double breakaway(axis *a, double span, double low, double high, double *way)
{
    double g_low = beyond(a, span, low, way), middle = 0.5 * (low + high), g_high, share, g, to;
    int i, side = 0;
    if (g_low > 0.0) {
        return low;
    }
    g_high = beyond(a, span, middle, way);
    if (g_high > 0.0) {
        high = middle;
    } else {
        low = middle;
        g_low = g_high;
        g_high = beyond(a, span, high, way);
        if (!(g_high > 0.0)) {
            return high;
        }
    }
    for (i = 0; i < INSTANTS && high - low > INSTANT; i++) {
        share = high - g_high * (high - low) / (g_high - g_low);
        if (!(low < share && share < high) || i % 3 == 2) { /* halved at least that often */
            share = 0.5 * (low + high);
        }
        g = beyond(a, span, share, &to);
        if (g > 0.0) {
            high = share;
            g_high = g;
            *way = to;
            g_low *= side > 0 ? 0.5 : 1.0;
            side = 1;
        } else {
            low = share;
            g_low = g;
            g_high *= side < 0 ? 0.5 : 1.0;
            side = -1;
        }
    }
    return high;
}
#endif

#ifdef R_dv
/* A slide starts to move, at the speed dv, when what pushes it beyond its level amounts to the
   impulse dp, and rests when it is as slow again; its law has no states. Passes h seconds of rest
   from the share `from` of a span to `to`: 0, or 1 or -1 where it starts to move that way in
   between. */
static int started(axis *a, double h, double span, double from, double to)
{
    double way, gain, last;
    gain = most(beyond(a, span, from, &way), 0.0);
    gain *= 0.5 * h * way;
    last = beyond(a, span, to, &way);
    gain += 0.5 * h * way * most(last, 0.0);
    if (last <= 0.0) { /* at the end it is held */
        a->push = 0.0;
        return 0;
    }
    if (fabs(a->push + gain) >= a->r[R_dp]) {
        return a->push + gain > 0.0 ? 1 : -1;
    }
    a->push += gain;
    return 0;
}
#endif

/* Keep the rate at which friction lets a velocity decay and the square of that at which bristles
   swing, as the slopes of a step that was tried show. */
static void keep_rates(axis *a, double t, double h)
{
    double slope = a->slopes[0], coarse = a->slopes[1];
    if (slope == 0.0 || coarse == 0.0) { /* unknown */
        return;
    }
    if (AXIS_STATES > 0) {
        a->spring = most((coarse - slope) / (0.5 * t * h * a->c[0]), 0.0);
        slope -= coarse - slope;
    }
    a->decay = slope / a->c[0];
}

/* The level of steps of half a piece, or shorter. */
static int halved(int level, double piece)
{
    level += 1;
    while (level < FINEST && pow(0.5, level) > 0.51 * piece) {
        level += 1;
    }
    return level;
}

#if AXIS_STATES == 0
/* A step of h seconds, a share of a span, from its share `from` on, of an axis that does not get as
   slow as `band` in it: position, velocity and acceleration after it, and its error (HUGE_VAL where
   it gets too slow within). The acceleration is a parabola through its values at the start, the
   middle and the end; the error is at most a third of the second difference of these, and is told
   by Boole's rule, with the accelerations at the quarters, where that is too much. */
static double explicit_step(axis *a, double span, double from, double share, double h, double base,
                            double way, double band, double a_0, double tolerance, double *q_1,
                            double *v_1, double *a_1, double *rate)
{
    double u[AXIS_PLACES_OF_INPUTS], none[1] = {0.0}, q = a->q, v = a->v;
    double at = 0.5, v_s = v + 0.5 * h * a_0, q_s = q + 0.5 * h * (v + 0.25 * h * a_0), now;
    double a_2 = a_0, a_3 = a_0, a_4 = a_0, a_m = a_0, a_q = a_0;
    double slope = 0.0, bend = 0.0, error = 0.0;
    int stage;
    *q_1 = q;
    *v_1 = v;
    *a_1 = a_0;
    *rate = 0.0;
    for (stage = 0; stage < 6; stage++) {
        if (!(way * v_s > band)) {
            return HUGE_VAL;
        }
        if (stage != 1 && stage != 3) {
            inputs(a, span, from + at * share, u);
        }
        now = acceleration(a, u, q_s, v_s, none, none);
        if (stage == 0) {
            a_2 = now;
            v_s = v + 0.5 * h * now;
        } else if (stage == 1) {
            a_3 = now;
            at = 1.0;
            v_s = v + h * now;
            q_s = q + h * (v + 0.5 * h * now);
            if (fabs(a_2 - a_0) * h > DISTINCT * fabs(v)) {
                *rate = 2.0 * (a_2 - a_3) / (h * (a_2 - a_0));
            }
        } else if (stage == 2) {
            a_4 = now;
            *v_1 = v_s = v + h * (a_0 + 2.0 * (a_2 + a_3) + a_4) / 6.0;
            *q_1 = q_s = q + h * (v + h * (a_0 + a_2 + a_3) / 6.0);
        } else if (stage == 3) {
            *a_1 = now;
            a_m = 0.5 * (a_2 + a_3);
            slope = 4.0 * a_m - 3.0 * a_0 - now;
            bend = a_0 - 2.0 * a_m + now;
            error = base * h * (fabs(now - a_4) / 6.0 + fabs(bend) / 3.0);
            if (error <= tolerance) {
                break;
            }
            at = 0.25;
        } else if (stage == 4) {
            a_q = now;
            at = 0.75;
        } else {
            double faster = 7.0 * (a_0 + *a_1) + 32.0 * (a_q + now) + 12.0 * a_m;
            double further = 7.0 * a_0 + 24.0 * a_q + 6.0 * a_m + 8.0 * now;
            error = base * fabs(v + h * faster / 90.0 - *v_1);
            error = SURE * (error + fabs(q + h * v + h * h * further / 90.0 - *q_1));
        }
        if (stage >= 3) {
            v_s = v + h * at * (a_0 + at * (0.5 * slope + at * bend * 2.0 / 3.0));
            q_s = q + h * at * (v + h * at * (0.5 * a_0 + at * (slope + at * bend) / 6.0));
        }
    }
    return error;
}
#endif

#if AXIS_DRIVE == AXIS_PARTS
/* The position that a sampled controller reads. */
static double seen(const axis *a, double q)
{
    double step = a->c[C_RESOLUTION];
    return step > 0.0 ? step * rint(q / step) : q;
}

/* Position and velocity of the motor, which a sampled controller reads. */
static void motor_at(const axis *a, const double *u, double *q, double *v)
{
    double slope[2] = {1.0, 0.0};
    *q = axis_way(a->q, a->q, a->v, u, a->c, slope);
    *v = slope[0] * a->v;
}

/* What a sampled controller remembers at its start: an axis at a constant velocity. */
static void came(axis *a, const double *u)
{
    double q, v;
    motor_at(a, u, &q, &v);
    a->last = seen(a, q - a->c[C_T] * v);
    a->second = seen(a, q - 2.0 * a->c[C_T] * v);
    a->integral = 0.0;
}

/* The demand that a sampled controller computes at a sample, under the inputs u there. */
static double computed(axis *a, const double *u)
{
    const double *c = a->c;
    double q, v, demand, slope[2] = {0.0, 0.0};
    motor_at(a, u, &q, &v);
    q = seen(a, q);
    if (c[C_DIFFERENCE] > 0.5) {
        v = (q - a->second) / (2.0 * c[C_T]);
    }
    demand = axis_demand(0.0, q, v, u, c, slope);
    if (c[C_K_I] > 0.0) {
        a->integral += c[C_K_I] * c[C_T] * demand;
        a->integral = least(most(a->integral, -c[C_LIMIT]), c[C_LIMIT]);
    }
    demand += u[U_FEED_FORWARD] + a->integral;
    a->second = a->last;
    a->last = q;
    return least(most(demand, -c[C_LIMIT]), c[C_LIMIT]);
}
#endif

int axis_step(axis *a, double span)
{
    double u[AXIS_PLACES_OF_INPUTS];
    double coarse[AXIS_BRISTLES], half[AXIS_BRISTLES], fine[AXIS_BRISTLES];
    double n = most(ceil(span / a->r[AXIS_STEP] - 1e-9), 1.0), base = span / n, tries, j;
    double tolerance = a->r[AXIS_TOLERANCE], band = 0.0, m, F, d, k;
    int i;
    if (span == 0.0) {
        return 0;
    }
    if (!(n <= 1e9)) {
        return 1;
    }
#ifdef R_dv
    band = most(a->r[R_dv], 0.0);
#endif
#if AXIS_DRIVE == AXIS_PARTS
    if (a->c[C_HOLD] > 0.0) { /* the demand that the controller computes now, or had before */
        double now;
        inputs(a, span, 0.0, u);
        now = computed(a, u);
        a->demand = a->c[C_HOLD] == 1.0 ? now : a->before;
        a->before = now;
    }
#endif
    tries = ROOM + EACH * n;
    for (j = 0.0; j < n; j += 1.0) {
        double at = 0.0, stop = 0.0, way = 0.0, a_0 = 0.0;
        int level = 0, looks = 0, stops = 0, fresh = 1, damped;
#if AXIS_STATES == 0
        int easy;
#endif
        inputs(a, span, j / n, u);
        driven(a, u, a->q, a->v, &m, &F, &d, &k);
        damped = (a->decay + d / m) * base > STIFF || a->spring * base * base > FAST;
#if AXIS_STATES == 0
        easy = !damped;
#endif
        while (at < 1.0) {
            double piece, h, from, share, t, weight, w_c, w_1, w_2, v_c, v_h, v_f, q_f, v_1, q_1;
            double left, error, a_1;
            int shortest;
            tries -= 1.0;
            if (tries < 0.0) {
                return 1;
            }
#ifdef R_dv
            if (band > 0.0 && a->v == 0.0) {
                piece = least(pow(0.5, level), 1.0 - at);
                i = started(a, base * piece, span, (j + at) / n, (j + at + piece) / n);
                if (i != 0 && level < FINEST) {
                    level += 1;
                    continue;
                }
                if (i != 0) {
                    a->v = i * band;
                    a->push = 0.0;
                    fresh = 1;
                } else if (level > 0) {
                    level -= 1;
                }
                at += piece;
                at = at > 1.0 - NONE ? 1.0 : at;
                continue;
            }
#endif
#if AXIS_STATES == 0
            way = a->v > 0.0 ? 1.0 : -1.0;
            if (a->v == 0.0) {
                at = breakaway(a, span, (j + at) / n, (j + 1.0) / n, &way) * n - j;
                if (at >= 1.0 - NONE) {
                    break;
                }
                a->v = way * 0.0;
            }
#endif
            piece = least(pow(0.5, level), 1.0 - at);
            if (0.0 < stop && stop < piece) {
                piece = stop;
            }
            h = base * piece;
            from = (j + at) / n;
            share = piece / n;
            shortest = piece <= pow(0.5, FINEST);
            t = a->spring * h * h;
            t = damped ? 1.0 : least(0.5 + SWING * t * t, 1.0);
            if (fresh) {
                inputs(a, span, from, u);
                a_0 = acceleration(a, u, a->q, a->v, a->z, half);
                fresh = 0;
            }
#if AXIS_STATES == 0
            if (easy && stop == 0.0 && most(fabs(a->decay), d / m) * h <= MILD) {
                double rate;
                error = explicit_step(a, span, from, share, h, base, way, band, a_0, tolerance,
                                      &q_1, &v_1, &a_1, &rate);
                rate -= d / m;
                if (error <= tolerance && way * v_1 > band && fabs(rate) * h <= MILD) {
                    a->decay = rate;
                    a->q = q_1;
                    a->v = v_1;
                    a_0 = a_1;
                    at += piece;
                    at = at > 1.0 - NONE ? 1.0 : at;
                    if (!(fabs(a->q) < 1e12 && fabs(a->v) < 1e12)) {
                        return 1;
                    }
                    if (level > 0 && error * GROW <= tolerance) {
                        level -= 1;
                    }
                    continue;
                }
                if (tolerance < error && error < HUGE_VAL && fabs(rate) * h <= MILD && !shortest) {
                    level = halved(level, piece);
                    continue;
                }
                easy = 0;
            }
#endif
            inputs(a, span, from + t * share, u);
            w_c = step(a, u, t * h, h, a->q, a->v, a->v + t * h * a_0, a->z, coarse, 1);
            inputs(a, span, from + 0.5 * t * share, u);
            w_1 = step(a, u, 0.5 * t * h, 0.5 * h, a->q, a->v, 0.5 * (a->v + w_c), a->z, half, 0);
            v_h = a->v + (w_1 - a->v) / t;
            inputs(a, span, from + 0.5 * (1.0 + t) * share, u);
            w_2 = step(a, u, 0.5 * t * h, 0.5 * h, a->q + 0.5 * h * w_1, v_h,
                       t < 1.0 ? 2.0 * w_c - w_1 : w_c, half, fine, 0);
            keep_rates(a, t, h);
            weight = (4.0 * t - 1.0) / 3.0;
            v_c = a->v + (w_c - a->v) / t;
            v_f = v_h + (w_2 - v_h) / t;
            q_f = a->q + 0.5 * h * (w_1 + w_2);
            v_1 = v_f + weight * (v_f - v_c);
            q_1 = q_f + weight * (q_f - a->q - h * w_c);
            left = h;
            if (AXIS_STATES == 0 && t < 1.0) {
                double over = v_1 - way * band; /* what is left to the speed at which it stops */
                if (way * w_c <= 0.0 || way * w_1 <= 0.0 || way * w_2 <= 0.0) {
                    /* It stops far within; or is held where a law jumps. */
                    damped = shortest;
                    level = damped ? 0 : halved(level, piece);
                    stop = 0.0;
                    continue;
                }
                if (way * over <= 0.0 || stop > 0.0) { /* how long it moves yet, on a parabola */
                    left = h * over / (4.0 * v_h - a->v - 3.0 * v_1);
                }
                if (way * over <= 0.0 && fabs(over) > CLOSE * fabs(a->v)) {
                    stop = piece + left / base;
                    looks += 1;
                    if (!(0.0 < stop && stop < piece)) {
                        stop = piece * (a->v - way * band) / (a->v - v_1);
                    }
                    if (looks > LOOKS || !(0.0 < stop && stop < piece)) {
                        level = halved(level, piece);
                        stop = 0.0;
                        looks = 0;
                    }
                    if (band > 0.0 && fabs(a->v) <= band) { /* it has hardly begun */
                        a->v = 0.0;
                        stop = 0.0;
                    }
                    continue;
                }
            } else if (AXIS_STATES == 0 && v_1 * v_f <= 0.0) { /* extrapolated past the stop */
                v_1 = v_f;
            }
            for (i = 0; i < AXIS_STATES; i++) {
                double difference = fine[i] - coarse[i];
                fine[i] += weight * difference;
                half[i] += 0.5 * weight * difference;
            }
            if (t < 1.0) {
                double v_m, a_m, v_end = way == 0.0 || way * v_1 > 0.0 ? v_1 : way * 0.0;
                inputs(a, span, from + share, u);
                a_1 = acceleration(a, u, q_1, v_end, fine, coarse);
                v_m = 0.5 * (a->v + v_1) + 0.125 * h * (a_0 - a_1);
                inputs(a, span, from + 0.5 * share, u);
                a_m = acceleration(a, u, 0.5 * (a->q + q_1) + 0.125 * h * (a->v - v_1), v_m, half,
                                   coarse);
                error = base * fabs(a->v + h * (a_0 + 4.0 * a_m + a_1) / 6.0 - v_1);
                error += fabs(a->q + h * (a->v + h * (a_0 + 2.0 * a_m) / 6.0) - q_1);
            } else {
                v_h += 0.5 * (v_f - v_c);
                error = h * fabs(v_f - v_c);
                error += fabs(a->q + h * (a->v + 4.0 * v_h + v_1) / 6.0 - q_1);
                a_1 = 0.0;
                fresh = 1;
            }
            if (!(error <= tolerance) && !(shortest && damped)) {
                stop = 0.0;
                looks = 0;
                fresh = damped;
                level = halved(level, piece);
                if (!damped && (shortest || (a->decay + d / m) * h > STIFF)) {
                    damped = 1;
                    level = 0;
                }
                continue;
            }
            if (fabs(left) < h && fabs(v_1 - way * band) <= CLOSE * fabs(a->v)) {
                q_1 += 0.5 * left * (v_1 - way * band); /* to the instant at which it stops */
                piece = least(piece + left / base, 1.0 - at);
                v_1 = 0.0;
                stops += 1;
                if (stops > STOPS) {
                    damped = 1;
                }
            }
            if (AXIS_STATES == 0 && fabs(v_1) <= band) {
                v_1 = 0.0;
            }
            a->q = q_1;
            a->v = v_1;
            a_0 = a_1;
            at += piece;
            at = at > 1.0 - NONE ? 1.0 : at;
            stop = 0.0;
            looks = 0;
            fresh = fresh || v_1 == 0.0;
            for (i = 0; i < AXIS_STATES; i++) {
                a->z[i] = fine[i];
            }
            if (!(fabs(a->q) < 1e12 && fabs(a->v) < 1e12)) {
                return 1;
            }
            if (level > 0 && error * (t < 1.0 ? GROW : GROW_DAMPED) <= tolerance) {
                level -= 1;
            }
        }
    }
    for (i = 0; i < AXIS_INPUTS; i++) { /* where a changing input has got to, it stays */
        if (!held[i]) {
            a->r[AXIS_FIRST_INPUT + i] += span * a->rate[i];
        }
        a->rate[i] = 0.0;
    }
    return !(fabs(a->q) < 1e12 && fabs(a->v) < 1e12);
}

void axis_start(axis *a)
{
    double u[AXIS_PLACES_OF_INPUTS], m, F, d, k;
    int i;
    a->q = a->r[AXIS_POSITION_START];
    a->v = a->r[AXIS_VELOCITY_START];
    a->slopes[0] = a->slopes[1] = a->decay = a->spring = a->before = a->push = a->demand = 0.0;
    for (i = 0; i < AXIS_BRISTLES; i++) {
        a->z[i] = 0.0;
    }
    inputs(a, 0.0, 0.0, u);
#if AXIS_DRIVE == AXIS_PARTS
    came(a, u);
    if (a->c[C_HOLD] > 0.0) {
        a->demand = a->before = computed(a, u);
        came(a, u);
    }
#endif
    driven(a, u, a->q, a->v, &m, &F, &d, &k);
    F -= d * a->v;
#if AXIS_STATES > 0
    {
        double relaxed[AXIS_BRISTLES], s = F < 0.0 ? -1.0 : 1.0, low = 0.0, high = SHORT, way;
        memcpy(relaxed, a->z, sizeof relaxed);
        if (a->v != 0.0) {
            (void)rubs(a, a->v, LONG / fabs(a->v), relaxed, a->z);
            return;
        }
        for (i = 0; i < DOUBLINGS; i++) {
            if (s * rubs(a, s * high / SLOW, SLOW, relaxed, a->z) >= s * F) {
                break;
            }
            low = high;
            high = 2.0 * high;
        }
        for (i = 0; i < DOUBLINGS; i++) {
            way = 0.5 * (low + high);
            if (s * rubs(a, s * way / SLOW, SLOW, relaxed, a->z) < s * F) {
                low = way;
            } else {
                high = way;
            }
        }
        (void)rubs(a, s * low / SLOW, SLOW, relaxed, a->z);
    }
#endif
}

void axis_tell(axis *a)
{
    double u[AXIS_PLACES_OF_INPUTS], m, F, d, k, rub, out[AXIS_BRISTLES];
    inputs(a, 0.0, 0.0, u);
    driven(a, u, a->q, a->v, &m, &F, &d, &k);
    if (AXIS_STATES > 0 || a->v != 0.0) {
        rub = rubs(a, a->v, 0.0, a->z, out);
    } else { /* what holds the axis is as large as what pulls at it */
        rub = least(most(F, rubs(a, -0.0, 0.0, a->z, out)), rubs(a, 0.0, 0.0, a->z, out));
    }
    a->r[AXIS_POSITION] = a->q;
    a->r[AXIS_VELOCITY] = a->v;
    a->r[AXIS_DRIVE_FORCE] = a->load[0];
    a->r[AXIS_FRICTION] = rub;
}

void axis_init(axis *a)
{
    static const double start[] = AXIS_START_VALUES;
    memset(a, 0, sizeof *a);
    memcpy(a->r, start, sizeof a->r);
    friction_init(&a->law);
    axis_set(a);
    axis_start(a);
}

void axis_set(axis *a)
{
    const double *r = a->r;
    double *c = a->c;
    memcpy(a->law.p, r + AXIS_LAW, sizeof a->law.p);
    memset(c, 0, sizeof a->c);
    AXIS_CONSTANTS_FROM(r)
#if AXIS_DRIVE == AXIS_SLIDE
    if (!(c[8] > 0.0)) { /* a clamp at 0 leaves no motor */
        c[6] = c[7] = 0.0;
    }
#endif
}
