"""What is said now of logs of which earlier versions said what was not so: tried on such logs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

import foreign_axes
import interval_axes
import nested_laws
from foreign import sensors
from foreign.servo import Bam
from stribeck import RIGS, Fit, Recording, check, identify, plan, read, select
from stribeck.identify.loss import Loss
from stribeck.identify.problem import problem
from stribeck.identify.uncertainty.estimates import range_end
from stribeck.identify.uncertainty.profile import IntervalEnd, Profile
from stribeck.identify.uncertainty.sensor_noise import sensor_noise
from stribeck.identify.uncertainty.verdict import verdict, verdict_text
from stribeck.space import Param

FOLDER = Path(__file__).parent
DATA = FOLDER.parents[1] / "shared" / "data"


def _logs(axis: foreign_axes.Axis, *faults: Callable[[sensors.Table], sensors.Table]) -> list[Any]:
    """Logs of an axis with noise of seed 0 and faults."""
    tables = foreign_axes.noisy(axis, np.random.default_rng(0))
    for fault in faults:
        tables = [fault(table) for table in tables]
    return foreign_axes.recordings(axis, tables)


def _estimates(fit: Fit, truth: Mapping[str, float], *names: str) -> str:
    """Estimates beside their truths."""
    texts = []
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        if q.name in names:
            reason = f" ({e.reason})" if e.reason else ""
            bias = 100 * (e.value / truth[q.name] - 1)
            texts.append(f"{e.name} {bias:+.1f} %, {e.verdict}{reason}")
    return "; ".join(texts)


def clipped(limit: float) -> str:
    """A balance whose force is cut off."""
    axis = foreign_axes.forced()
    logs = _logs(axis, lambda table: sensors.clipped(table, "force", limit))
    share = float(np.mean(np.abs(logs[0].force) >= 0.999 * limit))
    fit = identify(logs, rig="forced", law="coulomb-viscous")
    told = "told" if any("cut off" in w for w in fit.warnings) else "not told"
    return f"{100 * share:.0f} % clipped: {_estimates(fit, axis.truth, 'F_C', 'F_V', 'M')}; {told}"


def term(law: str) -> str:
    """A law with terms of the position on a slide without any."""
    axis = foreign_axes.forced()
    fit = identify(_logs(axis), rig="forced", law=law)
    return _estimates(fit, axis.truth, "F_C", "F_V", "M")


def steps() -> str:
    """What `check` says of coarse steps of a position."""
    t = np.arange(0.0, 20.0, 0.01)
    x = 1e-3 * np.round(28.5 * (1.0 - np.cos(2.0 * np.pi * t / 10.0)))
    return next(line for line in check(Recording(t, x)).verdict if "coarse" in line)


def slips() -> str:
    """What `check` says of stick-slip with a measured force."""
    axis = foreign_axes.bed()
    table = _logs(axis)[0]
    log = Recording(table.t, table.position, command=table.command, force=3500.0 * (
        np.asarray(table.command) - table.position))  # fmt: skip
    return "; ".join(line.partition(":")[0] for line in check(log).verdict)


def floor() -> str:
    """The noise that is read off three logs of a pendulum."""
    logs = _logs(foreign_axes.pendulum(noise=0.64e-3))
    return f"{', '.join(f'{1e3 * sensor_noise(log):.2f}' for log in logs)} mrad (three logs)"


def end() -> str:
    """Whether a stiffness in the middle of its decades sits at an end of its range."""
    stiffness = Param("sigma_0", 1.0, 1e7, "N/m", log=True)
    return "at no end" if range_end(3237.0, stiffness) is None else "at an end"


def degenerate(param: Param, value: float, low: float, high: float) -> str:
    """The verdict on an interval whose ends are set by the data."""
    down, up = (IntervalEnd(at, "threshold", 1.0) for at in (low, high))
    none = np.empty(0)
    profile = Profile(param.name, value, down, up, none, none, none[:, None], 1.0)
    return verdict_text(*verdict(profile, param))


def bristle_error() -> str:
    """What default steps leave of a log without noise at the parameters that made it."""
    axis = interval_axes.dahl(1)
    logs = foreign_axes.recordings(axis, list(axis.tables))
    motion = problem(logs, rig=RIGS[axis.rig].set(**axis.given), law=axis.law)
    error = motion.reported(np.array([axis.truth[q.name] for q in motion.parameters.free]))
    return f"{error:.3f} um, beside {1e6 * axis.noise['position']:.2f} um of noise"


def selected() -> str:
    """Whether Stribeck is warranted where there is none."""
    axis = foreign_axes.forced()
    selection = select(_logs(axis), rig="forced", laws=["coulomb-viscous", "stribeck"])
    (finding,) = selection.findings
    return "warranted" if finding.warranted else "not warranted"


def one_way_laws() -> str:
    """What a comparison says of directions on a log that runs one way, and what it spends on it."""
    selection = select(_logs(_left()), rig="slide-bed", laws=["stribeck", "stribeck-directional"])
    sentence = next(s for s in selection.sentences if "cannot be asked" in s)
    return f"{sentence.partition(' Not fitted')[0]} {len(selection.candidates)} law is fitted"


def one_way_words() -> str:
    """Whether a fit to a log one way says that the directions share one parameter set."""
    fit = identify(_logs(_left()), rig="slide-bed", law="stribeck")
    shared = any("both directions share" in warning for warning in fit.warnings)
    return "said" if shared else "not said"


def borrowed() -> str:
    """The warning on constants of a machine that is not the log's."""
    fit = identify(_logs(_left()), rig="slide-bed", law="stribeck")
    return next(w for w in fit.warnings if "not of this axis" in w).partition(";")[0]


