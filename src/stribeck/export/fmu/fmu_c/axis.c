/*
 * One step of h seconds is backward Euler in the velocity, friction and the drive's damping d
 * implicit, and explicit in the position:
 *
 *     (m + h d) w + h F_f(w) = m v + h F,    q' = q + h w,
 *
 * one scalar equation for the new velocity w. Where a law sticks, w = 0 solves it as long as the
 * right side lies between the two breakaway levels times h. Where a law has states, F_f(w) is its
 * force after h at constant w. One step of h and two of h/2 are extrapolated; where they disagree
 * by more than the tolerance, the step is halved, and halved again.
 */
#include "axis.h"

#include <math.h>
#include <string.h>

/* A step is halved so often at most. */
#define FINEST 14
#define WHOLE (1 << FINEST)
/* So many halved steps may one call take, and so many more for each whole one. */
#define ROOM 1048576
#define EACH 64
/* Iterations for a velocity, and where they end, relative. */
#define MOST 80
#define FINE 1e-13
/* Secants that are tried first, how near two of them must come, relative, and rounding. */
#define FEW 6
#define NEAR 1e-7
#define NOISE 1e-15
/* Ways on which bristles are stretched at the start, m or rad, and spans that it may take, s. */
#define SHORT 1e-12
#define DOUBLINGS 45
#define LONG 10.0
#define SLOW 1e6

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

