"""Searches, profiles and bootstraps as a report has them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...rig.rig import shown_in
from ..format import unit_label
from .schema import LONGEST, MANY, DrawsRecord, ProfileRecord, RunRecord

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ...identify.result import Fit


def profile_records(fit: Fit) -> Iterator[ProfileRecord]:
    """The profile of each free parameter."""
    profiles = fit.uncertainty.by_name()
    ends = {q.name: e for q, e in zip(fit.parameters.every, fit.estimates, strict=True)}
    for q in fit.parameters.free:
        e, (profile, _) = ends[q.name], profiles[q.name]
        as_shown = partial(shown_in, fit.rig, q)
        if not np.isfinite(e.value):
            continue
        finite = np.isfinite(profile.values) & np.isfinite(profile.rises)
        yield ProfileRecord(
            name=e.name,
            unit=unit_label(e.unit),
            value=float(as_shown(e.value)),
            low=float(as_shown(e.low)) if np.isfinite(e.low) else None,
            high=float(as_shown(e.high)) if np.isfinite(e.high) else None,
            values=as_shown(profile.values[finite]).tolist(),
            rises=[float(f"{z:.5g}") for z in profile.rises[finite]],
        )


def run_records(fit: Fit) -> Iterator[RunRecord]:
    """The repeats, the best first; convergence by the places where the best cost fell."""
    done = fit.search.polished or (None,) * len(fit.search.runs)
    for run, polished in zip(fit.search.runs[:MANY], done, strict=False):
        x = run.x if polished is None else polished.x
        cost = run.cost if polished is None else polished.cost
        best = run.trace.convergence()
        # Compared, not subtracted: the best cost is infinite as long as no candidate could be run.
        fell = np.flatnonzero(best < np.concatenate([[np.inf], best[:-1]]))[-LONGEST:]
        values = zip(fit.parameters.free, x, strict=False)
        yield RunRecord(
            searched=run.cost if np.isfinite(run.cost) else None,
            cost=cost if np.isfinite(cost) else None,
            evaluations=run.evaluations,
            polishing=0 if polished is None else polished.evaluations,
            ended=run.ended,
            seconds=run.seconds,
            parameters={fit.rig.label(q.name): float(shown_in(fit.rig, q, v)) for q, v in values},
            at=[int(k) + 1 for k in fell],
            best=[float(f"{f:.6g}") for f in best[fell]],
        )


def draws_record(fit: Fit) -> DrawsRecord | None:
    """The bootstrap, where there was one."""
    drawn = fit.uncertainty.bootstrap
    if drawn is None:
        return None
    return DrawsRecord(
        drawn=len(drawn.draws) + drawn.failed, failed=drawn.failed, block=drawn.block
    )
