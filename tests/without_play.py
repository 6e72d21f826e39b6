"""Fits that look for no play: `test_hidden_play` has its tests, and it takes most of their time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from stribeck.identify.conditions import Violation


def _no_play(*_: object, rough: bool) -> tuple[list[Violation], int]:
    del rough
    return [], 0


@contextmanager
def without_play() -> Iterator[None]:
    """Fits within tell nothing of a play, which would only lower verdicts and add a sentence."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stribeck.identify.output_error_fit.hidden_play", _no_play)
        yield
