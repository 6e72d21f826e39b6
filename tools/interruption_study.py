"""Commands killed and interrupted at random moments, and what their folders hold afterwards.

    python tools/interruption_study.py FOLDER [--seconds 500] [--seed 0]

Each command runs in a fork of this program, where all is loaded, and writes over an older result.
After its end its folder must hold the older result, file by file, or the new one, every file of
which opens; of a fit and a comparison also a part of the new one, with its card or its table and
nothing of the older. Once the next command has begun nothing hidden is left there. `bench` goes on
with its store instead, and in the end has the records of a run that nobody stopped.
Counts are added to FOLDER/counts.json until the time is up, and printed as a table.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import numpy as np
from PIL import Image

import stribeck
from stribeck import LAWS, RIGS, cli, read_card
from stribeck.draft import PREFIX
from stribeck.report.contents.schema import read_report
from stribeck.report.folder import held
from stribeck.rig.forced import FORCED

FIT = ("--rig", "forced", "--law", "coulomb-viscous")
BED = ("--rig", "slide-bed", "--exact", "--law", "stribeck", "--train", "112:295")
QUICK = ("--repeats", "1", "--budget", "400")
LADDER = ("--rig", "forced", "--laws", "coulomb-viscous,coulomb-viscous-directional,stribeck",
          "--set", "v_SS=10")  # fmt: skip
CAMPAIGN = """
name = "small"
doc = "Two methods, twelve runs."
seed = 7
repeats = 6
budget = 400
[[problem]]
surface = "RF"
[[method]]
name = "random"
method = "random"
[[method]]
name = "mbts"
method = "mbts"
"""
#: What a fit and a comparison write before what can be made from it.
FIRST = {"card.json", "selection.json"}
SIGNALS = {"kill -9": signal.SIGKILL, "Ctrl-C": signal.SIGINT, "SIGTERM": signal.SIGTERM}
#: How a command that a signal ended may end, beside as if there had been none.
ENDED = {
    "kill -9": {-9},
    "Ctrl-C": {130, -2},  # before Python itself has started, -2 and -15
    "SIGTERM": {143, -15},
}


@dataclass(frozen=True)
class Command:
    """A command that is stopped, and the one whose result it finds in its folder.

    Args:
        name: What the counts call it.
        words: Its words; it writes to `out`, if at all.
        older: The words of the command whose result lies there.
        folder: Whether it writes a folder.
    """

    name: str
    words: tuple[str, ...]
    older: tuple[str, ...] = ()
    folder: bool = True


COMMANDS = (
    Command("identify, force balance", ("identify", "b.csv", *FIT, "--out", "out"),
            ("identify", "a.csv", *FIT, "--out", "out")),
    Command("identify, slide bed", ("identify", "bed.csv", *BED, *QUICK, "--out", "out"),
            ("identify", "a.csv", *FIT, "--out", "out")),
    Command("select", ("select", "b.csv", *LADDER, "--test", "a.csv", "--out", "out"),
            ("select", "a.csv", *LADDER, "--test", "b.csv", "--out", "out")),
    Command("plan", ("plan", "bed/card.json", "bed.csv", "--seconds", "20", "--check", "2"),
            folder=False),
    Command("compensate", ("compensate", "bed/card.json", "--speed", "20", "--mode", "reference",
                           "--scale", "0.5", "--out", "out"),
            ("compensate", "bed/card.json", "--speed", "20", "--mode", "reference",
             "--scale", "0.4", "--out", "out")),
    Command("export, C", ("export", "bed/card.json", "--to", "c", "--out", "out"),
            ("export", "fit/card.json", "--to", "c", "--out", "out")),
    Command("export, FMU", ("export", "bed/card.json", "--to", "fmu", "--out", "out/axis.fmu"),
            ("export", "fit/card.json", "--to", "fmu", "--out", "out/axis.fmu")),
    Command("bench, here", ("bench", "small.toml", "--engine", "here", "--out", "out")),
    Command("bench, processes", ("bench", "small.toml", "--engine", "processes:2", "--out", "out")),
)  # fmt: skip


class Study:
    """A folder with what the commands need, and the counts so far.

    Args:
        folder: The folder.
        seed: Of the moments.
    """

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.random = folder, random.Random(seed)  # noqa: S311 - moments, no secrets
        self.counts = Counter[str]()
        self.file, self._times = folder / "counts.json", folder / "seconds.json"
        self.seconds: dict[str, float] = {}
        if self.file.exists():
            self.counts.update(json.loads(self.file.read_text(encoding="utf-8")))
        if self._times.exists():
            self.seconds = json.loads(self._times.read_text(encoding="utf-8"))
        self.temporary = folder / "tmp"
        self.temporary.mkdir(parents=True, exist_ok=True)

    def prepare(self) -> None:
        """Logs, cards, and the result and the time of every command that nobody stops."""
        if not (self.folder / "bed" / "card.json").exists():
            for seed, name in enumerate(("a", "b")):
                _log(self.folder / f"{name}.csv", seed)
            (self.folder / "small.toml").write_text(CAMPAIGN, encoding="utf-8")
            self.run("twin", "bed.csv", "--direction", "up")
            self.run("identify", "a.csv", *FIT, "--out", "fit")
            self.run("identify", "bed.csv", *BED, *QUICK, "--out", "bed")

    def references(self, command: Command) -> tuple[Path, Path]:
        """The older result and the new one, kept; how long the new one takes is measured."""
        older, new = (self.folder / f"{command.name}, {which}" for which in ("older", "new"))
        if command.name in self.seconds:
            return older, new
        for words, place in ((command.older, older), (command.words, new)):
            shutil.rmtree(self.folder / "out", ignore_errors=True)
            (self.folder / "out").mkdir()
            start = time.monotonic()
            if words:
                self.run(*words)
            self.seconds[command.name] = time.monotonic() - start
            shutil.rmtree(place, ignore_errors=True)
            (self.folder / "out").rename(place)
        self._times.write_text(json.dumps(self.seconds), encoding="utf-8")
        return older, new

    def run(self, *words: str) -> None:
        """Run a command to its end.

        Raises:
            RuntimeError: it does not end well.
        """
        if Forked(self.folder, self.temporary, words).status() not in (0, 1):
            raise RuntimeError((self.folder / "stderr").read_text(encoding="utf-8"))

    def stop(self, command: Command, end: str) -> str:
        """Stop a command at a random moment; what it has left is returned, in words."""
        older, new = self.references(command)
        out = self.folder / "out"
        if not command.name.startswith("bench"):
            shutil.rmtree(out, ignore_errors=True)
            shutil.copytree(older, out)
        process = Forked(self.folder, self.temporary, command.words)
        moment = self.random.uniform(0.0, 1.02) * self.seconds[command.name]
        status = process.status(moment, SIGNALS[end])
        errors = (self.folder / "stderr").read_text(encoding="utf-8", errors="replace")
        if status not in {0, *ENDED[end], *({1} if command.name == "compensate" else ())}:
            return f"WRONG: status {status} {errors[-200:]}"
        if "Traceback" in errors and status != -signal.SIGINT:
            return f"WRONG: a traceback {errors[-200:]}"
        for place in (out, self.temporary):
            with held(place):  # as every command begins
                pass
            if left := [p.name for p in place.iterdir() if p.name.startswith(PREFIX)]:
                return f"WRONG: {left} left"
        if command.name.startswith("bench"):
            return self.resumed(command, new, status)
        return _state(out, older, new) if command.folder else "nothing to write"

    def resumed(self, command: Command, new: Path, status: int) -> str:
        """Whether a campaign that is gone on with ends as one that nobody stopped."""
        out = self.folder / "out"
        if status != 0 and self.random.random() < 0.5:  # noqa: PLR2004 - stopped once more
            return "stopped again"
        self.run(*command.words)
        same = _records(out) == _records(new)
        _open(out)
        shutil.rmtree(out)
        return "the same records" if same else "WRONG: other records"


class Forked:
    """A command in a fork of this process, in which everything is loaded.

    Args:
        folder: Where it runs, and where its output goes.
        temporary: Its folder for temporary files.
        words: Its words.
    """

    def __init__(self, folder: Path, temporary: Path, words: Sequence[str]) -> None:
        self.process = os.fork()
        if self.process:
            return
        status = 70
        try:
            os.chdir(folder)
            os.environ["TMPDIR"] = tempfile.tempdir = str(temporary)
            for number, name in ((1, "stdout"), (2, "stderr")):
                os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
            sys.argv = ["stribeck", *words]
            cli.main()
            status = 0
        except SystemExit as end:
            status = int(end.code or 0)
        finally:
            sys.stdout.flush()
            os._exit(status)

    def status(self, moment: float = math.inf, end: int = 0) -> int:
        """The exit status, negative after a signal; at a moment a signal is sent."""
        start = time.monotonic()
        while True:
            process, status = os.waitpid(self.process, os.WNOHANG)
            if process:
                return os.waitstatus_to_exitcode(status)
            if time.monotonic() - start >= moment:
                os.kill(self.process, end)
                moment = math.inf
            time.sleep(0.002)


def _records(folder: Path) -> list[dict[str, str]]:
    """The runs of a campaign, without the time they took."""
    with (folder / "records.csv").open(encoding="utf-8") as file:
        return [{n: v for n, v in row.items() if n != "seconds"} for row in csv.DictReader(file)]


def load() -> None:
    """Import everything that commands import, and load what is compiled."""
    for module in walk_packages(stribeck.__path__, "stribeck."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    for name in ("matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg"):
        import_module(name)
    list(LAWS.values()), list(RIGS.values())


def _log(file: Path, seed: int) -> None:
    """A slow motion of three tones whose force was measured with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(2000) / 200.0
    x, v, a = np.zeros((3, len(t)))
    for size, f, phase in zip((0.05, 0.02), (0.25, 0.7), rng.uniform(0, 6, 2), strict=True):
        w = 2 * np.pi * f
        x += size * np.sin(w * t + phase)
        v += size * w * np.cos(w * t + phase)
        a -= size * w**2 * np.sin(w * t + phase)
    p = np.array([20.0, 100.0, 50.0, -3.0])
    force = FORCED.force(LAWS["coulomb-viscous"], p, v, a) + 2.0 * rng.standard_normal(len(t))
    table = np.column_stack([t, x, force])
    np.savetxt(file, table, "%.9g", ",", header="t [s],position [m],force [N]", comments="")


