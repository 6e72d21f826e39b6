"""What a log becomes behind a drive: five meanings of percent, and an uncertain scale.

    python tools/drive_study.py percent LOG.csv --columns MAP.toml
    python tools/drive_study.py scale LOG.mat --columns MAP.toml
    python tools/drive_study.py loads FOLDER --columns MAP.toml

`percent` reads one log as five drives would have recorded it, all with one motor; what differs is
what their makers call 100 %. `scale` states the last number of the map's chain less and less well.
`loads` looks at logs of a pendulum with known weights whose motor drives throughout.
"""

from __future__ import annotations

import argparse
from math import sqrt
from pathlib import Path

from stribeck import identify, read
from stribeck.data.readers.log_map import LogMap
from stribeck.identify.balance.known_load import stated_loads

#: A motor's data sheet: rated, standstill and peak torque, rated current, torque constant.
SHEET = {
    "rated_torque": "1.3 N m",
    "standstill_torque": "1.43 N m",
    "rated_current": "2.6 A rms",
    "kt": "0.52 N m/A rms",
    "peak_torque": "3.8 N m",
}
#: Conventions with the numbers that they take, and 100 % in N m by their documents.
CONVENTIONS = {
    "mitsubishi-mr": (("rated_torque",), 1.3),
    "ax8000": (("standstill_torque",), 1.43),
    "ax5000": (("peak_torque",), 3.8),
    "el72x1-rms": (("rated_current", "kt"), 2.6 * 0.52),
    "el72x1-peak": (("rated_current", "kt"), 2.6 / sqrt(2) * 0.52),
}
#: Tolerances of the scale, percent.
TOLERANCES = (1, 2, 5, 10)


def percent(log: Path, columns: Path) -> None:
    """Print friction and inertia by five conventions."""
    print("convention     100 % / N m   F_C / N m  F_V / N m s   J / g m²  F_V / F_C  J / F_C")
    for name, (needed, hundred) in CONVENTIONS.items():
        numbers = {n: SHEET[n] for n in needed}
        if name == "el72x1-peak":  # the same number, which that drive takes for a peak value
            numbers["rated_current"] = "2.6 A peak"
        drive = {"convention": name, **numbers}
        recording = read(log, columns=LogMap.of(columns).columns, drive=drive)
        fit = identify(recording, rig="forced-rotary", law="coulomb-viscous", fixed={"offset": 0.0})
        F_C, F_V, J = (fit.values[n] for n in ("F_C", "F_V", "M"))
        print(
            f"{name:14} {hundred:11.3f} {F_C:11.5f} {F_V:12.3e} {1e3 * J:10.5f} "
            f"{F_V / F_C:10.3e} {J / F_C:8.3e}"
        )


def scale(log: Path, columns: Path) -> None:
    """Print intervals of levels and of their ratio for tolerances of the scale."""
    chain = LogMap.of(columns).drive
    assert chain is not None  # noqa: S101 - the map that this is called with has one
    table = chain.table()
    number = list(chain.numbers)[-1]
    value = chain.numbers[number].constant
    heads = ("M / kg", "F_C / N", "F_V / N s/m", "M/F_C, kg/N", "F_V/F_C, s/m")
    print(f"{number} ±  " + "".join(f"{head:16}" for head in heads).rstrip())
    for tolerance in TOLERANCES:
        table[number] = f"{value.shown:g} {value.unit} ± {tolerance} %"
        recording = read(log, columns=LogMap.of(columns).columns, drive=table)
        fit = identify(recording, rig="forced", law="coulomb-viscous")
        ends = {e.name: (e.low, e.high) for e in fit.estimates}
        ends |= {r.name: (r.low, r.high) for r in fit.ratios}
        names = ("M", "F_C", "F_V", "M / F_C", "F_V / F_C")
        cells = [f"{ends[n][0]:.4g} to {ends[n][1]:.4g}" for n in names]
        print(f"{tolerance:5} %  " + "".join(f"{cell:16}" for cell in cells).rstrip())


def loads(folder: Path, columns: Path) -> None:
    """Print the gravity of each log, and what is told of the scale."""
    logs = [read(file, columns=columns) for file in sorted(folder.glob("*.json"))]
    logs = [log for log in logs if log.extra["torque_enable"].all()]
    fit = identify(logs, rig="forced-pendulum", law="coulomb-viscous")
    gravity = next(s for s in fit.differing.spreads if s.parameter == "g_sin")
    print("log                       weight / kg  its torque / N m  g_sin / N m")
    for log, load, value, error in zip(
        logs, stated_loads(logs), gravity.values, gravity.errors, strict=True
    ):
        mass = log.extra["mass"][0]
        print(f"{log.label:25} {mass:11.0f} {load:17.3f}  {value:.3f} ± {2 * error:.3f}")
    for violation in fit.violations:
        if "loads" in violation.sentence:
            print(violation.sentence)


def main() -> None:
    """Run the study named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("study", choices=["percent", "scale", "loads"])
    parser.add_argument("log", type=Path)
    parser.add_argument("--columns", type=Path, required=True)
    arguments = parser.parse_args()
    {"percent": percent, "scale": scale, "loads": loads}[arguments.study](
        arguments.log, arguments.columns
    )


if __name__ == "__main__":
    main()
