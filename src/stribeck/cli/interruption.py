"""SIGTERM as Ctrl-C: what is finished is kept, whoever asks for the end."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

#: Added to a signal's number for the exit status of what it ended.
_SIGNALLED = 128
#: Seconds that an import is waited for at most (some of ours compile), and between two looks.
LONGEST_IMPORT, LOOK = 3.0, 0.02


class Interruption:
    """The signal that ended a command; Ctrl-C unless another came."""

    def __init__(self) -> None:
        self._number: int = signal.SIGINT
        self._since: float | None = None

    @property
    def status(self) -> int:
        """The exit status: 130 after Ctrl-C, 143 after SIGTERM."""
        return _SIGNALLED + self._number

    @contextmanager
    def handled(self) -> Iterator[None]:
        """SIGTERM and Ctrl-C raise KeyboardInterrupt meanwhile, but not amid an import.

        A signal that the process ignores or handles itself is left alone.
        """
        self._number, self._since = signal.SIGINT, None
        usual: dict[int, Any] = {
            signal.SIGINT: signal.default_int_handler,
            signal.SIGTERM: signal.SIG_DFL,
        }
        ours = []
        if threading.current_thread() is threading.main_thread():
            ours = [n for n, handler in usual.items() if signal.getsignal(n) is handler]
        for number in ours:
            signal.signal(number, self._interrupt)
        try:
            yield
        finally:
            for number in ours:
                signal.signal(number, usual[number])

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        """End what is done now; where a module is being imported, once that is done.

        A module whose import was cut short cannot be imported again, and what is finished may need
        it to be shown.
        """
        self._number = number
        self._since = self._since or time.monotonic()
        if _importing(frame) and time.monotonic() - self._since < LONGEST_IMPORT:
            again = threading.Timer(LOOK, _send, (number,))
            again.daemon = True
            again.start()
            return
        self._since = None
        raise KeyboardInterrupt


def _send(number: int) -> None:
    """A signal to the main thread: raised in another one, it would not wake the main one up."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        signal.raise_signal(number)


def _importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == "<frozen importlib._bootstrap>":
            return True
        frame = frame.f_back
    return False


interruption = Interruption()