def planned(name: str) -> str:
    """The words of an experiment that is proposed for a bed that was driven down."""
    logs = _logs(_left())
    proposed = plan(identify(logs, rig="slide-bed", law="stribeck"), logs).proposals
    return next(p.experiment.words for p in proposed if p.experiment.name == name)


def noiseless_plan() -> str:
    """What is proposed of sensors for a log that shows no noise."""
    axis = _left()
    logs = foreign_axes.recordings(axis, list(axis.tables))
    proposed = plan(identify(logs, rig="slide-bed", law="stribeck"), logs).proposals
    names = [p.experiment.name for p in proposed if p.experiment.kind == "sensor"]
    return f"proposed of sensors: {', '.join(names)}"


def differing_logs() -> str:
    """What is said of three logs of a servo, one with half as much friction again."""
    usual, dry = foreign_axes.pendulum(), foreign_axes.pendulum(bam=Bam(0.03, 0.012))
    axis = replace(usual, tables=(*usual.tables[:2], dry.tables[2]))
    rig = RIGS[axis.rig].set(**axis.given)
    fit = identify(_logs(axis), rig=rig, law=axis.law)
    said = [w for w in fit.warnings if "log" in w and "differ" in w]
    return said[0] if said else "nothing said"


def mill() -> str | None:
    """Coulomb friction of a mill whose positions are rounded."""
    file, columns = DATA / "cnc" / "experiment_11.csv", FOLDER.parent / "docs/logs/cnc_x.toml"
    if not file.exists():
        return None
    fit = identify(read(file, columns=columns), rig="forced")
    e = fit.estimates[[q.name for q in fit.parameters.every].index("F_C")]
    return f"{e.value:.2f} A ({e.low:.2f} to {e.high:.2f}), {e.verdict} ({e.reason})"


def moving_neighbours() -> str | None:
    """J of an arm's joint while others move, and what is said of them and of the half held out."""
    file, columns = DATA / "ur10e" / "ur-19_12_23_free.csv.gz", "docs/logs/ur10e_joint_1.toml"
    if not file.exists():
        return None
    fit = identify(
        read(file, columns=FOLDER.parent / columns), rig="forced-rotary", train="0s:11s",
        holdout="11s:22s",
    )  # fmt: skip
    e = next(e for e in fit.estimates if e.name == "J")
    words = ("hold-out", "other joints")
    said = [w.partition(" (")[0] for w in fit.warnings if any(word in w for word in words)]
    return f"J {e.value:.2f} A s² ({e.low:.2f} to {e.high:.2f}), {e.verdict}; {'; '.join(said)}"


def losses(name: str) -> str | None:
    """A parameter of bam-m1 by both losses, on the 16 logs of a servo."""
    if not DATA.exists():
        return None
    rig, logs, bounds = nested_laws.axis("xl330")
    texts = []
    for loss in get_args(Loss):
        fit = identify(logs, rig=rig.exact(), law="bam-m1", loss=loss, bounds=bounds)
        e = fit.estimates[[q.name for q in fit.parameters.every].index(name)]
        texts.append(f"{loss}: {e.value:.4f} ({e.low:.4f} to {e.high:.4f}), {e.verdict}")
    return "; ".join(texts)


def _left() -> foreign_axes.Axis:
    return foreign_axes.bed(right=False)
