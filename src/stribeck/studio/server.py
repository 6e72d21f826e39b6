"""The studio as a server on this machine."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import sys
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path

import uvicorn

from ..errors import InputError
from ..wording import on_command_line
from .choices import Choices
from .guard import START, Guard
from .home import Home
from .routes import Routes
from .saved_maps import recalled
from .workers import Workers

#: Names by which this machine calls itself.
_LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
#: Addresses that stand for all of a machine's.
_ANY = ("0.0.0.0", "::", "")  # noqa: S104 - they are refused
#: Seconds that open streams have to end when the studio ends.
_GRACE = 1


def serve(
    logs: Sequence[Path],
    *,
    home: Path,
    port: int = 0,
    host: str = "127.0.0.1",
    browser: bool = True,
    tell: Callable[[str], object] = print,
) -> None:
    """Serve the studio until it is interrupted.

    Args:
        logs: Logs of a new session, which are read where they are.
        home: The folder of its sessions.
        port: Where it listens; 0 takes a free one.
        host: The address that it listens on; others than loopback can be reached from elsewhere.
        browser: Whether the page is opened.
        tell: Called with the address of the page.

    Raises:
        InputError: the folder cannot be used, a log is not there, or the port is taken.
    """
    host = host.strip("[]")
    with Home(home) as kept, contextlib.closing(_listening(host, port)) as listener:
        place = _placed(kept, logs)
        port = listener.getsockname()[1]
        names = {*_LOOPBACK, f"[{host}]" if ":" in host else host}
        with Workers(home) as workers:
            guard = Guard(
                Routes(kept, workers).application(),
                [f"{name}:{port}" for name in names],
                kept.secret(),
                place,
            )
            named = f"[{host}]" if ":" in host else host
            address = f"http://{named}:{port}{START}?token={guard.token}"
            tell(address)
            sys.stdout.flush()
            if browser:
                webbrowser.open(address)
            config = uvicorn.Config(
                guard, log_config=None, access_log=False, server_header=False, ws="none",
                lifespan="off", timeout_graceful_shutdown=_GRACE,
            )  # fmt: skip
            # Messages are as the command would say them that the page shows; Ctrl-C ends it.
            with on_command_line(), contextlib.suppress(KeyboardInterrupt):
                uvicorn.Server(config).run(sockets=[listener])


def _placed(home: Home, logs: Sequence[Path]) -> str:
    """A session of logs where they are, as the path of its page; the list of sessions without."""
    if not logs:
        return "/"
    for log in logs:
        if not log.exists():
            raise InputError(f"{log.name}: no such file in {log.parent}")
    known = [home.keep_log(log.name, log.resolve()) for log in logs]
    mapped = recalled(home.folder, known[0].path, Choices())
    choices = Choices().changed({"logs": [{"id": log.id} for log in known], **mapped})
    return f"/s/{home.begin(known[0].name, choices).id}/logs"


def _listening(host: str, port: int) -> socket.socket:
    if host in _ANY:
        raise InputError(
            f"--host {host}: name the one address by which it is reached: requests by other names "
            "are refused"
        )
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen()  # the address is told before the server runs: who is quick waits
    except (OSError, OverflowError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or error
        if isinstance(error, socket.gaierror):
            raise InputError(f"--host {host}: {reason}: name an address of this machine") from error
        raise InputError(f"--port {port}: {reason}: take another, or 0 for a free one") from error
    return listener


def is_loopback(host: str) -> bool:
    """Whether an address is this machine's own, for itself."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host == "localhost"
