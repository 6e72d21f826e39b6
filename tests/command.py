"""The command line as a test calls it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

import pytest

from stribeck import cli


class Said(NamedTuple):
    status: int
    out: str
    err: str


def caller(patch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Runs a command in this process: its exit status, and what it said."""

    def run(*arguments: str) -> Said:
        patch.setattr(sys, "argv", ["stribeck", *arguments])
        status = 0
        try:
            cli.main()
        except SystemExit as ended:
            status = int(ended.code or 0)
        return Said(status, *capsys.readouterr())

    return run
