"""What earlier versions said of some logs that was not so, and what is said of these now.

    python benchmarks/reproductions.py [--only WORDS]     try them again
    python benchmarks/faults.py --page                    the table, below that of faults

A row has what was said earlier, what is said now, and the command that shows it. Rows of the fault
table and of other studies are read from their results; the rest is tried here, some of it on the
recordings in `../shared/data` (without them a row stays as it is). Each goes to reproductions.json.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import ert_coverage
import foreign_axes
import nested_laws
from foreign import sensors
from stribeck import Fit, Recording, check, identify, read, select
from stribeck.identify.uncertainty.estimates import range_end
from stribeck.identify.uncertainty.sensor_noise import sensor_noise
from stribeck.report.table import Cell, Table
from stribeck.space import Param

FOLDER = Path(__file__).parent
FILE, RESULTS = FOLDER / "reproductions.json", FOLDER / "results.json"
DATA = FOLDER.parents[1] / "shared" / "data"
SELF = "python benchmarks/reproductions.py --only"


@dataclass(frozen=True)
class Case:
    """Something that was said wrongly.

    Args:
        what: Of which log.
        earlier: What was said.
        command: That shows what is said now.
        now: Which says it; None where the recordings are not there.
    """

    what: str
    earlier: str
    command: str
    now: Callable[[], str | None]


# --- read from the results of studies -------------------------------------------------------------


def _found(name: str) -> Any:
    return json.loads(RESULTS.read_text(encoding="utf-8"))[name]["found"]


def _fault(kind: str, perturbation: str, *parameters: str) -> str:
    """A row of the fault table: biases, how often identified, and whether the table has it told."""
    rows = [r for r in _found("faults")["rows"] if r["kind"] == kind]
    row = next(r for r in rows if r["perturbation"] == perturbation)  # with exact constants first
    found = [(n, row["parameters"][n]) for n in parameters or row["parameters"]]
    texts = [
        f"{n} {100 * p['bias']:+.1f} %, identified in {p['identified']} of {p['of']}"
        for n, p in found
    ]
    return "; ".join([*texts, *(["told"] if row["told"] else [])])


def _held(study: str, parameter: str) -> str:
    """How many intervals of a study hold the truth."""
    counts = _found("intervals")["studies"][study]["parameters"][parameter]
    known, every = counts["identified"], counts["every"]
    return (
        f"{every['held']} of {every['of']} intervals hold the truth, "
        f"{known['held']} of {known['of']} of those identified"
    )


def _nested() -> str:
    results = json.loads(nested_laws.FILE.read_text(encoding="utf-8"))
    above = list(nested_laws.broken(results))
    best = min(r["error"] for key, r in results.items() if key.startswith("xl330/absolute/m4"))
    return f"{above or 'no law ends above one that it contains'}; m4 {best:.1f} mrad by absolute"


# --- tried here -----------------------------------------------------------------------------------


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


def _clipped(limit: float) -> str:
    axis = foreign_axes.forced()
    logs = _logs(axis, lambda table: sensors.clipped(table, "force", limit))
    share = float(np.mean(np.abs(logs[0].force) >= 0.999 * limit))
    fit = identify(logs, rig="forced", law="coulomb-viscous")
    return f"{100 * share:.0f} % clipped: {_estimates(fit, axis.truth, 'F_C', 'F_V', 'M')}; told"


def _term(law: str) -> str:
    axis = foreign_axes.forced()
    fit = identify(_logs(axis), rig="forced", law=law)
    return _estimates(fit, axis.truth, "F_C", "F_V", "M")


def _steps() -> str:
    t = np.arange(0.0, 20.0, 0.01)
    x = 1e-3 * np.round(28.5 * (1.0 - np.cos(2.0 * np.pi * t / 10.0)))
    return next(line for line in check(Recording(t, x)).verdict if "coarse" in line)


def _slips() -> str:
    axis = foreign_axes.bed()
    table = _logs(axis)[0]
    log = Recording(table.t, table.position, command=table.command, force=3500.0 * (
        np.asarray(table.command) - table.position))  # fmt: skip
    return "; ".join(line.partition(":")[0] for line in check(log).verdict)


def _floor() -> str:
    logs = _logs(foreign_axes.pendulum(noise=0.64e-3))
    return f"{', '.join(f'{1e3 * sensor_noise(log):.2f}' for log in logs)} mrad (three logs)"


def _end() -> str:
    stiffness = Param("sigma_0", 1.0, 1e7, "N/m", log=True)
    return "at no end" if range_end(3237.0, stiffness) is None else "at an end"


def _selected() -> str:
    axis = foreign_axes.forced()
    selection = select(_logs(axis), rig="forced", laws=["coulomb-viscous", "stribeck"])
    (finding,) = selection.findings
    return "warranted" if finding.warranted else "not warranted"


def _ert() -> str:
    times = ert_coverage.TIMES["log-normal, s = 1.5"]
    shares = [ert_coverage.covered(times, 1.0, n, 200)[1] for n in ert_coverage.RUNS]
    runs = ", ".join(map(str, ert_coverage.RUNS))
    return f"{', '.join(f'{100 * s:.0f}' for s in shares)} % of {runs} runs (nominal 95 %)"


def _mill() -> str | None:
    file, columns = DATA / "cnc" / "experiment_11.csv", FOLDER.parent / "docs/logs/cnc_x.toml"
    if not file.exists():
        return None
    fit = identify(read(file, columns=columns), rig="forced")
    e = fit.estimates[[q.name for q in fit.parameters.every].index("F_C")]
    return f"{e.value:.2f} A ({e.low:.2f} to {e.high:.2f}), {e.verdict} ({e.reason})"


def _losses() -> str | None:
    if not DATA.exists():
        return None
    rig, logs, bounds = nested_laws.axis("xl330")
    texts = []
    for loss in ("squares", "absolute"):
        fit = identify(logs, rig=rig.exact(), law="bam-m1", loss=loss, bounds=bounds)
        e = fit.estimates[[q.name for q in fit.parameters.every].index("K_c")]
        texts.append(f"{loss}: {e.value:.4f} ({e.low:.4f} to {e.high:.4f}), {e.verdict}")
    return "; ".join(texts)


def _faults(words: str) -> str:
    return f"python benchmarks/faults.py --only '{words.partition('^')[0]}'"  # of a pattern


CASES: Sequence[Case] = (
    Case("a slide bed whose F_fm is 15 N, not the default's 23.5 N",
         "F_S 118.5 N (117.6 to 119.4), identified; 130 is true", _faults("F_fm of 15"),
         partial(_fault, "bed", "F_fm of 15 N, the default of 23.5 N", "F_S", "F_C + F_fm")),
    Case("a slide bed whose k_hat is 10 % above the default", "k_spring +34 %, identified",
         _faults("k_hat 10"),
         partial(_fault, "bed", "k_hat 10 % above the default", "k_spring", "k_spring + k_hat+")),
    Case("a force that is cut off", "F_C +11 % at 26 % cut off, identified", f"{SELF} 'cut off'",
         partial(_clipped, 29.0)),
    *(
        Case(f"a force {ms} ms late", "M −23 %, F_V +9 %, identified from 12 to 50 ms",
             _faults(f"force {ms} ms late"),
             partial(_fault, "forced", f"force {ms} ms late", "M", "F_V"))
        for ms in (25, 50)
    ),
    Case("a clock of the force that drifts by 50 ms", "M +24 %, identified",
         _faults("force drifts by 50"),
         partial(_fault, "forced", "clock of the force drifts by 50 ms", "M")),
    Case("a position 100 ms behind a ramp", "F_C 63.0 N (61.2 to 64.7), identified; 60 is true",
         _faults("position 100 ms late"), partial(_fault, "bed", "position 100 ms late", "F_C")),
    Case("an arm's angle 2 ms late", "F_V 0.431 N m s/rad (0.426 to 0.436), identified; 0.3 is "
         "true", _faults("angle 2 ms late"), partial(_fault, "arm", "angle 2 ms late", "F_V")),
    Case("slips from rest to rest, and a measured force", "a ramp to breakaway: no stick-slip",
         f"{SELF} slips", _slips),
    Case("57 mm of travel in steps of 1 mm", "4 steps of the sensor, hardly any motion",
         f"{SELF} '57 mm'", _steps),
    Case("a mill whose positions are rounded", "1.0 A of Coulomb friction; 4.29 A by the recorded "
         "velocity", f"{SELF} mill", _mill),
    Case("noise of 0.64 mrad on a pendulum", "3.3 mrad", f"{SELF} 'noise of 0.64'", _floor),
    *(
        Case(f"a slide with {what}", "nothing said", _faults(words),
             partial(_fault, "forced", words, "F_V"))
        for what, words in (
            ("friction that grows with the square of the speed", "friction with 200 v^2"),
            ("a Stribeck drop under Coulomb's law", "a Stribeck drop of 10 N under Coulomb"),
            ("cogging", "cogging of 6 N every 10 mm"),
            ("a spring", "a spring of 150 N/m"),
            ("friction that warms up", "friction warms up: 30 % more at first"),
        )
    ),
    Case("Dahl's bristles under default steps", "M 20.9 kg (19.8 to 23.9), identified; 15 is true",
         "python benchmarks/intervals.py --only dahl", partial(_held, "dahl", "M")),
    Case("LuGre's bristles", "F_C 53.05 N (52.67 to 53.43), identified; 39.8 is true",
         "python benchmarks/intervals.py --only lugre", partial(_held, "lugre", "F_C")),
    Case("the rotor of a servo pendulum", "held in 12 of 29",
         "python benchmarks/intervals.py --only pendulum", partial(_held, "pendulum", "armature")),
    Case("laws that contain each other, on two real servos", "m4 32.5 mrad where Coulomb-viscous, "
         "which it contains, had 14.9", "python benchmarks/nested_laws.py", _nested),
    Case("K_c of 16 logs of a servo by two losses", "0.0103 to 0.0130 and 0.0174 to 0.0296, both "
         "without a word", f"{SELF} K_c", _losses),
    Case("a slide with Coulomb and viscous friction alone, laws compared",
         "Stribeck warranted, 61 %", f"{SELF} compared", _selected),
    Case("expected running times with heavy tails", "79 % of the intervals hold them",
         "python benchmarks/ert_coverage.py", _ert),
    Case("sigma_0 of 3237 in 1 to 10⁷", "at the lower end", f"{SELF} sigma_0", _end),
    *(
        Case(f"law {law} on a force balance", failed, f"{SELF} '{re.escape(law)}'",
             partial(_term, law))
        for law, failed in (
            ("stribeck+position", "the fit cannot be run at its own parameters"),
            ("coulomb-viscous+position", "a division by zero"),
        )
    ),
)  # fmt: skip


def kept() -> dict[str, str]:
    """What is said now, by what of, as it was last tried."""
    return json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}


def table() -> Table:
    """What was said, what is said now, and the commands."""
    said = kept()
    rows = [
        tuple(map(Cell.label, (c.what, c.earlier, said.get(c.what, "–"), c.command))) for c in CASES
    ]
    heads = ("log", "earlier", "now", "command")
    return Table("What was said of logs, and is said now", heads, tuple(rows))


def main() -> None:
    """Try some or all again."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--only", default="", help="those whose log matches this")
    options = ask.parse_args()
    said = kept()
    for case in CASES:
        if re.search(options.only, case.what) and (now := case.now()) is not None:
            said[case.what] = now
            print(f"{case.what}\n    earlier: {case.earlier}\n    now: {now}", flush=True)
            text = json.dumps(said, indent=1, ensure_ascii=False) + "\n"
            FILE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