def _state(out: Path, older: Path, new: Path) -> str:
    """What a folder holds: the older result, the new one, a part of it, or a mixture."""
    there, before, after = (_contents(f) for f in (out, older, new))
    if there == before:
        return "the older"
    _open(out)
    kept = [n for n, data in there.items() if data == before.get(n) != after.get(n)]
    if kept:
        return f"WRONG: of the older {kept}, of the new {sorted(set(there) - set(kept))}"
    if not set(there) <= set(after):
        return f"WRONG: {sorted(set(there) - set(after))}"
    if set(there) == set(after):
        return "the new"
    return "a part of the new" if FIRST & set(there) else f"WRONG: {sorted(there)} alone"


def _contents(folder: Path) -> dict[str, bytes]:
    files = (f for f in folder.rglob("*") if f.is_file())
    return {str(f.relative_to(folder)): f.read_bytes() for f in files}


def _open(folder: Path) -> None:
    """Open every file of a result."""
    for file in folder.rglob("*"):
        if file.suffix == ".json":
            json.loads(file.read_text(encoding="utf-8"))
        elif file.suffix == ".png":
            with Image.open(file) as image:
                image.verify()
        elif file.suffix == ".svg":
            ET.parse(file)  # noqa: S314 - our own file
        elif file.suffix == ".html" and not file.read_text(encoding="utf-8").rstrip().endswith(
            "</html>"
        ):
            raise ValueError(f"{file} is cut")
    if (folder / "card.json").exists():
        read_card(folder / "card.json")
    if (folder / "report.json").exists():
        read_report(folder)


