"""Compare the results of two checkouts: the same runs on both, and every number that differs.

    python tools/compare_results.py record CHECKOUT OUT_DIR [--only NAME ...] [--jobs N]
                                           [--inputs RECORDING]
    python tools/compare_results.py compare BEFORE AFTER [--only NAME ...] [--all]
    python tools/compare_results.py list CHECKOUT

`record` runs the list of result_runs.py on a checkout's sources with the Python that runs this
script, each run in a folder of its own, and keeps what was printed, the exit status and the files.
A run that is finished is not run again: the same command goes on where it was. Cards that a run
reads are those that the checkout's own runs made, or, with `--inputs`, those of another recording:
then a difference in one card is not told again by everything that reads it. A checkout whose
sources have changed needs a new folder.

`compare` blanks what changes from run to run (result_differences.py says what, and why), prints a
table of the runs and each field that differs, and exits with 1 if anything does. A run that only
AFTER has is shown and is no difference.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from result_differences import (
    Difference,
    file_differences,
    one_sided,
    printed_differences,
    without_progress,
)
from result_runs import Run, all_runs, makers

RECORDING, RESULT, RUNS = "recording.json", "result.json", "runs"
#: The parts of its checkout that a run has.
LINKED = ("README.md", "benchmarks", "docs", "tools")
#: Files of these kinds are drawn, or hold the same as another file and times: only their names are
#: kept.
DRAWN = (".png", ".svg", ".html", ".parquet", ".sqlite")
#: Differences of a run that are shown.
SHOWN = 12


def main() -> None:
    """Carry out the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(required=True, dest="command")
    recorder = commands.add_parser("record", help="run the list on a checkout")
    recorder.add_argument("checkout", type=Path)
    recorder.add_argument("out", type=Path)
    recorder.add_argument("--only", nargs="+", default=[], metavar="NAME", help="part of a name")
    recorder.add_argument("--jobs", type=int, default=1, help="runs at a time")
    recorder.add_argument("--inputs", type=Path, help="a recording whose cards are read")
    comparer = commands.add_parser("compare", help="hold two recordings against each other")
    comparer.add_argument("before", type=Path)
    comparer.add_argument("after", type=Path)
    comparer.add_argument("--only", nargs="+", default=[], metavar="NAME", help="part of a name")
    comparer.add_argument("--all", action="store_true", help="show every difference")
    lister = commands.add_parser("list", help="the runs and about what they cost")
    lister.add_argument("checkout", type=Path)
    options = parser.parse_args()
    if options.command == "record":
        checkout, out = options.checkout.resolve(), options.out.resolve()
        inputs = options.inputs.resolve() if options.inputs else None
        Recorder(checkout, out, inputs).record(options.only, options.jobs)
    elif options.command == "compare":
        sys.exit(compare(options.before, options.after, options.only, everything=options.all))
    else:
        runs = all_runs(options.checkout.resolve())
        for run in runs:
            print(f"{run.cost:4d} s  {run.name}")
        print(f"{sum(r.cost for r in runs):4d} s of CPU time, {len(runs)} runs")


def chosen(runs: Iterable[Run], only: Sequence[str]) -> list[Run]:
    """The runs whose names contain one of the words; all without words."""
    return [r for r in runs if not only or any(word in r.name for word in only)]


# --- record ---------------------------------------------------------------------------------------


