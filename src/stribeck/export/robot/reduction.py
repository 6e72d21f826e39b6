"""A friction law reduced to the few numbers of a robot simulator's, and the error of that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar, nnls

from ...friction import LAWS, Law
from ...rig.rig import stem
from ...space import Array

#: Speeds each way at which a law and its numbers are held against each other.
_SPEEDS = 400
#: What a card of unknown speeds is taken to be good for: so many times its Stribeck velocity, or
#: this, m/s and rad/s.
_STRIBECKS, _LINEAR, _ROTARY = 10.0, 0.1, 1.0
#: The speeds at which friction falls, by the names that laws give them.
_FALLS = ("v_SS", "v_s", "w_s", "v_brk")
#: Where the Stribeck velocity of a LuGre law is looked for, shares of the greatest speed.
_DECADES = (1e-4, 1.0)
#: Of a law that is static at rest alone, the band that counts as rest: a share of the least speed.
_BAND = 0.5


@dataclass(frozen=True, eq=False)
class Reduction:
    """A simulator's friction in place of a card's.

    Args:
        law: The law that the simulator has.
        p: Its parameters, SI.
        low: Least speed of the comparison, m/s (rad/s).
        high: Greatest.
        assumed: Whether nobody said these speeds.
        size: RMS friction of the card over them, both directions, N (N m).
        rms: RMS error of the friction, N (N m).
        worst: Its largest error over them and over speeds by decades, N (N m).
        worst_at: The speed of that, signed.
        worst_of: The card's friction there, N (N m).
    """

    law: Law
    p: Array
    low: float
    high: float
    assumed: bool
    size: float
    rms: float
    worst: float
    worst_at: float
    worst_of: float

    def __getitem__(self, name: str) -> float:
        """A parameter by its name."""
        return float(self.p[self.law.names.index(name)])


def coulomb_viscous(
    law: Law, p: Array, speeds: tuple[float, float] | None, *, rotary: bool
) -> Reduction:
    """The level and the damping that come nearest to a law.

    Least squares over speeds, evenly spaced, of both directions. Neither number is below zero:
    a simulator would make energy of it.

    Args:
        law: The law; one that depends on loads is taken without them.
        p: Its parameters, SI; what follows them is not looked at.
        speeds: What the card is good for, m/s (rad/s).
        rotary: Whether these are rad/s.
    """
    span = _range(law, p, speeds, rotary=rotary)
    return _compared(law, p, span, LAWS["coulomb-viscous"], _sliding(law, p, span))


def static_coulomb_viscous(
    law: Law, p: Array, speeds: tuple[float, float] | None, *, rotary: bool
) -> Reduction:
    """The same with a level of its own at rest, the law's: Karnopp's law with the band at zero.

    Args:
        law: As for `coulomb_viscous`.
        p: As there.
        speeds: As there.
        rotary: As there.
    """
    span = _range(law, p, speeds, rotary=rotary)
    level, damping = _sliding(law, p, span)
    minus, plus = law.levels(np.asarray(p[: len(law.params)], dtype=float))
    band = _BAND * float(_decades(span)[0])  # narrower than all speeds of the comparison
    q = np.array([max(0.5 * (plus - minus), level), level, damping, band])
    return _compared(law, p, span, LAWS["karnopp"], q)


def _sliding(law: Law, p: Array, span: tuple[float, float, bool]) -> Array:
    """Level, N (N m), and damping, N s/m (N m s/rad), nearest to a law in sliding."""
    v = _speeds(span)
    # The second column is scaled, so that neither number is lost in the other's digits.
    columns = np.column_stack([np.sign(v), v / span[1]])
    (level, damping), _ = nnls(columns, law.friction(v, p[: len(law.params)]))
    return np.array([level, damping / span[1]])


def lugre(
    law: Law,
    p: Array,
    speeds: tuple[float, float] | None,
    *,
    rotary: bool,
    stiffness: float,
    damping: float,
) -> Reduction:
    """The LuGre law that comes nearest to a law in steady sliding and breaks away as it does.

    Its static friction is the law's level at rest; the others follow by least squares over the
    same speeds, and a drop that is narrower than their spacing is seen at speeds by decades.

    Args:
        law: As for `coulomb_viscous`.
        p: As there.
        speeds: As there.
        rotary: As there.
        stiffness: Of the bristles, N/m (N m/rad).
        damping: Of the bristles, N s/m (N m s/rad).
    """
    span = _range(law, p, speeds, rotary=rotary)
    law_p = np.asarray(p[: len(law.params)], dtype=float)
    minus, plus = law.levels(law_p)
    F_S = 0.5 * (plus - minus)
    v = np.concatenate([_speeds(span), _decades(span), -_decades(span)])
    F = law.friction(v, law_p)

    def solved(v_s: float) -> tuple[float, Array]:
        fall = np.exp(-((v / v_s) ** 2))
        columns = np.column_stack([np.sign(v) * (1.0 - fall), v / span[1]])
        weights, residual = nnls(columns, F - np.sign(v) * F_S * fall)
        return float(residual), np.array([min(weights[0], F_S), v_s, weights[1] / span[1]])

    low, high = (np.log(share * span[1]) for share in _DECADES)
    grid = np.linspace(low, high, 60)
    best = int(np.argmin([solved(float(np.exp(u)))[0] for u in grid]))
    step = grid[1] - grid[0]
    optimum = minimize_scalar(
        lambda u: solved(float(np.exp(u)))[0],
        bounds=(grid[best] - step, grid[best] + step),
        method="bounded",
        options={"xatol": 1e-9},
    )
    F_C, v_s, F_V = solved(float(np.exp(optimum.x)))[1]
    return _compared(
        law, p, span, LAWS["lugre"], np.array([stiffness, damping, F_S, F_C, v_s, F_V])
    )


def _compared(law: Law, p: Array, span: tuple[float, float, bool], to: Law, q: Array) -> Reduction:
    """A law and what stands for it, compared."""
    law_p = p[: len(law.params)]

    def off(v: Array) -> tuple[Array, Array]:
        F = law.friction(v, law_p)
        return F, to.friction(v, q) - F

    v = _speeds(span)
    F, error = off(v)
    # The largest error of a law that falls lies beside rest, where even speeds do not look.
    sample = np.concatenate([-_decades(span)[::-1], v, _decades(span)])
    F_sample, error_sample = off(sample)
    at = int(np.abs(error_sample).argmax())
    return Reduction(
        to, q, *span,
        size=float(np.sqrt(np.mean(F * F))), rms=float(np.sqrt(np.mean(error * error))),
        worst=float(abs(error_sample[at])), worst_at=float(sample[at]),
        worst_of=float(abs(F_sample[at])),
    )  # fmt: skip


def _range(
    law: Law, p: Array, speeds: tuple[float, float] | None, *, rotary: bool
) -> tuple[float, float, bool]:
    """Least and greatest speed of the comparison, and whether they had to be assumed."""
    if speeds is not None:
        a, b = min(speeds), max(speeds)
        low, high = (a, b) if a > 0 else (-b, -a) if b < 0 else (0.0, max(b, -a))
        if 0 < high < np.inf:
            return (float(low) if low < high else 0.0), float(high), False
    falls = [float(v) for q, v in zip(law.params, p, strict=False) if stem(q.name) in _FALLS]
    return 0.0, _STRIBECKS * max(falls) if falls else _ROTARY if rotary else _LINEAR, True


def _speeds(span: tuple[float, float, bool]) -> Array:
    """Speeds of both directions, evenly spaced, none of them zero."""
    low, high, _ = span
    v = low + (high - low) * (np.arange(_SPEEDS) + 0.5) / _SPEEDS
    return np.concatenate([-v[::-1], v])


def _decades(span: tuple[float, float, bool]) -> Array:
    low, high, _ = span
    return np.geomspace(max(low, _DECADES[0] * high), high, _SPEEDS)
