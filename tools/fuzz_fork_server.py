"""The program of `fuzz_forks`: loads a library once, and forks for each file that is read.

    python -P fuzz_fork_server.py FOLDER MODULE DESCRIPTOR

FOLDER has `library_process`; requests come, and statuses go, over the socket DESCRIPTOR.
"""

from __future__ import annotations

import json
import os
import resource
import socket
import struct
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType

#: Bytes of a request at most.
_LONGEST = 1 << 16


def main() -> None:
    """Fork for each request until the other end closes."""
    folder, module, descriptor = sys.argv[1:]
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    sys.path.append(folder)
    program = import_module("library_process")
    sys.path.remove(folder)
    reader = program.loaded(module)
    connection = socket.socket(fileno=int(descriptor))
    while True:
        request, descriptors, *_ = socket.recv_fds(connection, _LONGEST, 3)
        if not request:
            return
        pid = os.fork()
        if not pid:
            _read(program, reader, json.loads(request), descriptors)
        for each in descriptors:
            os.close(each)
        connection.send(struct.pack("q", pid))
        if not connection.recv(4):
            return
        _, status, usage = os.wait4(pid, 0)
        code = os.waitstatus_to_exitcode(status)
        connection.send(struct.pack("2q", code, usage.ru_maxrss << 10))


def _read(
    program: ModuleType, reader: ModuleType, arguments: Sequence[str], descriptors: Sequence[int]
) -> None:
    """Read one file and end, in a process of its own."""
    path, memory, seconds = arguments
    for number, descriptor in enumerate(descriptors):
        os.dup2(descriptor, number)
        os.close(descriptor)
    code = 1
    try:
        with os.fdopen(0, "rb") as stdin, os.fdopen(1, "wb") as output:
            request = json.load(stdin)
            program.answer(reader, Path(path), request, (int(memory), int(seconds)), output)
        code = 0
    except BaseException:  # noqa: BLE001 - as Python ends: its words, and status 1
        with suppress(Exception):
            sys.excepthook(*sys.exc_info())
    finally:
        os._exit(code)


if __name__ == "__main__":
    main()