class Recorder:
    """Runs of a checkout, kept in a folder."""

    def __init__(self, checkout: Path, out: Path, inputs: Path | None = None) -> None:
        self.checkout, self.out, self.inputs = checkout, out, inputs
        self.runs = all_runs(checkout)

    def record(self, only: Sequence[str], jobs: int) -> None:
        """Run the chosen runs that are not finished; those whose files others read come first.

        Raises:
            SystemExit: The folder holds results of other sources, or the checkout is not imported.
        """
        self._open()
        queue: list[Run] = []
        for run in chosen(self.runs, only):
            self._add(run, queue)
        todo = [run for run in queue if not (self._folder(run) / RESULT).exists()]
        print(f"{len(queue) - len(todo)} of {len(queue)} runs are finished", flush=True)
        ready = {run.name: threading.Event() for run in todo}

        def work(run: Run) -> None:
            for maker in self._makers(run):
                if maker.name in ready:
                    ready[maker.name].wait()
            try:
                result = self._run(run)
                print(f"{result['cpu_seconds']:7.1f} s  {result['status']}  {run.name}", flush=True)
            finally:
                ready[run.name].set()

        with ThreadPoolExecutor(max(jobs, 1)) as pool:
            list(pool.map(work, todo))
        total = sum(_result(self._folder(run))["cpu_seconds"] for run in queue)
        print(f"{total:7.1f} s of CPU time, {len(queue)} runs, in {self.out}")

    def _makers(self, run: Run) -> list[Run]:
        return [] if self.inputs else makers(run, self.runs)

    def _add(self, run: Run, queue: list[Run]) -> None:
        """Add a run behind the runs whose files it reads."""
        for maker in self._makers(run):
            self._add(maker, queue)
        if run not in queue:
            queue.append(run)

    def _folder(self, run: Run) -> Path:
        return self.out / RUNS / run.folder

    def _open(self) -> None:
        """Start or continue a recording."""
        head = {
            "sources": _fingerprint(self.checkout),
            "inputs": str(self.inputs) if self.inputs else None,
        }
        file = self.out / RECORDING
        if file.exists() and json.loads(file.read_text(encoding="utf-8")) != head:
            sys.exit(f"{self.out} is of other sources or inputs: take a new folder")
        programs = self.out / "bin"
        programs.mkdir(parents=True, exist_ok=True)
        for name, command in (("python", ""), ("stribeck", "-m stribeck ")):
            script = programs / name
            script.write_text(f'#!/bin/sh\nexec "{sys.executable}" {command}"$@"\n')
            script.chmod(0o755)
        imported = subprocess.run(
            [sys.executable, "-c", "import stribeck; print(stribeck.__file__)"],
            check=True, capture_output=True, text=True, env=self._environment(), cwd=self.out,
        ).stdout  # fmt: skip
        if not Path(imported.strip()).resolve().is_relative_to(self.checkout / "src"):
            sys.exit(f"{imported.strip()} is imported, which is not in {self.checkout}")
        file.write_text(json.dumps(head, indent=1) + "\n", encoding="utf-8")

    def _environment(self) -> dict[str, str]:
        programs = (str(self.out / "bin"), str(Path(sys.executable).parent), os.environ["PATH"])
        return {
            **os.environ,
            "PYTHONPATH": str(self.checkout / "src"),
            "PATH": os.pathsep.join(programs),
            "COLUMNS": "100",
            "LC_ALL": "C.UTF-8",
        }

    def _run(self, run: Run) -> dict[str, Any]:
        """Run in a fresh folder; the files below its `root` are the run's."""
        folder = self._folder(run)
        shutil.rmtree(folder, ignore_errors=True)
        root = folder / "root"
        (root / "demo").mkdir(parents=True)
        (folder / "shared").symlink_to((self.checkout / ".." / "shared").resolve())
        for name in LINKED:
            (root / name).symlink_to(self.checkout / name)
        read = self._provide(run, root)
        status, stdout, stderr, seconds = _execute(run.command, root, self._environment())
        for name in LINKED:
            (root / name).unlink()
        (folder / "shared").unlink()
        for path in read:
            path.unlink(missing_ok=True)
        drawn = []
        for path in sorted(p for p in root.rglob("*") if p.is_file()):
            if path.suffix in DRAWN:
                drawn.append(str(path.relative_to(root)))
                path.unlink()
        result = {
            "name": run.name, "command": run.command, "cpu_seconds": round(seconds, 1),
            "status": status, "stdout": stdout, "stderr": stderr, "drawn": drawn,
        }  # fmt: skip
        unfinished = folder / f"{RESULT}.part"
        unfinished.write_text(json.dumps(result, indent=1, ensure_ascii=False), encoding="utf-8")
        unfinished.rename(folder / RESULT)
        return result

    def _provide(self, run: Run, root: Path) -> list[Path]:
        """Copies of the run's input files; those that it does not write itself."""
        copies = []
        for maker in makers(run, self.runs):
            recorded = (self.inputs or self.out) / RUNS / maker.folder / "root"
            if not recorded.exists():
                sys.exit(f"{run.name}: {recorded} is not recorded")
            shutil.copytree(recorded, root, dirs_exist_ok=True)
            copies += [root / p.relative_to(recorded) for p in recorded.rglob("*") if p.is_file()]
        for path in run.outputs:
            shutil.rmtree(root / path, ignore_errors=True)
            (root / path).unlink(missing_ok=True)
        return [path for path in copies if path.exists()]


