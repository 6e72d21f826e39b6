"""Damaged inputs for everything that reads: each must be accepted, or refused in one line.

    python tools/fuzz.py FOLDER [--seconds 300 | --inputs 10000] [--targets text,card] [--seed 0]

Input number i of a target follows from the seed, the target and i alone (`fuzz_mutation`), so that
a finding can be made again. Each target runs in a process of its own; where that ends (an abort),
or an input takes longer than a minute of the clock (a hang), another goes on behind it. A finding
is a traceback, an abort, a hang, or an input that takes more than 200 MiB; it is written to
FOLDER/TARGET-SEED-NUMBER, with what happened beside it. Counts are added to FOLDER/counts.json.
"""

from __future__ import annotations

import argparse
import json
import mmap
import os
import struct
import subprocess
import sys
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from random import Random

from fuzz_forks import ForkedProcesses
from fuzz_inputs import TARGETS, prepare
from fuzz_mutation import mutated
from stribeck.errors import InputError

#: An input that takes longer is a hang: seconds.
HANG = 60.0
#: An input that takes more, or a process of a library that does, is a finding: MiB.
MOST, MOST_LIBRARY = 200, 400
#: Inputs that one process tries: what libraries keep of each would add up.
BATCH = 20_000
_COLUMNS = ("inputs", "accepted", "refused", "traceback", "hang", "abort", "memory")


def outcome(name: str, data: bytes) -> tuple[str, str]:
    """What a target makes of an input (accepted, refused, traceback), and the line or traceback."""
    target = TARGETS[name]
    Path(target.file).parent.mkdir(exist_ok=True)
    Path(target.file).write_bytes(data)
    try:
        target.call(data)
    except InputError as error:
        if str(error).isprintable() and str(error):
            return "refused", str(error)
        return "traceback", f"not one printable line: {error!r}"
    except Exception:  # noqa: BLE001 - that is what is looked for
        return "traceback", traceback.format_exc()
    return "accepted", ""


def random_numbers(name: str, seed: int, number: int) -> Random:
    """The random numbers of an input."""
    return Random(f"{name} {seed} {number}")  # noqa: S311 - nothing secret


def run(name: str, seed: int, first: int, inputs: int, seconds: float, folder: Path) -> None:
    """Try inputs `first` and on in this process, and print the counts.

    The number of the input, and counts so far, stand in FOLDER/.progress all the time.
    """
    warnings.simplefilter("error")
    corpus = TARGETS[name].corpus()
    end = time.monotonic() + seconds
    counts: Counter[str] = Counter()
    peak = 0
    with (
        ForkedProcesses() as forked,
        (folder / ".progress").open("r+b") as file,
        mmap.mmap(file.fileno(), 0) as progress,
    ):
        for number in range(first, first + inputs):
            if time.monotonic() > end:
                break
            data = mutated(corpus, random_numbers(name, seed, number))
            before, library = memory_now(), forked.peak
            kind, line = outcome(name, data)
            peak = max(peak, memory("VmHWM"), forked.peak)
            if kind == "traceback":
                keep(folder, name, seed, number, data, line)
            elif memory("VmHWM") - before > MOST or forked.peak > max(MOST_LIBRARY, library):
                keep(folder, name, seed, number, data, f"memory: {peak} MiB, {line}")
                counts["memory"] += 1
            counts[kind] += 1
            counts["inputs"] += 1
            progress[:] = struct.pack("=9q", number + 1, *(counts[c] for c in _COLUMNS), peak)


def keep(folder: Path, name: str, seed: int, number: int, data: bytes, text: str) -> None:
    """Write a finding."""
    (folder / f"{name}-{seed}-{number}").write_bytes(data)
    (folder / f"{name}-{seed}-{number}.txt").write_text(text, encoding="utf-8")


def memory_now() -> int:
    """What this process takes now, MiB; its peak counts from now on."""
    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:  # noqa: PTH123 - as below
        file.write("5")
    return memory("VmHWM")


