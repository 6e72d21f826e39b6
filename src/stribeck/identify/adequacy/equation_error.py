"""The equation error of a fit by output error: the forces that the measured motion leaves over.

Errors of a simulated motion add up from where they occur, so they do not show what they depend on.
The equation of motion does: the drive's force along the measured motion less inertia, friction and
all else that the model has. The motion is low-passed, as for a force balance, and what that leaves
over of the model's own motion is taken off, so that a filter's error is not the model's.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...data.filtering import CUTOFF_SHARE, DECIMABLE, Filtering, decimate, kept, smooth
from ...errors import InputError
from ...rig.simulated import SimulatedRig, as_simulated
from ...space import Array
from ..score import simulated
from .residual_rows import ResidualRows

if TYPE_CHECKING:
    from ...rig.motion.track import Track
    from ..parameters import Parameters
    from ..segment import Segment
    from ..uncertainty.estimates import Estimate

#: A cut-off is lowered in steps of this factor, as long as it takes less than this share off the
#: model's velocity, root mean square; and not below that share of the sampling rate.
STEPS, LOST, LOWEST = 1.41, 0.03, 0.002
#: The same share where the axis sticks and slips: at the ends of slips it sees noise alone.
LOST_IN_SLIPS = 0.08
#: Step of a parameter for its slope, as a share of its value.
STEP = 1e-3
#: Rows in the time of a cut-off's period, and to each side of a reversal, that it mixes.
FINE, REACH = 4, 2
#: Noise of a filtered velocity is this many times that of its model's when the axis rests.
NOISY = 4.0


def equation_error(
    parameters: Parameters,
    p: Array,
    train: Sequence[Segment],
    estimates: Sequence[Estimate] = (),
) -> ResidualRows | None:
    """The residual forces of a fit by output error; None where its rig or law cannot say.

    A law with states cannot: its bristles add up the noise of the position, so that their force
    wanders for as long as they remember.

    Args:
        parameters: Rig and law.
        p: The fit, a complete set, SI, (k,).
        train: The segments trained on, with the starts that the fit has.
        estimates: Of all parameters; none where there are no intervals yet.
    """
    if parameters.law.states:
        return None
    rig, free = as_simulated(parameters.rig), parameters.free_places
    moved = _stepped(parameters, p)
    motions = simulated(parameters, p, train)
    parts = []
    for s, motion in zip(train, motions, strict=True):
        part = _segment_rows(rig, parameters, moved, s.track, motion.position[0])
        if part is not None:
            parts.append((part, id(s.recording)))
    if not parts:
        return None
    logs = list(dict.fromkeys(log for _, log in parts))
    t, x, v, a, seen, r = (np.concatenate([part[i] for part, _ in parts]) for i in range(6))
    J = np.concatenate([part[6] for part, _ in parts], axis=1)
    steps = np.array([moved[1 + i, place] - p[place] for i, place in enumerate(free)])
    return ResidualRows(
        log=np.concatenate([np.full(len(part[0]), logs.index(log)) for part, log in parts]),
        t=t, position=x, velocity=v, acceleration=a, residual=r,
        jacobian=-J.T / steps,
        names=tuple(q.name for q in parameters.free),
        values=p[free],
        half_widths=np.array(
            [0.5 * (estimates[i].high - estimates[i].low) if estimates else 0.0 for i in free]
        ),
        reach=REACH,
        pace=max(part[7] for part, _ in parts),
        other=seen,
    )  # fmt: skip


def _stepped(parameters: Parameters, p: Array) -> Array:
    """The fit, and with one free parameter after the other moved a little, (1 + free, k)."""
    x = np.repeat(p[None, parameters.free_places], 1 + len(parameters.free), axis=0)
    for i, q in enumerate(parameters.free):
        step = STEP * (abs(x[0, i]) or 1e-3 * (q.upper - q.lower))
        x[1 + i, i] += step if x[0, i] + step <= q.upper else -step
    return parameters.full(x)


def _segment_rows(
    rig: SimulatedRig, parameters: Parameters, moved: Array, track: Track, model: Array
) -> tuple[Array, Array, Array, Array, Array, Array, Array, float] | None:
    """Time, position, velocity, acceleration and residual force of a segment's rows, (rows,).

    And how the residual force changes with each parameter moved, (free, rows), and the speed that
    noise has.
    """
    counts = track.score > 0
    if np.count_nonzero(counts) < 2 or not np.isfinite(model).all():  # noqa: PLR2004
        return None
    law = parameters.law
    grid = _even(track, track.t[counts])
    rate = 1.0 / float(grid.t[1] - grid.t[0]) if len(grid.t) > 1 else 1.0
    measured = np.interp(grid.t, track.t[counts], track.measured[counts])
    modelled = np.interp(grid.t, track.t[counts], model[counts])
    if rig.floating:
        modelled = modelled + float(np.mean(measured - modelled))
    try:
        filtering = _filtering(modelled, rate, LOST_IN_SLIPS if rig.from_rest else LOST)
        own, seen = (smooth(x, rate, filtering) for x in (modelled, measured))
    except InputError:  # too short to filter
        return None
    first, last = filtering.edges(rate)
    inner, factor = slice(first, len(grid.t) - last), filtering.factor(rate)
    forces = rig.imbalance(law, moved[:1], grid, seen)
    artefact = rig.imbalance(law, moved, grid, own)
    if forces is None or artefact is None or len(grid.t[inner]) < max(3 * factor, DECIMABLE):
        return None
    # Slopes and bins are of the model's motion: that of the sensor has the noise of the residual.
    parts = np.concatenate([forces - artefact[:1], artefact[1:] - artefact[:1]])
    thin = decimate(parts.T[inner], factor).T
    pick = kept(len(grid.t[inner]), factor)
    t, x, v, a, seen_v = (values[inner][pick] for values in (grid.t, *own, seen[1]))
    resting = np.abs(own[1][inner]) < 1e-3 * float(np.abs(own[1]).max())
    noise = seen[1][inner][resting]
    pace = NOISY * float(np.sqrt(np.mean(noise**2))) if len(noise) > factor else 0.0
    return t, x, v, a, seen_v, thin[0], thin[1:], pace


def _even(track: Track, t: Array) -> Track:
    """A track with its samples on an even grid, as far as those reach that count."""
    dt = float(np.median(np.diff(track.t)))
    grid = t[0] + dt * np.arange(int((t[-1] - t[0]) / dt * (1 + 1e-12)) + 1)
    before = np.clip(np.searchsorted(track.t, grid, side="right") - 1, 0, len(track.t) - 1)
    inputs = np.array(
        [
            values[before] if held > 0 else np.interp(grid, track.t, values)
            for values, held in zip(track.inputs, track.held, strict=True)
        ]
    ).reshape(len(track.inputs), len(grid))
    stretch = track.stretch[before] if track.stretch.size else track.stretch
    return track._replace(t=grid, inputs=inputs, stretch=stretch)


def _filtering(model: Array, rate: float, share_lost: float) -> Filtering:
    """The lowest cut-off that leaves the model's velocity as it is, from a tenth of the rate on.

    The noise of an acceleration grows with the power 2.5 of the cut-off.
    """
    best = Filtering(cutoff_hz=CUTOFF_SHARE * rate)
    v = np.diff(model)
    share = CUTOFF_SHARE
    while share > LOWEST:
        share /= STEPS
        lower = Filtering(cutoff_hz=share * rate)
        lost = np.diff(smooth(model, rate, lower)[0]) - v
        if float(lost @ lost) > share_lost**2 * float(v @ v):
            break
        best = lower
    longer = CUTOFF_SHARE * rate / best.cutoff_hz
    edge = 5.0 * longer / rate
    decimation = max(round(best.factor(rate) / FINE), 1)
    return Filtering(cutoff_hz=best.cutoff_hz, edge=(edge, edge), decimation=decimation)