def _execute(command: str, root: Path, environment: dict[str, str]) -> tuple[int, str, str, float]:
    """Exit status, both outputs and CPU seconds of a command with all its children."""
    out, err = root.parent / "stdout", root.parent / "stderr"
    with out.open("wb") as stdout, err.open("wb") as stderr:
        child = subprocess.Popen(  # noqa: S602 - the commands are the list's own
            command, shell=True, cwd=root, env=environment, stdout=stdout, stderr=stderr,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    texts = [file.read_text(encoding="utf-8", errors="replace") for file in (out, err)]
    out.unlink()
    err.unlink()
    return child.returncode, texts[0], texts[1], usage.ru_utime + usage.ru_stime


def _fingerprint(checkout: Path) -> str:
    """A hash of the sources that runs use."""
    total = hashlib.sha256()
    for folder in ("src", "tools", "benchmarks"):
        for file in sorted((checkout / folder).rglob("*")):
            if file.suffix in (".py", ".toml", ".c", ".h"):
                total.update(f"{file.relative_to(checkout)}\n".encode())
                total.update(file.read_bytes())
    return total.hexdigest()


# --- compare --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Verdict:
    """The outcome of a comparison of one run."""

    name: str
    word: str
    differences: list[Difference]


def compare(before: Path, after: Path, only: Sequence[str], *, everything: bool) -> int:
    """Print what differs; the exit status."""
    sides = [_results(folder) for folder in (before, after)]
    names = [*sides[0], *(n for n in sides[1] if n not in sides[0])]
    verdicts = [
        _verdict(name, sides[0].get(name), sides[1].get(name))
        for name in names
        if not only or any(word in name for word in only)
    ]
    for v in verdicts:
        print(f"{v.word:15s} {v.name}")
    for v in verdicts:
        if v.differences:
            print(f"\n{v.name}")
            _print_differences(v.differences if everything else v.differences[:SHOWN])
            if (hidden := len(v.differences) - SHOWN) > 0 and not everything:
                print(f"  ... and {hidden} more")
    differing = sum(v.word in ("differs", "only in before") for v in verdicts)
    print(f"\n{differing} of {len(verdicts)} runs differ")
    return int(differing > 0)


def _results(recording: Path) -> dict[str, Path]:
    """The folders of the finished runs, by name."""
    if not (recording / RECORDING).exists():
        sys.exit(f"{recording} is no recording")
    folders = sorted(f.parent for f in (recording / RUNS).glob(f"*/{RESULT}"))
    return dict(sorted((str(_result(folder)["name"]), folder) for folder in folders))


def _result(folder: Path) -> dict[str, Any]:
    result: dict[str, Any] = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    return result


def _verdict(name: str, before: Path | None, after: Path | None) -> Verdict:
    if before is None or after is None:
        return Verdict(name, "only in after" if before is None else "only in before", [])
    differences = list(_differences(before, after))
    if all(d.spacing for d in differences):
        return Verdict(name, "same, spacing" if differences else "same", differences)
    return Verdict(name, "differs", differences)


def _differences(before: Path, after: Path) -> Iterator[Difference]:
    """Every difference of two results of a run."""
    a, b = _result(before), _result(after)
    if a["command"] != b["command"]:
        yield Difference("command", a["command"], b["command"])
    if a["status"] != b["status"]:
        yield Difference("exit status", str(a["status"]), str(b["status"]))
    yield from printed_differences("stdout", a["stdout"], b["stdout"])
    yield from printed_differences(
        "stderr", without_progress(a["stderr"]), without_progress(b["stderr"])
    )
    for name in sorted(set(a["drawn"]) ^ set(b["drawn"])):
        yield one_sided(name, before=name in a["drawn"])
    files = [_files(folder / "root") for folder in (before, after)]
    for name in sorted(files[0].keys() | files[1].keys()):
        x, y = (side.get(name) for side in files)
        if x is None or y is None:
            yield one_sided(name, before=x is not None)
        else:
            yield from file_differences(name, x.read_bytes(), y.read_bytes())


def _files(root: Path) -> dict[str, Path]:
    return {str(p.relative_to(root)): p for p in sorted(root.rglob("*")) if p.is_file()}


def _print_differences(differences: Sequence[Difference]) -> None:
    for d in differences:
        deviation = "" if math.isnan(d.relative) else f"  ({d.relative:.1e})"
        if len(d.before) + len(d.after) < SHOWN * 4:
            print(f"  {d.field}: {d.before} -> {d.after}{deviation}")
        else:
            print(f"  {d.field}:{deviation}\n    before  {d.before}\n    after   {d.after}")


if __name__ == "__main__":
    main()
