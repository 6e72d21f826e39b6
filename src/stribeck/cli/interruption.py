"""SIGTERM as Ctrl-C: what is finished is kept, whoever asks for the end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

#: Added to a signal's number for the exit status of what it ended.
_SIGNALLED = 128


class Interruption:
    """The signal that ended a command; Ctrl-C unless another came."""

    def __init__(self) -> None:
        self._number: int = signal.SIGINT

    @property
    def status(self) -> int:
        """The exit status: 130 after Ctrl-C, 143 after SIGTERM."""
        return _SIGNALLED + self._number

    @contextmanager
    def terminations(self) -> Iterator[None]:
        """SIGTERM raises KeyboardInterrupt meanwhile, unless the process ignores or handles it."""
        self._number = signal.SIGINT
        ours = threading.current_thread() is threading.main_thread()
        if not ours or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
            yield
            return
        signal.signal(signal.SIGTERM, self._terminate)
        try:
            yield
        finally:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def _terminate(self, number: int, _: Any) -> None:
        self._number = number
        raise KeyboardInterrupt


interruption = Interruption()
