"""The command line as a test calls it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

import pytest

from stribeck import cli


class Completed(NamedTuple):
    """A command that has ended: its exit status and what it printed."""

    status: int
    out: str
    err: str


def caller(
    patch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    """A function that runs a command in this process."""

    def run(*arguments: str) -> Completed:
        patch.setattr(sys, "argv", ["stribeck", *arguments])
        status = 0
        try:
            cli.main()
        except SystemExit as end:
            status = int(end.code or 0)
        return Completed(status, *capsys.readouterr())

    return run