def table(counts: Counter[str]) -> str:
    """The counts as a Markdown table: how often each command was stopped, and what it left."""
    rows = [(name.split(" | "), n) for name, n in counts.items()]
    words = [*SIGNALS, *sorted({state for (_, _, state), _ in rows})]
    lines = [f"| {' | '.join(['command', *words])} |", "|---" * (1 + len(words)) + "|"]
    for command in COMMANDS:
        own = [(names, n) for names, n in rows if names[0] == command.name]
        totals = [sum(n for names, n in own if word in names) for word in words]
        lines.append(f"| {' | '.join([command.name, *(str(n or '') for n in totals)])} |")
    return "\n".join([*lines, f"\n{counts.total()} in all"])


def main() -> None:
    """Stop commands until the time is up, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=500.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    until = time.monotonic() + options.seconds
    load()
    study = Study(options.folder.absolute(), options.seed)
    study.prepare()
    commands = [c for c in COMMANDS if options.only in c.name]
    while time.monotonic() < until:
        # The cheap ones more often: so many moments as there is time for.
        weights = [study.seconds.get(c.name, 10.0) ** -0.5 for c in commands]
        (command,) = study.random.choices(commands, weights)
        end = study.random.choice(list(SIGNALS))
        left = study.stop(command, end)
        if left.startswith("WRONG"):
            print(f"{command.name}, {end}: {left}", flush=True)
            left = "WRONG"
        study.counts[f"{command.name} | {end} | {left}"] += 1
        study.file.write_text(json.dumps(study.counts, indent=1), encoding="utf-8")
    print(table(study.counts))


if __name__ == "__main__":
    main()
