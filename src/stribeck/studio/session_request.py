"""What a session asks for, in its three forms: a call, the command line that does the same, Python.

All three are made of the same choices. The name of a log in the latter two is that of its file,
without a folder: they are to be used where the logs are.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..constant import Stated, toleranced
from ..data import Recording
from ..data.readers.log_map import WORDS
from ..drive import DriveChain
from ..errors import InputError
from ..rig import RIGS, Rig
from ..rig.log_reading import read_for
from ..text_file import toml_text
from ..units import interval, number
from .choices import AXIS, Choices

if TYPE_CHECKING:
    from ..data.alignment import Delay

#: The map of columns and drive that a command line names, beside the logs.
MAP = "columns.toml"


@dataclass(frozen=True)
class Request:
    """The choices of a session with the files that they are about.

    Args:
        choices: The choices.
        files: Path of each log by its id.
    """

    choices: Choices
    files: Mapping[str, Path]

    @cached_property
    def rig(self) -> Rig:
        """The rig with the constants that are stated.

        Raises:
            InputError: none is chosen, there is none of that name, or a constant is none.
        """
        rig = self.kind
        return (rig.exact() if self.choices.exact else rig).set(**self.constants)

    @cached_property
    def kind(self) -> Rig:
        """The rig as it is shipped, or as the session describes it.

        Raises:
            InputError: none is chosen, there is none of that name, or the description is of none.
        """
        name = self.choices.rig
        if not name:
            raise InputError("no rig is chosen")
        if name == AXIS:
            from ..rig.custom import rig_of_table  # noqa: PLC0415 - its checker takes time to load

            return rig_of_table(dict(self.choices.axis), Path(AXIS))
        if name not in RIGS:  # a file of the studio's machine is none
            raise InputError(f"no rig {name!r}: there are {', '.join(RIGS)}")
        return RIGS[name]

    @cached_property
    def constants(self) -> dict[str, Stated]:
        """The constants that are this axis's, as `identify` takes them."""
        return {n: toleranced(text, n) for n, text in self.choices.constants.items()}

    @property
    def law(self) -> str:
        """Name of the law."""
        name = self.choices.law or self.rig.laws[0]
        turned = self.choices.directional and not name.endswith("-directional")
        return f"{name}-directional" if turned else name

    @cached_property
    def drive_chain(self) -> DriveChain | None:
        """The chain from what the drive recorded to the force; None where none is stated.

        Raises:
            InputError: what is stated is no chain, or not yet a whole one.
        """
        return DriveChain.of_table(dict(self.choices.drive)) if self.choices.drive else None

    @cached_property
    def drive(self) -> DriveChain | None:
        """The same; None as long as it is not whole: logs are looked at without."""
        try:
            return self.drive_chain
        except InputError:
            return None

    @property
    def map(self) -> dict[str, Any] | None:
        """How the logs are read where their heads do not say it, as `read` takes it."""
        drive = {"drive": dict(self.choices.drive)} if self.drive else {}
        if not self.choices.columns and not drive:
            return None
        return {"columns": dict(self.choices.columns), **drive}

    @property
    def words(self) -> dict[str, Any]:
        """What else `read` takes; what is not stated is left out."""
        return {w: value for w in WORDS if (value := getattr(self.choices, w))}

    def path(self, log: int) -> str:
        """Where a log is, with its window."""
        choice = self.choices.logs[log]
        return _windowed(str(self.files[choice.id]), choice.window)

    @property
    def reading(self) -> str:
        """All that says how logs are read, as one text: what was read otherwise is another."""
        c = self.choices
        own = (c.axis, c.constants, c.exact) if c.rig == AXIS else ()
        return repr((self.map, self.words, c.rig if self.map is None else "", own))

    @property
    def reading_rig(self) -> Rig | None:
        """The rig that says how logs are read; None as long as none is described rightly.

        Its own step says what is wrong with it, and a log can be looked at without.
        """
        try:
            return self.rig if self.choices.rig else None
        except InputError:
            return None

    def recording(self, log: int) -> Recording:
        """A log of the session, read as is chosen.

        Raises:
            InputError: as `read`.
        """
        return read_for(self.reading_rig, self.path(log), self.map, **self.words)

    def recordings(self) -> list[Recording]:
        """All logs of the session.

        Raises:
            InputError: as `read`, or there is none.
        """
        if not self.choices.logs:
            raise InputError("no log is chosen")
        _ = self.drive_chain  # says what it lacks
        return [self.recording(k) for k in range(len(self.choices.logs))]

    def search(self) -> dict[str, Any]:
        """Arguments of `identify` that say what is identified and how; defaults are left out."""
        c = self.choices
        stated: dict[str, Any] = {
            "train": list(c.train),
            "holdout": list(c.holdout),
            "fixed": {n: number(text, n) for n, text in c.fixed.items()},
            "bounds": {n: interval(text, n) for n, text in c.bounds.items()},
            "method": c.method,
            "repeats": c.repeats,
            "budget": c.budget,
        }
        plain = {n: value for n, value in stated.items() if value}
        if c.seed is not None:
            plain["seed"] = c.seed
        if c.loss != "squares":
            plain["loss"] = c.loss
        if c.breakaway != "auto":
            plain["breakaway"] = c.breakaway
        if c.velocity != "auto":
            plain["velocity"] = c.velocity
        if c.delay != "auto":
            plain["delay"] = _delay(c.delay)
        return plain

    @property
    def identification(self) -> dict[str, Any]:
        """All arguments of `identify` but the logs."""
        return {"rig": self.rig, "law": self.law, **self.search()}

    def comparison(self) -> dict[str, Any]:
        """Arguments of `select` that say what is compared and how; defaults are left out."""
        shared = (
            "train",
            "holdout",
            "fixed",
            "bounds",
            "seed",
            "budget",
            "loss",
            "velocity",
            "delay",
        )
        plain = {n: v for n, v in self.search().items() if n in shared}
        own = {"laws": list(self.choices.laws), "folds": self.choices.folds}
        return {**plain, **{n: v for n, v in own.items() if v}}

    def command(self, kind: str = "identify", out: str = "result") -> list[str]:
        """The command line, word by word, with `columns.toml` where a drive is stated.

        Args:
            kind: `identify` or `select`.
            out: The folder that it writes.
        """
        c = self.choices
        logs = [_windowed(self.files[log.id].name, log.window) for log in c.logs]
        words = ["stribeck", kind, *logs]
        if self.drive:
            words += ["--columns", MAP]
        else:
            words += _each("--column", c.columns)
        for w, value in self.words.items():
            words += [f"--{w.replace('_', '-')}", f"{value:g}" if w == "rate" else value]
        words += ["--rig", c.rig]
        if kind == "select":
            words += ["--laws", ",".join(c.laws)] * bool(c.laws)
            words += ["--folds", str(c.folds)] * (c.folds is not None)
        else:
            words += ["--law", c.law] * bool(c.law) + ["--directional"] * c.directional
            words += ["--method", c.method] * bool(c.method)
        for r in c.train:
            words += ["--train", r]
        for r in c.holdout:
            words += ["--holdout", r]
        words += _each("--set", {**c.constants, **c.fixed}) + ["--exact"] * c.exact
        words += _each("--bounds", c.bounds)
        words += ["--seed", str(c.seed)] * (c.seed is not None)
        words += ["--budget", str(c.budget)] * (c.budget is not None)
        if kind == "identify":
            words += ["--repeats", str(c.repeats)] * (c.repeats is not None)
            words += ["--breakaway", c.breakaway] * (c.breakaway != "auto")
        words += ["--loss", c.loss] * (c.loss != "squares")
        words += ["--velocity", c.velocity] * (c.velocity != "auto")
        words += [f"--delay={c.delay}"] * (c.delay != "auto")
        return [*words, "--out", out]

    def command_text(self, kind: str = "identify") -> str:
        """The same as a line for a shell."""
        return shlex.join(self.command(kind))

    def python(self) -> str:
        """The same in Python."""
        c = self.choices
        names = [_windowed(self.files[log.id].name, log.window) for log in c.logs]
        usual = self.rig.columns if c.rig else {}
        arguments: dict[str, Any] = {"rig": c.rig}
        if c.law or c.directional:
            arguments["law"] = self.law
        arguments |= {"constants": self.constants} if self.constants else {}
        arguments |= {"exact": True} if c.exact else {}
        arguments |= self.search()
        tail = "".join(f", {n}={v!r}" for n, v in arguments.items())
        if self.map is None and not self.words:
            logs = repr(names[0] if len(names) == 1 else names)
            lines = ["import stribeck", "", f"fit = stribeck.identify({logs}{tail})"]
        else:
            how: dict[str, Any] = {}
            if self.map is not None:
                how["columns"] = self.map
            elif usual:
                how |= {"columns": dict(usual), "lenient": True}
            reading = "".join(f", {n}={v!r}" for n, v in {**how, **self.words}.items())
            lines = [
                "import stribeck",
                "",
                f"logs = [stribeck.read(name{reading}) for name in {names!r}]",
                f"fit = stribeck.identify(logs{tail})",
            ]
        return "\n".join([*lines, "print(fit.table())", 'fit.report("report.html")', ""])

    def texts(self) -> dict[str, str]:
        """The files that the command line names beside the logs: name -> text."""
        files = {MAP: toml_text(self.map)} if self.drive and self.map else {}
        if self.choices.rig == AXIS:
            files[AXIS] = toml_text(self.choices.axis)
        return files


def _windowed(path: str, window: str) -> str:
    return f"{path}@{window}" if window else path


def _each(option: str, values: Mapping[str, str]) -> list[str]:
    return [word for n, text in values.items() for word in (option, f"{n}={text}")]


def _delay(text: str) -> Delay:
    if text == "off":
        return "off"
    value, tolerance, _ = toleranced(text, "delay", "auto, off, a number of ms, nor MS±TOLERANCE")
    return 1e-3 * value, 1e-3 * tolerance