/* Mass, force and damping of the drive under the inputs u; the law is told its loads. */
static void driven(axis *a, const double *u, double q, double v, double *m, double *F, double *d)
{
    const double *c = a->c;
    double *load = a->load;
    load[2] = u[0];
    load[3] = q;
    load[4] = u[1];
    *m = c[0];
    *d = 0.0;
#if AXIS_DRIVE == AXIS_SERVO
    {
        double volts = least(most(c[5] * (u[2] - q) + u[4], -c[6]), c[6]);
        double on = u[3] > 0.5 ? 1.0 : 0.0;
        load[1] = -c[3] * sin(q + c[4]);
        load[0] = on * (c[1] * volts - c[2] * v);
        *F = on * c[1] * volts + load[1];
        *d = on * c[2];
    }
#elif AXIS_DRIVE == AXIS_JOINT
    load[1] = -(c[3] * sin(q) + c[4] * cos(q) + c[5]);
    *F = load[0] + load[1];
    if (!(c[7] > 0.0)) {
        double asked = u[4] + c[1] * (u[2] - q) + c[2] * u[3];
        load[0] = least(most(asked - c[2] * v, -c[6]), c[6]);
        *F = load[0] + load[1];
        if (fabs(asked - c[2] * v) < c[6]) {
            *F = asked + load[1];
            *d = c[2];
        }
    }
#elif AXIS_DRIVE == AXIS_FORCE
    (void)v;
    load[0] = u[2];
    load[1] = -(c[1] + c[2] * u[0] + c[3] * sin(q) + c[4] * cos(q));
    *F = load[0] + load[1];
#else
    {
        double e = u[2] - q;
        double spring = (e > 0.0 ? c[3] : c[4]) * e, motor = (e > 0.0 ? c[1] : c[2]) * e + u[3];
        (void)v;
        load[0] = spring + most(motor - c[5], 0.0) + least(motor + c[5], 0.0);
        load[1] = 0.0;
        *F = load[0];
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

/* The velocity after h under the inputs u at its end; the law's new states into out. */
static double step(axis *a, const double *u, double h, double q, double v, const double *z,
                   double *out, int at)
{
    double m, F, d, w;
    driven(a, u, q, v, &m, &F, &d);
#if AXIS_DRIVE == AXIS_SLIDE
    if (a->c[6] > 0.0 || a->c[7] > 0.0) {
        /* The motor's inertia and damping, clamped: implicit, and beyond the clamp a constant. */
        double back;
        w = solved(a, m + a->c[6] + h * a->c[7], (m + a->c[6]) * v + h * F, h, v, z, out, at);
        back = a->c[6] * (w - v) / h + a->c[7] * w;
        if (fabs(back) > a->c[8]) {
            F -= back > 0.0 ? a->c[8] : -a->c[8];
            w = solved(a, m, m * v + h * F, h, v, z, out, at);
        }
    } else
#endif
    {
        w = solved(a, m + h * d, m * v + h * F, h, v, z, out, at);
    }
    if (AXIS_STATES > 0) {
        (void)rubs(a, w, h, z, out);
    }
    return w;
}

static const int places[] = AXIS_PLACES, held[] = AXIS_HELD;

/* The inputs at a share of a step of h: those that are held keep their value. */
static void inputs(const axis *a, double h, double share, double *u)
{
    int i;
    for (i = 0; i < AXIS_PLACES_OF_INPUTS; i++) {
        u[i] = 0.0;
    }
    for (i = 0; i < AXIS_INPUTS; i++) {
        u[places[i]] = a->r[AXIS_FIRST_INPUT + i];
        if (share > 0.0 && !held[i]) {
            u[places[i]] += share * (h * a->rate[i]);
        }
    }
}

#ifdef R_dv
/* A slide starts to move when what pushes it beyond its level would have given it the speed dv,
   and rests when it is as slow again. Passes h seconds of rest from the share `from` of a span to
   `to`: 0, or 1 or -1 where it starts to move that way in between. */
static int started(axis *a, double h, double span, double from, double to)
{
    double u[AXIS_PLACES_OF_INPUTS], m, F, d, s, beyond, heavy, none[1] = {0.0}, gain = 0.0;
    int end;
    for (end = 0; end < 2; end++) {
        inputs(a, span, end ? to : from, u);
        driven(a, u, a->q, 0.0, &m, &F, &d);
        s = F > 0.0 ? 1.0 : -1.0;
        beyond = s * (F - rubs(a, s * 0.0, h, none, none));
        heavy = m + a->c[6];
        if (a->c[6] > 0.0 && beyond * a->c[6] / heavy > a->c[8]) { /* the motor's part is clamped */
            beyond -= a->c[8];
            heavy = m;
        }
        gain += 0.5 * h * s * most(beyond, 0.0) / heavy;
    }
    if (beyond <= 0.0) { /* at the end it is held */
        a->push = 0.0;
        return 0;
    }
    if (fabs(a->push + gain) >= a->r[R_dv]) {
        return a->push + gain > 0.0 ? 1 : -1;
    }
    a->push += gain;
    return 0;
}
#endif

int axis_step(axis *a, double span)
{
    double u[AXIS_PLACES_OF_INPUTS];
    double coarse[AXIS_BRISTLES], half[AXIS_BRISTLES], fine[AXIS_BRISTLES];
    double n = most(ceil(span / a->r[AXIS_STEP] - 1e-9), 1.0), base = span / n;
    double h, v_half, q_half, v_fine, v_coarse, left, j;
    int at, level, share, i;
    if (span == 0.0) {
        return 0;
    }
    if (!(n <= 1e9)) {
        return 1;
    }
#if AXIS_DRIVE == AXIS_JOINT
    if (a->c[7] > 0.0) { /* the controller holds the torque that it computes now, or had before */
        double now;
        inputs(a, span, 0.0, u);
        now = u[4] + a->c[1] * (u[2] - a->q) + a->c[2] * (u[3] - a->v);
        now = least(most(now, -a->c[6]), a->c[6]);
        a->load[0] = a->c[7] == 1.0 ? now : a->before;
        a->before = now;
    }
#endif
    left = ROOM + EACH * n;
    for (j = 0.0; j < n; j += 1.0) {
        at = 0; /* how far the step has been passed, in its 2^-FINEST parts */
        level = 0;
        while (at < WHOLE) {
            left -= 1.0;
            if (left < 0.0) {
                return 1;
            }
            share = WHOLE >> level;
            h = base * ((double)share / WHOLE);
#ifdef R_dv
            if (a->r[R_dv] > 0.0 && a->v == 0.0) {
                double from = (j + (double)at / WHOLE) / n;
                double to = (j + (double)(at + share) / WHOLE) / n;
                int way = started(a, h, span, from, to);
                if (way != 0 && level < FINEST) {
                    level += 1;
                    continue;
                }
                if (way != 0) {
                    a->v = way * a->r[R_dv];
                    a->push = 0.0;
                }
                at += share;
                if (level > 0 && at % (2 * share) == 0) {
                    level -= 1;
                }
                continue;
            }
#endif
            inputs(a, span, (j + (at + 0.5 * share) / WHOLE) / n, u);
            v_half = step(a, u, 0.5 * h, a->q, a->v, a->z, half, 0);
            q_half = a->q + 0.5 * h * v_half;
            inputs(a, span, (j + (double)(at + share) / WHOLE) / n, u);
            v_fine = step(a, u, 0.5 * h, q_half, v_half, half, fine, 0);
            v_coarse = step(a, u, h, a->q, a->v, a->z, coarse, 1);
            if (h * fabs(v_fine - v_coarse) > a->r[AXIS_TOLERANCE] && level < FINEST) {
                level += 1;
                continue;
            }
#ifdef R_dv
            if (fabs(v_fine) <= a->r[R_dv] && level < FINEST) { /* when does it come to rest? */
                level += 1;
                continue;
            }
#endif
            a->q = 2.0 * (q_half + 0.5 * h * v_fine) - (a->q + h * v_coarse);
            a->v = 2.0 * v_fine - v_coarse;
            if (AXIS_STATES == 0 && a->v * v_fine <= 0.0) { /* extrapolated past the stop */
                a->v = v_fine;
            }
            for (i = 0; i < AXIS_STATES; i++) {
                a->z[i] = 2.0 * fine[i] - coarse[i];
            }
#ifdef R_dv
            if (fabs(a->v) <= a->r[R_dv]) {
                a->v = 0.0;
            }
#endif
            at += share;
            if (level > 0 && at % (2 * share) == 0) {
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
    double u[AXIS_PLACES_OF_INPUTS], m, F, d;
    int i;
    a->q = a->r[AXIS_POSITION_START];
    a->v = a->r[AXIS_VELOCITY_START];
    a->slopes[0] = a->slopes[1] = a->before = a->push = a->load[0] = 0.0;
    for (i = 0; i < AXIS_BRISTLES; i++) {
        a->z[i] = 0.0;
    }
    inputs(a, 0.0, 0.0, u);
#if AXIS_DRIVE == AXIS_JOINT
    if (a->c[7] > 0.0) {
        a->before = u[4] + a->c[1] * (u[2] - a->q) + a->c[2] * (u[3] - a->v);
        a->before = least(most(a->before, -a->c[6]), a->c[6]);
        a->load[0] = a->before;
    }
#endif
    driven(a, u, a->q, a->v, &m, &F, &d);
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
    double u[AXIS_PLACES_OF_INPUTS], m, F, d, rub, out[AXIS_BRISTLES];
    inputs(a, 0.0, 0.0, u);
    driven(a, u, a->q, a->v, &m, &F, &d);
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
