/* The slide bed in fixed steps, as one would write it in C: the yardstick of benchmarks/kernel.py.
 *
 * The equations of docs/physics.md: drive force with the motor's own friction, the motor's inertia
 * solved for and then clamped, Stribeck friction, rest where the velocity falls back to the band,
 * and the dead band of the momentum while the slide is held. Semi-implicit Euler: the velocity
 * first, then the position with it.
 *
 * c: m, k_hat+, k_hat-, k_spring+, k_spring-, F_fm, K_J, K_D, clamp, dv, dp.  p: F_S, F_C, F_V, v_SS.
 */
#include <math.h>

static double drive(const double *c, double e)
{
    double motor = (e > 0.0 ? c[1] : c[2]) * e;
    double rub = fmin(fmax(motor, -c[5]), c[5]);
    return motor - rub + (e > 0.0 ? c[3] : c[4]) * e;
}

static double inertial(const double *c, double force, double v)
{
    double a = (force - c[7] * v) / (c[0] + c[6]);
    double motor = c[6] * a + c[7] * v;
    if (motor > c[8]) return (force - c[8]) / c[0];
    if (motor < -c[8]) return (force + c[8]) / c[0];
    return a;
}

static double friction(const double *p, double v, double s)
{
    return s * (p[1] + (p[0] - p[1]) * exp(-fabs(v) / p[3])) + p[2] * v;
}

/* The sum of squared misfits at n even samples; positions go to `out` unless it is null. */
double slide_bed(const double *p, const double *c, const double *knots_t, const double *knots_x,
                 long knots, double x0, long n, double rate, double dt, const double *measured,
                 double *out)
{
    long per = lround(1.0 / (rate * dt)), j = 1;
    double x = x0, v = 0.0, s = 0.0, P = 0.0, sse = 0.0;
    double slope = (knots_x[1] - knots_x[0]) / (knots_t[1] - knots_t[0]);
    double base = knots_x[0] - slope * knots_t[0];
    for (long i = 0; i < n; i++) {
        double miss = measured[i] - x;
        sse += miss * miss;
        if (out) out[i] = x;
        for (long k = 0; k < per; k++) {
            double now = ((double)(i * per + k) + 0.5) * dt; /* the middle of the step */
            while (j < knots - 1 && knots_t[j] <= now) {
                j++;
                slope = (knots_x[j] - knots_x[j - 1]) / (knots_t[j] - knots_t[j - 1]);
                base = knots_x[j - 1] - slope * knots_t[j - 1];
            }
            double e = base + slope * now - x;
            double F = drive(c, e);
            if (s == 0.0) {
                if (fabs(F) <= p[0]) {
                    P = 0.0;
                    continue;
                }
                P += dt * (F - copysign(p[0], F));
                if (fabs(P) > c[10]) {
                    s = copysign(1.0, P);
                    v = s * c[9];
                    P = 0.0;
                }
            } else {
                v += dt * inertial(c, F - friction(p, v, s), v);
                x += dt * v;
                if (s * v < c[9]) s = v = 0.0;
            }
        }
    }
    return sse;
}