def memory(entry: str) -> int:
    """An entry of what Linux says of this process's memory, MiB."""
    with open("/proc/self/status", encoding="ascii") as status:  # noqa: PTH123 - often, so fast
        return next(int(line.split()[1]) for line in status if line.startswith(entry)) // 1024


def campaign(
    name: str, seed: int, first: int, inputs: int, seconds: float, folder: Path
) -> Counter[str]:
    """Try inputs of a target in processes of their own; counts, `peak` the most memory in MiB."""
    total: Counter[str] = Counter()
    peak, end, begin = 0, time.monotonic() + seconds, first
    work = folder / "work"
    work.mkdir(parents=True, exist_ok=True)
    progress = folder / ".progress"
    while begin < first + inputs and (left := end - time.monotonic()) > 0:
        progress.write_bytes(struct.pack("=9q", begin, *[0] * 8))
        arguments = (name, seed, begin, min(first + inputs - begin, BATCH), left, folder.resolve())
        command = [sys.executable, str(Path(__file__).resolve()), "--process", *map(str, arguments)]
        with (folder / ".errors").open("wb") as errors:
            process = subprocess.Popen(  # noqa: S603 - this program
                command, cwd=work, stdout=subprocess.DEVNULL, stderr=errors
            )
            hung = _watch(process, progress)
        number, *counts, most = struct.unpack("=9q", progress.read_bytes())
        total.update(dict(zip(_COLUMNS, counts, strict=True)))
        peak, begin = max(peak, most), number
        if process.returncode == 1:
            raise SystemExit((folder / ".errors").read_text(encoding="utf-8"))
        if process.returncode:
            kind = "hang" if hung else "abort"
            total.update({kind: 1, "inputs": 1})
            data = _again(name, seed, number, work)
            keep(folder, name, seed, number, data, f"{kind}: status {process.returncode}")
            begin = number + 1
    total["peak"] = peak
    return total


def _watch(process: subprocess.Popen[bytes], progress: Path) -> bool:
    """Wait for a process; whether it was ended because an input took too long."""
    last, since = b"", time.monotonic()
    while process.poll() is None:
        time.sleep(0.2)
        if (now := progress.read_bytes()) != last:
            last, since = now, time.monotonic()
        elif time.monotonic() - since > HANG:
            process.kill()
            process.wait()
            return True
    return False


def _again(name: str, seed: int, number: int, work: Path) -> bytes:
    """The input of a number, made again."""
    here = Path.cwd()
    os.chdir(work)
    try:
        return mutated(TARGETS[name].corpus(), random_numbers(name, seed, number))
    finally:
        os.chdir(here)


def main() -> None:
    """Try all targets in turn, add the counts and print them."""
    if sys.argv[1:2] == ["--process"]:
        name, seed, first, inputs, seconds, folder = sys.argv[2:]
        run(name, int(seed), int(first), int(inputs), float(seconds), Path(folder))
        return
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=300.0, help="for all targets together")
    parser.add_argument("--inputs", type=int, default=1 << 62, help="at most, for each target")
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--targets", default=",".join(TARGETS))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    names = options.targets.split(",")
    (options.folder / "work").mkdir(parents=True, exist_ok=True)
    here = Path.cwd()
    os.chdir(options.folder / "work")
    prepare()
    os.chdir(here)
    file = options.folder / "counts.json"
    record = json.loads(file.read_text()) if file.exists() else {}
    for name in names:
        counts = campaign(name, options.seed, options.first, options.inputs,
                          options.seconds / len(names), options.folder)  # fmt: skip
        stored = record.setdefault(name, dict.fromkeys((*_COLUMNS, "peak"), 0))
        for column in _COLUMNS:
            stored[column] += counts[column]
        stored["peak"] = max(stored["peak"], counts["peak"])
        file.write_text(json.dumps(record, indent=1) + "\n")
        print(name, *(f"{c} {counts[c]}" for c in (*_COLUMNS, "peak") if counts[c]), flush=True)


if __name__ == "__main__":
    main()
