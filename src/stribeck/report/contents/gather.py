"""What a fit has to show, gathered while the fit is at hand: its report, and finer lines."""

from __future__ import annotations

import platform
from functools import cached_property
from importlib.metadata import version
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..._version import __version__
from ...units import unit
from ..format import unit_label
from ..misfit import log_errors
from .adequacy_records import bins_records, effect_records
from .decimation import PAGE, PRINT, Detail
from .frame import Frame
from .law_curve import implied, reach
from .law_records import law_sides, load_records, load_unit, loop_records
from .motion_records import (
    balanced_traces,
    log_record,
    motion_lines,
    motion_record,
    simulated_traces,
)
from .motion_traces import MotionTraces
from .schema import (
    LETTERS,
    MANY,
    MOTIONS,
    ErrorRecord,
    LawRecord,
    MotionRecord,
    Report,
    RunRecord,
    UnitsRecord,
)
from .search_records import draws_record, profile_records, run_records
from .single_log_records import single_log_records

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...identify.result import Fit
    from ...space import Array

#: Logs shown at most, and motions of one range; of more, those with the greatest errors.
MOST = 24
#: Samples kept of all motions, of all logs, and of one of either.
ROOM, LOGS, EACH = 30_000, 20_000, 6_000
#: Samples kept of a motion that is printed.
PRINTED = 20_000
#: Bytes of a report at most: with less room it is tried again.
LARGEST = 3 << 20


