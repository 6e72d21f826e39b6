"""Mathematics in C99 where a target has no more of it than exp, tanh and fabs.

Each is good to a few units in the last place over what laws ask of it, and what is no number stays
none: a controller is to see that its sensor has failed. Doubles are IEEE 754, as on every target
that these files are for. tests/test_export_c.py measures both.
"""

from __future__ import annotations

from collections.abc import Iterable

#: Functions of a program that C has itself, and their names there.
OWN = {"abs": "fabs", "exp": "exp", "tanh": "tanh"}

#: Which of the others each needs.
_NEEDS = {
    "copysign": ("bits",),
    "sqrt": ("bits", "double"),
    "log": ("bits", "double"),
    "log1p": ("log",),
    "pow": ("log",),
    "sin": ("wave",),
    "cos": ("wave",),
}
_SOURCES = {
    "bits": """\
/* The 64 bits of a double. */
static uint64_t math_bits(double x)
{
    uint64_t b;
    memcpy(&b, &x, sizeof b);
    return b;
}
""",
    "double": """\
/* The double of 64 bits. */
static double math_double(uint64_t b)
{
    double x;
    memcpy(&x, &b, sizeof x);
    return x;
}
""",
    "min": """\
static double math_min(double a, double b)
{
    return b < a ? b : a;
}
""",
    "max": """\
static double math_max(double a, double b)
{
    return b > a ? b : a;
}
""",
    "copysign": """\
/* |a| with the sign of b, which a zero has, too. */
static double math_copysign(double a, double b)
{
    return (math_bits(b) >> 63) != 0 ? -fabs(a) : fabs(a);
}
""",
    "sqrt": """\
/* Newton's rule from half the exponent. */
static double math_sqrt(double x)
{
    double y;
    int i;
    if (!(x > 0.0 && x <= 1.7976931348623157e308)) {
        return x < 0.0 ? NAN : x;
    }
    if (x < 2.2250738585072014e-308) {
        return 7.450580596923828e-9 * math_sqrt(18014398509481984.0 * x);
    }
    y = math_double((math_bits(x) >> 1) + (UINT64_C(511) << 52) + (UINT64_C(1) << 51));
    for (i = 0; i < 5; i++) {
        y = 0.5 * (y + x / y);
    }
    return y;
}
""",
    "log": """\
/* x = m 2^k with m about 1, and log m = 2 artanh s as a series in s = (m - 1)/(m + 1). */
static double math_log(double x)
{
    uint64_t b;
    double m, s, q, sum;
    int k, i;
    if (!(x > 0.0 && x <= 1.7976931348623157e308)) {
        return x < 0.0 ? NAN : (x == 0.0 ? -HUGE_VAL : x);
    }
    k = 0;
    if (x < 2.2250738585072014e-308) {
        x *= 18014398509481984.0;
        k = -54;
    }
    b = math_bits(x);
    k += (int)(b >> 52) - 1023;
    m = math_double((b & UINT64_C(0x000fffffffffffff)) | UINT64_C(0x3ff0000000000000));
    if (m > 1.4142135623730951) {
        m *= 0.5;
        k += 1;
    }
    s = (m - 1.0) / (m + 1.0);
    q = s * s;
    sum = 1.0 / 23.0;
    for (i = 21; i >= 3; i -= 2) {
        sum = sum * q + 1.0 / (double)i;
    }
    sum = 2.0 * (s + s * q * sum);
    return (double)k * 0.693147180369123816490 + ((double)k * 1.90821492927058770002e-10 + sum);
}
""",
    "log1p": """\
static double math_log1p(double x)
{
    double s, q, sum;
    int i;
    if (!(x > -0.29 && x < 0.41)) {
        return math_log(1.0 + x);
    }
    if (fabs(x) < 1e-17) {
        return x;
    }
    s = x / (2.0 + x);
    q = s * s;
    sum = 1.0 / 23.0;
    for (i = 21; i >= 3; i -= 2) {
        sum = sum * q + 1.0 / (double)i;
    }
    return 2.0 * (s + s * q * sum);
}
""",
    "expm1": """\
/* exp(x) - 1 without what cancels near 0: there by its series. */
static double math_expm1(double x)
{
    double sum;
    int i;
    if (!(fabs(x) < 0.5)) {
        return exp(x) - 1.0;
    }
    sum = 1.0;
    for (i = 17; i >= 2; i--) {
        sum = 1.0 + x * sum / (double)i;
    }
    return x * sum;
}
""",
    "pow": """\
/* Small whole exponents by products, others by exp and log, which a base below 0 has not. */
static double math_pow(double a, double b)
{
    double product, base;
    int n;
    if (b == 0.0 || a == 1.0) {
        return 1.0;
    }
    if (fabs(b) <= 64.0 && b == (double)(int)b) {
        n = (int)fabs(b);
        product = 1.0;
        for (base = a; n > 0; n >>= 1) {
            if ((n & 1) != 0) {
                product *= base;
            }
            if (n > 1) {
                base *= base;
            }
        }
        return b > 0.0 ? product : 1.0 / product;
    }
    if (!(a >= 0.0) || b != b) {
        return NAN;
    }
    return exp(b * math_log(a));
}
""",
    "wave": """\
/* sin(x + k pi/2): x less the nearest multiple of pi/2, then by series. |x| up to 1e9. */
static double math_wave(double x, int k)
{
    double n, r, q, sum;
    int i;
    if (!(fabs(x) < 1e9)) {
        return NAN;
    }
    n = (double)(long)(x * 0.63661977236758134308 + (x < 0.0 ? -0.5 : 0.5));
    r = x - n * 1.57079632673412561417e+00;
    r -= n * 6.07710050630396597660e-11;
    r -= n * 2.02226624879595063154e-21;
    k = (int)(((long)n + k) & 3L);
    q = r * r;
    sum = 1.0;
    if ((k & 1) == 0) {
        for (i = 19; i >= 3; i -= 2) {
            sum = 1.0 - q * sum / ((double)i * (double)(i - 1));
        }
        sum *= r;
    } else {
        for (i = 20; i >= 2; i -= 2) {
            sum = 1.0 - q * sum / ((double)i * (double)(i - 1));
        }
    }
    return k < 2 ? sum : -sum;
}
""",
    "sin": """\
static double math_sin(double x)
{
    return math_wave(x, 0);
}
""",
    "cos": """\
static double math_cos(double x)
{
    return math_wave(x, 1);
}
""",
}


def sources(calls: Iterable[str]) -> list[str]:
    """The C sources of the functions that a program calls, each after those that it needs."""
    wanted: dict[str, None] = {}

    def want(name: str) -> None:
        for needed in _NEEDS.get(name, ()):
            want(needed)
        wanted[name] = None

    for name in calls:
        if name not in OWN:
            want(name)
    return [_SOURCES[name] for name in wanted]
