"""What earlier versions said of some logs that was not so, and what is said of these now.

    python benchmarks/reproductions.py [--only WORDS]     try them again
    python benchmarks/faults.py --page                    the table, below that of faults

A row has what was said earlier, what is said now, and the command that shows it. Rows of the fault
table and of other studies are read from their results (`reproduction_results`); the rest is tried
(`reproduction_trials`), some of it on the recordings in `../shared/data` (without them a row stays
as it is). Each goes to reproductions.json.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import reproduction_results as results
import reproduction_trials as trials
from stribeck.report.table import Cell, Table
from stribeck.space import Param

FILE = Path(__file__).with_name("reproductions.json")
SELF = "python benchmarks/reproductions.py --only"
NESTED = "python benchmarks/nested_laws.py"


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


def _faults(words: str) -> str:
    return f"python benchmarks/faults.py --only '{words.partition('^')[0]}'"  # of a pattern


def _intervals(study: str) -> str:
    return f"python benchmarks/intervals.py --only {study}"


CONSTANTS: Sequence[Case] = (
    Case("a slide bed whose F_fm is 15 N, not the default's 23.5 N",
         "F_S 118.5 N (117.6 to 119.4), identified; 130 is true", _faults("F_fm of 15"),
         partial(results.fault, "bed", "F_fm of 15 N, the default of 23.5 N", "F_S", "F_C + F_fm")),
    Case("the same, as to F_C", "F_C at 40 N, the end of its range; 60 is true",
         _faults("F_fm of 15"),
         partial(results.fault, "bed", "F_fm of 15 N, the default of 23.5 N", "F_C")),
    Case("a slide bed whose k_hat is 10 % above the default", "k_spring +34 %, identified",
         _faults("k_hat 10"), partial(results.fault, "bed", "k_hat 10 % above the default",
                                      "k_spring", "k_spring + k_hat+")),
    Case("a slide bed on the constants of the paper's machine", "nothing said",
         f"{SELF} 'constants of'", trials.borrowed),
)  # fmt: skip
DATA: Sequence[Case] = (
    Case("logs with a fault, of all kinds of rigs",
         "32 of 80 with an identified value 5 % off and outside its interval, most without a word",
         "python benchmarks/run.py --only faults", results.faulty),
    Case("a force that is cut off", "F_C +11 % at 26 % cut off, identified", f"{SELF} 'cut off'",
         partial(trials.clipped, 29.0)),
    *(
        Case(f"a force {ms} ms late", "M −23 %, F_V +9 %, identified from 12 to 50 ms",
             _faults(f"force {ms} ms late"),
             partial(results.fault, "forced", f"force {ms} ms late", "M", "F_V"))
        for ms in (25, 50)
    ),
    Case("a clock of the force that drifts by 50 ms", "M +24 %, identified",
         _faults("force drifts by 50"),
         partial(results.fault, "forced", "clock of the force drifts by 50 ms", "M")),
    Case("a position 100 ms behind a ramp", "F_C 63.0 N (61.2 to 64.7), identified; 60 is true",
         _faults("position 100 ms late"),
         partial(results.fault, "bed", "position 100 ms late", "F_C")),
    Case("an arm's angle 2 ms late", "F_V 0.431 N m s/rad (0.426 to 0.436), identified; 0.3 is "
         "true", _faults("angle 2 ms late"),
         partial(results.fault, "arm", "angle 2 ms late", "F_V")),
    Case("slips from rest to rest, and a measured force", "a ramp to breakaway: no stick-slip",
         f"{SELF} slips", trials.slips),
    Case("57 mm of travel in steps of 1 mm", "4 steps of the sensor, hardly any motion",
         f"{SELF} '57 mm'", trials.steps),
    Case("a mill whose positions are rounded", "1.0 A of Coulomb friction; 4.29 A by the recorded "
         "velocity", f"{SELF} mill", trials.mill),
    Case("noise of 0.64 mrad on a pendulum", "3.3 mrad", f"{SELF} 'noise of 0.64'", trials.floor),
)  # fmt: skip
MODEL: Sequence[Case] = (
    *(
        Case(f"a slide with {what}", "nothing said", _faults(words),
             partial(results.fault, "forced", words, "F_V"))
        for what, words in (
            ("friction that grows with the square of the speed", "friction with 200 v^2"),
            ("a Stribeck drop under Coulomb's law", "a Stribeck drop of 10 N under Coulomb"),
            ("cogging", "cogging of 6 N every 10 mm"),
            ("a spring", "a spring of 150 N/m"),
            ("friction that warms up", "friction warms up: 30 % more at first"),
        )
    ),
    Case("a slide beside which a neighbour moves", "M identified", _faults("a neighbour pulls"),
         partial(results.fault, "forced", "a neighbour pulls with 8 N at 0.37 Hz", "M", "F_V")),
    Case("a joint of an arm whose others move, half of the log held out", "inertia identified, and "
         "nothing said of a held-out error twice that of training", f"{SELF} 'others move'",
         trials.moving_neighbours),
    Case("three joints of an arm whose slips scatter", "nothing identified, and wrong advice",
         "python benchmarks/run.py --only axes", results.breakaway),
    Case("three logs of a servo, one with half as much friction again", "nothing said",
         f"{SELF} 'half as much'", trials.differing_logs),
)  # fmt: skip
ARITHMETIC: Sequence[Case] = (
    Case("Dahl's bristles under default steps", "M 20.9 kg (19.8 to 23.9), identified; 15 is true",
         _intervals("dahl"), partial(results.held, "dahl", "M")),
    Case("Dahl's bristles at the parameters that made the log",
         "0.50 um off under default steps, beside 0.38 um of noise", f"{SELF} 'that made'",
         trials.bristle_error),
    Case("LuGre's bristles", "F_C 53.05 N (52.67 to 53.43), identified; 39.8 is true",
         _intervals("lugre"), partial(results.held, "lugre", "F_C")),
    Case("the rotor of a servo pendulum", "held in 12 of 29", _intervals("pendulum"),
         partial(results.held, "pendulum", "armature")),
    Case("laws that contain each other, on two real servos", "m4 32.5 mrad where Coulomb-viscous, "
         "which it contains, had 14.9", NESTED, results.nested),
    Case("searches of m1 on 16 logs of a servo", "1,790 evaluations, within 1 % after 60 to 149",
         NESTED, partial(results.evaluations, "m1")),
    Case("intervals of m4 on 16 logs of a servo", "22 of 22 ends are guesses",
         f"{NESTED} xl330 --laws m4 --losses absolute --seeds 1 --intervals",
         partial(results.guessed, "m4")),
    *(
        Case(f"{name} of 16 logs of a servo by two losses", earlier, f"{SELF} {name}",
             partial(trials.losses, name))
        for name, earlier in (
            ("K_c", "0.0103 to 0.0130 and 0.0174 to 0.0296, both without a word"),
            ("K_v", "0.0106 (0.0097 to 0.0115), identified, and 0.0071"),
        )
    ),
    Case("sigma_0 of 3237 in 1 to 10⁷", "at the lower end", f"{SELF} sigma_0", trials.end),
    Case("an interval of v_SS from 2.6 to 573 rad/s", "weak", f"{SELF} 573",
         partial(trials.degenerate, Param("v_SS", 1e-3, 1e3, "rad/s", log=True), 40.0, 2.6, 573.0)),
    Case("an interval from 0 to 0", "weak", f"{SELF} '0 to 0'",
         partial(trials.degenerate, Param("K_cs", 0.0, 0.5, "N m"), 0.0, 0.0, 0.0)),
    *(
        Case(f"law {law} on a force balance", failed, f"{SELF} '{re.escape(law)}'",
             partial(trials.term, law))
        for law, failed in (
            ("stribeck+position", "the fit cannot be run at its own parameters"),
            ("coulomb-viscous+position", "a division by zero"),
        )
    ),
    Case("expected running times with heavy tails", "79 % of the intervals hold them",
         "python benchmarks/ert_coverage.py", results.running_times),
)  # fmt: skip
WORDS: Sequence[Case] = (
    Case("a slide with Coulomb and viscous friction alone, laws compared",
         "Stribeck warranted, 61 %", f"{SELF} compared", trials.selected),
    Case("directions asked of a log that runs one way",
         "not warranted, for 26 of 40 thousand evaluations", f"{SELF} 'directions asked'",
         trials.one_way_laws),
    Case("a slide bed that was driven one way", "both directions share one parameter set",
         f"{SELF} 'driven one way'", trials.one_way_words),
    Case("axes identified again with other noise", "12.5 % of the verdicts are others, "
         "without a word", "python benchmarks/noise_seeds.py --axes 24",
         results.flips),
    Case("plan: a bed driven to smaller positions", "in the other direction",
         f"{SELF} 'smaller positions'", partial(trials.planned, "starts from rest")),
    Case("plan: a finer sensor", "a position sensor of a third of the noise, 0 mm",
         f"{SELF} 'a finer sensor'", partial(trials.planned, "finer sensor")),
    Case("plan: a log without noise", "a position sensor of a third of the noise, 0 mm",
         f"{SELF} 'without noise'", trials.noiseless_plan),
    Case("an arm whose rig leaves something out, all repeats alike",
         "raise --repeats, widen the ranges", _faults("torque held"),
         partial(results.told, "arm", "torque held for a sample of 10 ms")),
)  # fmt: skip
CASES = (*CONSTANTS, *DATA, *MODEL, *ARITHMETIC, *WORDS)


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