class Contents:
    """What a fit has to show, at full resolution.

    Args:
        fit: The fit.
    """

    def __init__(self, fit: Fit) -> None:
        self.fit = fit

    @cached_property
    def motions(self) -> list[tuple[str, list[MotionTraces]]]:
        """Measured and modelled, of the training data and of each range held out, by its name.

        Tables of steady speeds have none.
        """
        if all(log.runs is not None for log in self.fit.recordings):
            return [("training", [])]  # no motion: the law's curve has the runs as its points
        return list(
            simulated_traces(self.fit) if self.fit.balance is None else balanced_traces(self.fit)
        )

    @cached_property
    def errors(self) -> list[tuple[str, int, list[float]]]:
        """The misfit on each log, as `log_errors` has it."""
        return log_errors(self.fit)

    @cached_property
    def cloud(self) -> tuple[Array, Array] | None:
        """Velocity and friction as the measured motions imply them, SI; None where they do not."""
        return implied(self.fit)

    @cached_property
    def fast(self) -> float:
        """The greatest speed of the training data, m/s (rad/s)."""
        return reach(self.fit)

    @cached_property
    def frame(self) -> Frame:
        """What all figures have in common."""
        rig = self.fit.rig
        units = UnitsRecord(
            position=unit_label(rig.unit_shown("position")),
            velocity=unit_label(rig.unit_shown("velocity")),
            force=rig.si_unit("force"),
        )
        road: Literal["simulation", "inverse"] = (
            "simulation" if self.fit.balance is None else "inverse"
        )
        return Frame(self.fit.law.name, units, road, rig.rotary, rig.applied_force)

    def runs(self) -> list[RunRecord]:
        """The repeats of the search."""
        return list(run_records(self.fit))

    def report(self, command: Sequence[str] = ()) -> Report:
        """The report, of at most LARGEST bytes as a rule: long lines are thinned until it is.

        Args:
            command: What was typed, word by word, to be repeated.

        Raises:
            InputError: the fit has no card.
        """
        share = 1.0
        report = self._report(command, share)
        while len(report.text()) > LARGEST and share > 0.1:  # noqa: PLR2004 - then it is no use
            share /= 2
            report = self._report(command, share)
        return report

    def printed_motion(self, part: str, traces: MotionTraces) -> MotionRecord:
        """A motion of a range in full, without spectra; a very long one is thinned to PRINTED."""
        return MotionRecord(label=traces.label, part=part, **motion_lines(traces, PRINTED, PRINT))

    def law(self, detail: Detail, ends: tuple[float, float] | None = None) -> LawRecord:
        """The law, between two speeds (SI) or as far as the data go."""
        fit, cloud = self.fit, self.cloud
        scale = unit(fit.rig.unit_shown("velocity")).factor
        if ends is None:
            ends = (-self.fast, self.fast)
            if cloud is not None:
                ends = min(float(cloud[0].min()), 0.0), max(float(cloud[0].max()), 0.0)
        every = 1 if cloud is None else -(-len(cloud[0]) // detail.cloud)
        loaded = any(load in ("drive", "external", "normal") for load in fit.law.loads)
        pace, loops = loop_records(fit, detail) if fit.law.states else (None, [])
        curve, source = law_sides(fit, ends, detail)
        return LawRecord(
            doc=fit.law.doc,
            cite=fit.law.cite,
            formula=fit.law.formula,
            curve=curve,
            band=source,
            cloud_velocity=[] if cloud is None else detail.series(cloud[0][::every] / scale, 5),
            cloud_friction=[] if cloud is None else detail.series(cloud[1][::every], 5),
            pace=pace,
            loops=loops,
            loads=load_records(fit, self.fast, detail) if loaded else [],
            load=load_unit(fit)[0] if loaded else "",
        )

    def _report(self, command: Sequence[str], share: float) -> Report:
        fit = self.fit
        logs = self._logs_shown()
        room = max(min(EACH, LOGS // len(logs)), 100)
        motions, hidden = self._motions(share)
        return Report(
            card=fit.card(),
            road=self.frame.road,
            rotary=self.frame.rotary,
            applied=self.frame.applied,
            about=fit.rig.doc,
            equation=_equation(fit),
            units=self.frame.units,
            logs=[log_record(fit, fit.recordings[k], int(share * room)) for k in logs],
            unshown=len(fit.recordings) - len(logs),
            motions=motions,
            hidden=hidden,
            law=self.law(PAGE),
            profiles=list(profile_records(fit)),
            runs=self.runs(),
            errors=[
                ErrorRecord(
                    log=log, samples=n, errors=[e if np.isfinite(e) else None for e in errors]
                )
                for log, n, errors in (self.errors if len(fit.recordings) > 1 else [])[:MANY]
            ],
            single_logs=list(single_log_records(fit))[:MANY],
            bins=list(bins_records(fit)),
            effects=list(effect_records(fit)),
            draws=draws_record(fit),
            command=[word[:LETTERS] for word in command[:MANY]],
            software={
                "stribeck": __version__,
                "Python": platform.python_version(),
                **{name: version(name) for name in ("numpy", "scipy", "numba")},
            },
        )

    def _logs_shown(self) -> list[int]:
        """Which logs are shown: those with the greatest errors, in order."""
        if len(self.fit.recordings) <= MOST:
            return list(range(len(self.fit.recordings)))
        worst = [np.nanmax([*errors, -np.inf]) for _, _, errors in self.errors]
        return sorted(sorted(range(len(worst)), key=lambda k: -worst[k])[:MOST])

    def _motions(self, share: float) -> tuple[list[MotionRecord], int]:
        """What was measured and modelled, range by range; and how many motions are left out."""
        count = sum(min(len(traces), MOST) for _, traces in self.motions)
        most = int(share * max(min(EACH, ROOM // max(count, 1)), 100))
        records: list[MotionRecord] = []
        for part, traces in self.motions:
            worst = sorted(range(len(traces)), key=lambda k: -_size(traces[k]))[:MOST]
            records += [motion_record(part, traces[k], most) for k in sorted(worst)]
        hidden = sum(len(traces) for _, traces in self.motions) - len(records[:MOTIONS])
        return records[:MOTIONS], hidden


def _size(r: MotionTraces) -> float:
    return r.rms if np.isfinite(r.rms) else 0.0


def _equation(fit: Fit) -> list[str]:
    """The equation of motion of its rig, a part a line; none where it has none."""
    equation = fit.rig.equation(fit.parameters.law)
    return [] if equation is None else equation.text.split(";  ")
