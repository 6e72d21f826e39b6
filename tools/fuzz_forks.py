"""Processes that read by somebody else's library, forked from one that has the library loaded.

`isolated` starts a process for each file, which takes a second to import its library. For a
million files `forked` stands in: a program for each library imports it once, and a copy of it reads
one file, with the same limits and pipes.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any, Self, cast

from stribeck.data.readers import isolated

_PROGRAM = Path(__file__).with_name("fuzz_fork_server.py")


class ForkedProcess:
    """What `isolated` uses of a `Popen`.

    Args:
        server: The program that forks, as it is connected.
        arguments: Path, bytes of memory and seconds.
        errors: Where its standard error goes.
    """

    def __init__(self, server: ForkServer, arguments: Sequence[str], errors: IO[bytes]) -> None:
        to_read, to_write = os.pipe()
        answers, answering = os.pipe()
        descriptors = [to_read, answering, errors.fileno()]
        socket.send_fds(server.connection, [json.dumps(arguments).encode()], descriptors)
        os.close(to_read)
        os.close(answering)
        self.stdin, self.stdout = os.fdopen(to_write, "wb"), os.fdopen(answers, "rb")
        self._server = server
        (self._pid,) = struct.unpack("q", server.connection.recv(8))
        self._status: int | None = None

    def kill(self) -> None:
        """End it, unless it has been waited for."""
        if self._status is None:
            os.kill(self._pid, signal.SIGKILL)

    def wait(self) -> int:
        """Its status, once it has ended."""
        if self._status is None:
            self._server.connection.send(b"wait")
            self._status, peak = struct.unpack("2q", self._server.connection.recv(16))
            self._server.peak = max(self._server.peak, peak)
        return self._status


class ForkServer:
    """A program that has a library loaded, and forks.

    Args:
        module: The format's module in `data/readers`.
    """

    def __init__(self, module: str) -> None:
        self.connection, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.peak = 0
        environment = {**os.environ, **isolated.ENVIRONMENT,
                       "PYTHONPATH": os.pathsep.join(sys.path)}  # fmt: skip
        with other:
            self.process = subprocess.Popen(  # noqa: S603 - a program beside this
                [sys.executable, "-P", str(_PROGRAM), str(isolated.PROGRAM.parent), module,
                 str(other.fileno())],
                pass_fds=[other.fileno()], env=environment,
            )  # fmt: skip


class ForkedProcesses:
    """In place of `isolated.process` from a `with` on, with a program for each library."""

    def __init__(self) -> None:
        self.servers: dict[str, ForkServer] = {}

    def __call__(self, arguments: Sequence[str], errors: IO[bytes]) -> ForkedProcess:
        """A process that reads a file."""
        module, *others = arguments
        if module not in self.servers:
            self.servers[module] = ForkServer(module)
        return ForkedProcess(self.servers[module], others, errors)

    @property
    def peak(self) -> int:
        """The most memory that one of them took, MiB."""
        return max((server.peak for server in self.servers.values()), default=0) >> 20

    def __enter__(self) -> Self:
        """Let `isolated` fork from now on."""
        self._own = isolated.process
        isolated.process = cast("Any", self)
        return self

    def __exit__(self, *_: object) -> None:
        """End the programs, and start processes again."""
        isolated.process = self._own
        for server in self.servers.values():
            server.connection.close()
            server.process.wait()
