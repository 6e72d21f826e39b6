"""The six steps of a session, in order, and what keeps a later one locked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .home import SessionJob
    from .session_request import Request

STEPS = ("logs", "look", "axis", "fit", "verdict", "out")


@dataclass(frozen=True)
class SessionStep:
    """A step as it stands.

    Args:
        name: One of STEPS.
        lock: Key of the reason for which it is locked, in the catalogue of words; empty if open.
        detail: What the reason is about, in the words of who refused it.
    """

    name: str
    lock: str = ""
    detail: str = ""


def steps(request: Request, jobs: Sequence[SessionJob], unread: str) -> list[SessionStep]:
    """The steps of a session.

    Args:
        request: Its choices.
        jobs: Its jobs.
        unread: Why a log of it cannot be read; empty where all can.
    """
    lock, detail = "", ""
    result = [SessionStep("logs")]
    if not request.choices.logs:
        lock = "lock.no_log"
    elif unread:
        lock, detail = "lock.unread", unread
    result += [SessionStep("look", lock, detail), SessionStep("axis", lock, detail)]
    if not lock:
        lock, detail = _axis(request)
    result.append(SessionStep("fit", lock, detail))
    if any(job.kind == "identify" and job.state == "done" for job in jobs):
        lock, detail = "", ""  # a fit stays, whatever is chosen after it
    else:
        lock = lock or "lock.no_fit"
    return [*result, SessionStep("verdict", lock, detail), SessionStep("out", lock, detail)]


def _axis(request: Request) -> tuple[str, str]:
    if not request.choices.rig:
        return "lock.no_rig", ""
    try:
        request.rig  # noqa: B018 - it refuses
        request.drive_chain  # noqa: B018 - so does it
        request.search()
    except InputError as error:
        return "lock.axis", str(error)
    return "", ""
