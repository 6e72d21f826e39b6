"""Logs of 10 GB: one axis out of sixty channels, beside the format's own library.

    python benchmarks/large_logs.py [--size GB] [--only csv hdf5 mf4] [--folder DIR]

A log is made in chunks by the library of its format: an axis of 5 kg under 12 N, 30 N s/m and an
offset of 0.5 N at 1 kHz, with noise on its force, and fifty-six channels of other axes. Each figure
is that of a process of its own: its processor seconds and the most memory it took, its children's
included where they ran beside it. The library reads the same three channels, as its documentation
says. The file of a format is deleted before the next is made.
"""

# ruff: noqa: PLC0415 - a process that is measured loads what it uses, no more

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np

RATE, CHUNK = 1000.0, 1 << 17
OTHERS = 56
NAMES = ("t [s]", "x [m]", "F [N]", "v [m/s]", *(f"other {k} [A]" for k in range(1, OTHERS + 1)))
USED = NAMES[:3]
WINDOW = "@600s:1000s"
RESULTS = Path(__file__).with_suffix(".json")
Table = dict[str, np.ndarray[Any, Any]]


def chunks(rows: int) -> Iterator[Table]:
    """The log in chunks: 8-byte numbers as a drive's tool rounds them."""
    rng = np.random.default_rng(0)
    w, w2 = 2 * np.pi * 0.23, 2 * np.pi * 0.031
    for start in range(0, rows, CHUNK):
        t = np.arange(start, min(start + CHUNK, rows)) / RATE
        v = 0.1 * w * np.cos(w * t) + 0.05 * w2 * np.cos(w2 * t + 1)
        a = -0.1 * w * w * np.sin(w * t) - 0.05 * w2 * w2 * np.sin(w2 * t + 1)
        force = 12 * np.sign(v) + 30 * v + 5 * a + 0.5 + 0.3 * rng.standard_normal(len(t))
        x = 0.1 * np.sin(w * t) + 0.05 * np.sin(w2 * t + 1) + 1e-7 * rng.standard_normal(len(t))
        axis = (t, x.round(8), force.round(5), v.round(6))
        others = rng.integers(-99_999, 99_999, (OTHERS, len(t))) / 1e4
        yield dict(zip(NAMES, (*axis, *others), strict=True))


def make_csv(path: Path, rows: int) -> None:
    """CSV by polars."""
    import polars as pl

    with path.open("wb") as file:
        for k, table in enumerate(chunks(rows)):
            pl.DataFrame(table).write_csv(file, include_header=k == 0)


def make_hdf5(path: Path, rows: int) -> None:
    """HDF5 by h5py: a dataset a channel, in its own chunks."""
    import h5py

    with h5py.File(path, "w") as file:
        sets = {n: file.create_dataset(n.replace("/", " per "), (rows,), "f8", chunks=(CHUNK,))
                for n in NAMES}  # fmt: skip
        for k, table in enumerate(chunks(rows)):
            for name, values in table.items():
                sets[name][k * CHUNK : k * CHUNK + len(values)] = values


def make_mf4(path: Path, rows: int) -> None:
    """MF4 by asammdf: one channel group, extended chunk by chunk."""
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        for k, table in enumerate(chunks(rows)):
            t, names = table[NAMES[0]], NAMES[1:]
            if k == 0:
                file.append([Signal(table[n], t, name=n.split(" [")[0], unit=n.split("[")[1][:-1])
                             for n in names])  # fmt: skip
            else:
                file.extend(0, [(t, None), *((table[n], None) for n in names)])
        file.save(path, overwrite=True)


def library_csv(path: Path) -> int:
    """Polars, lazily."""
    import polars as pl

    return pl.scan_csv(path).select(USED).collect(engine="streaming").height


def library_hdf5(path: Path) -> int:
    """The datasets by h5py."""
    import h5py

    with h5py.File(path) as file:
        return min(len(file[n][:]) for n in USED)


def library_mf4(path: Path) -> int:
    """`MDF.select`."""
    from asammdf import MDF

    with MDF(path) as file:
        return min(len(s.samples) for s in file.select(["x", "F"]))


def ours_read(path: Path) -> int:
    """A recording."""
    import stribeck

    return len(stribeck.read(str(path)))


def ours_window(path: Path) -> int:
    """A recording of a window of 400 s."""
    import stribeck

    return len(stribeck.read(f"{path}{WINDOW}"))


def ours_identify(path: Path | str) -> int:
    """From the file to the fit."""
    import stribeck

    fit = stribeck.identify(str(path), rig="forced")
    print([f"{e.name} = {e.value:.6g}" for e in fit.estimates], file=sys.stderr)
    return sum(len(log) for log in fit.recordings)


def ours_identify_window(path: Path) -> int:
    """From a window of the file to the fit."""
    return ours_identify(f"{path}{WINDOW}")


FORMATS: dict[str, tuple[Callable[[Path, int], None], Callable[[Path], int], str, float]] = {
    # maker, library, extension, bytes a row
    "csv": (make_csv, library_csv, ".csv", 453.3),
    "hdf5": (make_hdf5, library_hdf5, ".h5", 480.0),
    "mf4": (make_mf4, library_mf4, ".mf4", 480.0),
}
TASKS = {
    "read": ours_read,
    "window": ours_window,
    "identify_window": ours_identify_window,
    "identify": ours_identify,
}


def resident(pid: int) -> int:
    """Bytes that a process and its children have in memory now."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1])
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE") + sum(resident(int(child)) for child in children)


def measured(task: str, kind: str, path: Path) -> dict[str, float]:
    """Rows, processor seconds, wall seconds and peak memory of a task in a process of its own."""
    began, before = monotonic(), os.times()
    command = [sys.executable, "-P", __file__, "--task", task, "--kind", kind, "--file", str(path)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603 - ours
    peak = 0
    while process.poll() is None:
        peak = max(peak, resident(process.pid))
        sleep(0.05)
    after = os.times()
    if process.returncode or process.stdout is None:
        raise SystemExit(f"{task} of {path} failed")
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return {
        "rows": int(process.stdout.read().split()[-1]),
        "cpu_s": round(cpu, 1),
        "wall_s": round(monotonic() - began, 1),
        "peak_MB": round(peak / 1e6),
    }


def main() -> None:
    """Make each file, measure, delete it; write the results beside this program."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", type=float, default=10.0)
    parser.add_argument("--only", nargs="*", default=list(FORMATS))
    parser.add_argument("--tasks", nargs="*", default=["library", *TASKS])
    parser.add_argument("--folder", type=Path, default=None)
    parser.add_argument("--keep", action="store_true")
    for name in ("task", "kind", "file"):
        parser.add_argument(f"--{name}")
    asked = parser.parse_args()
    if asked.task:
        task = FORMATS[asked.kind][1] if asked.task == "library" else TASKS[asked.task]
        print(task(Path(asked.file)))
        return
    results = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    results["machine"] = f"{os.cpu_count()} processors, {platform.system()} {platform.machine()}"
    for kind in asked.only:
        make, _, extension, row = FORMATS[kind]
        with tempfile.TemporaryDirectory(dir=asked.folder) as folder:
            path = Path(asked.folder if asked.keep else folder) / f"large{extension}"
            if not path.exists():
                make(path, int(asked.size * 1e9 / row))
            entry = results.setdefault(kind, {})
            entry["GB"] = round(path.stat().st_size / 1e9, 2)
            for task in asked.tasks:
                entry[task] = measured(task, kind, path)
                print(kind, task, entry[task], flush=True)
            RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
