"""What the studio answers: the page's own files, and what its steps ask for, as JSON."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from dataclasses import asdict
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Any, cast, get_args

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect
from starlette.requests import Request as Asked
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from ..errors import InputError
from ..report.page.html_page import style_sheet
from ..text_file import json_document
from ..units import number
from . import rig_files, saved_maps, uploads
from .catalogue import catalogue, rig_document
from .choices import AXIS, Choices, Kind
from .exports import exported, targets
from .home import Home, Session, SessionJob
from .log_view import LogViews, log_contents, stamp, stated_constants
from .results import compared, fit_results, result_file
from .session_request import Request
from .steps import steps
from .workers import Workers

#: Letters of a document that is sent to the studio at most.
LARGEST = 1 << 18
#: Seconds between two looks whether a session has changed, for who watches it.
PACE = 0.25
#: Logs whose contents are remembered: more than are open at once.
KEPT = 200
#: Where the page's own files are, and what they are.
_KINDS = {".html": "text/html", ".js": "text/javascript", ".css": "text/css",
          ".svg": "image/svg+xml", ".json": "application/json"}  # fmt: skip
_LANGUAGES = ("en", "de", "zh")

Answer = Callable[[Asked], Awaitable[Response]]


class Routes:
    """The answers of a studio.

    Args:
        home: Its home.
        workers: Its workers.
    """

    def __init__(self, home: Home, workers: Workers) -> None:
        self._home, self._workers = home, workers
        self._views = LogViews()
        self._contents: dict[tuple[Any, ...], dict[str, Any] | InputError] = {}

    def application(self) -> Starlette:
        """All answers as an ASGI application."""
        session = "/api/sessions/{session}"
        log = f"{session}/logs/{{log:int}}"
        job = f"{session}/jobs/{{job:int}}"
        table: list[tuple[str, str, Answer]] = [
            ("GET", "/", self._page),
            ("GET", "/s/{session}/{step}", self._page),
            ("GET", "/page/{name:path}", self._asset),
            ("GET", "/words/{language}.json", self._words),
            ("GET", "/api/catalogue", self._catalogue),
            ("GET", "/api/sessions", self._sessions),
            ("POST", "/api/sessions", self._begin),
            ("GET", session, self._state),
            ("PATCH", session, self._change),
            ("POST", f"{session}/undo", partial(self._turn, -1)),
            ("POST", f"{session}/redo", partial(self._turn, 1)),
            ("POST", f"{session}/files", self._upload),
            ("POST", f"{session}/rig", self._rig_file),
            ("POST", f"{log}/map", self._keep_map),
            ("GET", f"{session}/events", self._events),
            ("GET", f"{log}/contents", self._log_contents),
            ("GET", f"{log}/outline", self._outline),
            ("GET", f"{log}/overview", self._overview),
            ("GET", f"{log}/lines", self._lines),
            ("GET", f"{log}/cloud", self._cloud),
            ("POST", f"{session}/jobs", self._ask),
            ("POST", f"{job}/cancel", self._cancel),
            ("GET", f"{job}/result", self._result),
            ("GET", f"{job}/files/{{name}}", self._file),
            ("GET", f"{session}/compare", self._compare),
            ("GET", f"{session}/script", self._script),
            ("GET", f"{job}/export", self._export),
        ]
        routes = [Route(path, _told(answer), methods=[verb]) for verb, path, answer in table]
        return Starlette(routes=routes)

    # The page.

    async def _page(self, asked: Asked) -> Response:
        del asked
        return _asset("index.html")

    async def _asset(self, asked: Asked) -> Response:
        return _asset(asked.path_params["name"])

    async def _words(self, asked: Asked) -> Response:
        language = asked.path_params["language"]
        if language not in _LANGUAGES:
            raise InputError("there are no words of that language")
        place = files("stribeck.studio") / "words" / f"{language}.json"
        return Response(place.read_bytes(), media_type="application/json")

    async def _catalogue(self, asked: Asked) -> Response:
        del asked
        table = await run_in_threadpool(catalogue)
        return JSONResponse(table | {"targets": targets()})

    # Sessions.

    async def _sessions(self, asked: Asked) -> Response:
        del asked
        rows = self._home.sessions()
        return JSONResponse(
            [{"id": i, "name": name, "created": created} for i, name, created in rows]
        )

    async def _begin(self, asked: Asked) -> Response:
        name = str((await _document(asked)).get("name") or "")[:100]
        return JSONResponse({"id": self._home.begin(name, Choices()).id})

    async def _state(self, asked: Asked) -> Response:
        return await self._answer(self._home.session(asked.path_params["session"]))

    async def _change(self, asked: Asked) -> Response:
        document = await _document(asked)
        changes, step = document.get("choices"), document.get("step")
        if not isinstance(changes, dict) or not isinstance(step, int | None):
            raise InputError("choices: send an object, and the step that it was made from")
        return await self._answer(self._home.change(asked.path_params["session"], changes, step))

    async def _turn(self, steps: int, asked: Asked) -> Response:
        return await self._answer(self._home.turn(asked.path_params["session"], steps))

    async def _upload(self, asked: Asked) -> Response:
        session = self._home.session(asked.path_params["session"])
        log = await uploads.store(self._home, asked.query_params.get("name", ""), asked.stream())
        if asked.query_params.get("use") == "into":  # a model to patch, and no log
            return JSONResponse({"id": log.id, "name": log.name})
        mapped = await run_in_threadpool(
            saved_maps.recalled, self._home.folder, log.path, session.choices
        )
        logs = [*session.choices.model_dump(mode="json")["logs"], {"id": log.id}]
        return await self._answer(self._home.change(session.id, {"logs": logs, **mapped}))

    async def _rig_file(self, asked: Asked) -> Response:
        """A rig's file as the axis of the session."""
        session = self._home.session(asked.path_params["session"])
        name = uploads.file_name(asked.query_params.get("name", ""))
        axis = rig_files.axis_of(await _text(asked), name)
        return await self._answer(self._home.change(session.id, rig_files.chosen(axis)))

    async def _keep_map(self, asked: Asked) -> Response:
        request, log = self._log(asked)
        table = await run_in_threadpool(self.contents_of, request, log)
        heads = [channel["name"] for channel in table["channels"]]
        await run_in_threadpool(saved_maps.keep, self._home.folder, heads, request)
        return await self._answer(self._home.session(asked.path_params["session"]))

    async def _events(self, asked: Asked) -> Response:
        """A session whenever it changes, as server-sent events."""
        session = asked.path_params["session"]
        self._home.session(session)

        async def stream() -> AsyncIterator[str]:
            last = ""
            while not await asked.is_disconnected():
                state = await run_in_threadpool(self.document, self._home.session(session))
                text = json.dumps(state)
                if text != last:
                    last = text
                    yield f"data: {text}\n\n"
                await asyncio.sleep(PACE)

        return StreamingResponse(stream(), media_type="text/event-stream")

    async def _answer(self, session: Session) -> Response:
        return JSONResponse(await run_in_threadpool(self.document, session))

    def document(self, session: Session) -> dict[str, Any]:
        """A session as the page shows it."""
        request, jobs = self._request(session), self._home.jobs(session.id)
        known = self._home.logs()
        unread = next(
            (w for k in range(len(request.choices.logs)) if (w := self._lacking(request, k))), ""
        )
        return {
            "id": session.id,
            "name": session.name,
            "step": session.step,
            "undo": session.undo,
            "redo": session.redo,
            "choices": session.choices.model_dump(mode="json"),
            "logs": [
                {"id": log.id, "name": known[log.id].name, "size": known[log.id].size}
                for log in session.choices.logs
                if log.id in known
            ],
            "axis": _axis(request),
            "drive": _drive(request),
            "steps": [asdict(step) for step in steps(request, jobs, unread)],
            "jobs": [_job(job) for job in jobs if job.kind != "estimate"],
            "estimate": next(
                (
                    _job(job)
                    for job in reversed(jobs)
                    if job.kind == "estimate" and job.choices.same_fit(session.choices)
                ),
                None,
            ),
        }

    def _request(self, session: Session) -> Request:
        paths = {i: log.path for i, log in self._home.logs().items()}
        if any(log.id not in paths for log in session.choices.logs):
            raise InputError("a log of this session is not known to the studio any more")
        return Request(session.choices, paths)

    # Logs.

    def _lacking(self, request: Request, log: int) -> str:
        """Why no recording can be made of a log; empty if one can."""
        try:
            return str(self.contents_of(request, log)["lacking"])
        except InputError as error:
            return str(error)

    def contents_of(self, request: Request, log: int, *, again: bool = False) -> dict[str, Any]:
        """What is in a log: looked for once, however often a window that follows it asks.

        Args:
            request: The session's.
            log: Which of its logs.
            again: Whether a refusal is not believed, as its reason may have passed unseen: a disk
                that was away, a package that was missing.

        Raises:
            InputError: it cannot be said.
        """
        path = Path(request.files[request.choices.logs[log].id])
        try:
            key = (str(path), stamp(path), request.reading)
        except OSError as error:
            raise InputError(f"{path.name}: {error.strerror or error}") from error
        if key not in self._contents or (again and isinstance(self._contents[key], InputError)):
            if len(self._contents) > KEPT:
                self._contents.clear()
            try:
                self._contents[key] = log_contents(request, log)
            except InputError as error:
                self._contents[key] = error
        result = self._contents[key]
        if isinstance(result, InputError):
            raise InputError(str(result))
        return result

    def _log(self, asked: Asked) -> tuple[Request, int]:
        request = self._request(self._home.session(asked.path_params["session"]))
        log = asked.path_params["log"]
        if log >= len(request.choices.logs):
            raise InputError("there is no such log")
        return request, log

    async def _log_contents(self, asked: Asked) -> Response:
        request, log = self._log(asked)
        table = await run_in_threadpool(partial(self.contents_of, request, log, again=True))
        heads = [channel["name"] for channel in table["channels"]]
        kept = saved_maps.is_kept(self._home.folder, heads, request.choices)
        return JSONResponse(table | {"mapped": saved_maps.is_mapped(request.choices), "kept": kept})

    async def _outline(self, asked: Asked) -> Response:
        request, log = self._log(asked)
        return JSONResponse(
            await run_in_threadpool(lambda: self._views.view(request, log).outline())
        )

    async def _overview(self, asked: Asked) -> Response:
        request, log = self._log(asked)
        return JSONResponse(await run_in_threadpool(self._overview_of, request, log))

    def _overview_of(self, request: Request, log: int) -> dict[str, Any]:
        view = self._views.view(request, log)
        return view.overview() | {"stated": stated_constants(request.reading_rig, view.recording)}

    async def _lines(self, asked: Asked) -> Response:
        request, log = self._log(asked)
        since, until = _number(asked, "since"), _number(asked, "until")
        pixels, mended = int(_number(asked, "pixels")), bool(_number(asked, "mended"))
        return JSONResponse(
            await run_in_threadpool(
                lambda: self._views.view(request, log).lines(since, until, pixels, mended)
            )
        )

    async def _cloud(self, asked: Asked) -> Response:
        request, log = self._log(asked)
        since, until = _number(asked, "since"), _number(asked, "until")
        return JSONResponse(
            await run_in_threadpool(lambda: self._views.view(request, log).cloud(since, until))
        )

    # Jobs and what comes of them.

    async def _ask(self, asked: Asked) -> Response:
        document = await _document(asked)
        session = self._home.session(asked.path_params["session"])
        kind, parent = document.get("kind"), document.get("parent")
        if kind not in get_args(Kind):
            raise InputError(f"kind: there are {', '.join(get_args(Kind))}")
        if kind == "estimate":  # of other choices than those that hold now it is of no use
            for job in self._home.jobs(session.id):
                if job.kind == kind and job.state in ("waiting", "running"):
                    self._home.cancel(job.id)
        if kind in ("plan", "compensate"):
            parent = self._fit(session.id, parent).id
        self._home.ask(session.id, cast("Kind", kind), parent)
        self._workers.wake()
        return await self._answer(self._home.session(session.id))

    async def _cancel(self, asked: Asked) -> Response:
        job = self._job(asked)
        self._home.cancel(job.id)
        return await self._answer(self._home.session(job.session))

    def _job(self, asked: Asked) -> SessionJob:
        job = self._home.job(asked.path_params["job"])
        if job.session != asked.path_params["session"]:
            raise InputError("there is no such job")
        return job

    def _fit(self, session: str, number: object) -> SessionJob:
        job = self._home.job(number) if isinstance(number, int) else None
        if job is None or job.session != session or (job.kind, job.state) != ("identify", "done"):
            raise InputError("choose a fit that is done")
        return job

    async def _result(self, asked: Asked) -> Response:
        job = self._job(asked)
        folder = self._home.results(job.id)
        return JSONResponse(await run_in_threadpool(fit_results, job.kind, folder))

    async def _file(self, asked: Asked) -> Response:
        job = self._job(asked)
        path, policy = result_file(self._home.results(job.id), asked.path_params["name"])
        headers = {} if policy is None else {"content-security-policy": policy}
        save = asked.query_params.get("save")
        return FileResponse(path, headers=headers, filename=path.name if save else None)

    async def _compare(self, asked: Asked) -> Response:
        session = self._home.session(asked.path_params["session"])
        folders = {
            job.id: self._home.results(job.id)
            for job in self._home.jobs(session.id)
            if (job.kind, job.state) == ("identify", "done")
        }
        return JSONResponse(await run_in_threadpool(compared, folders))

    async def _script(self, asked: Asked) -> Response:
        request = self._request(self._home.session(asked.path_params["session"]))
        return JSONResponse(
            {
                "command": request.command_text(),
                "select": request.command_text("select"),
                "python": request.python(),
                "files": request.texts(),
            }
        )

    async def _export(self, asked: Asked) -> Response:
        job = self._fit(asked.path_params["session"], asked.path_params["job"])
        options: Mapping[str, str] = dict(asked.query_params)
        card = self._home.results(job.id) / "card.json"
        files = {i: log.path for i, log in self._home.logs().items()}
        answer = await run_in_threadpool(exported, card, options, files)
        if options.get("save"):
            data, name, kind = answer.download()
            disposition = f'attachment; filename="{name}"'
            return Response(data, media_type=kind, headers={"content-disposition": disposition})
        return JSONResponse(answer.shown())


def _axis(request: Request) -> dict[str, Any] | None:
    """The session's own axis, as the catalogue has those that are shipped; None without one."""
    if request.choices.rig != AXIS:
        return None
    try:
        return rig_document(request.kind)
    except InputError:  # the lock of the next step says why
        return None


def _drive(request: Request) -> dict[str, str]:
    """What the drive of a session does to what it recorded, or why that cannot be said."""
    try:
        chain = request.drive_chain
    except InputError as error:
        return {"sentence": "", "error": str(error)}
    return {"sentence": chain.sentence() if chain else "", "error": ""}


def _job(job: SessionJob) -> dict[str, Any]:
    request = Request(job.choices, {})
    law, rig = job.choices.law, job.choices.rig
    with contextlib.suppress(InputError):
        law, rig = request.law, request.kind.name
    return {
        "id": job.id,
        "kind": job.kind,
        "parent": job.parent,
        "state": job.state,
        "cancelled": job.cancelled,
        "progress": dict(job.progress),
        "message": job.message,
        "created": job.created,
        "ended": job.ended,
        "law": law,
        "rig": rig,
    }


def _told(answer: Answer) -> Answer:
    """An answer that says in a line what could not be done."""

    async def told(asked: Asked) -> Response:
        try:
            return await answer(asked)
        except InputError as error:
            return JSONResponse({"error": str(error)}, status_code=400)
        except ClientDisconnect:  # nobody is there to be told
            return Response(status_code=400)

    return told


async def _document(asked: Asked) -> dict[str, Any]:
    """The JSON object that was sent.

    Raises:
        InputError: it is none, or too long.
    """
    text = await _text(asked)
    try:
        document = json_document(text)
    except (ValueError, RecursionError) as error:
        raise InputError("what was sent is no JSON") from error
    if not isinstance(document, dict):
        raise InputError("what was sent is no JSON object")
    return document


async def _text(asked: Asked) -> str:
    """The text that was sent.

    Raises:
        InputError: it is too long, or no text.
    """
    pieces = bytearray()
    async for piece in asked.stream():
        pieces += piece
        if len(pieces) > LARGEST:
            raise InputError("what was sent is too long")
    try:
        return pieces.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("what was sent is no text: it is to be UTF-8") from error


def _number(asked: Asked, name: str) -> float:
    return number(asked.query_params.get(name, ""), name)


def _asset(name: str) -> Response:
    """One of the page's own files; its colours and rules are those of a report."""
    if name == "report.css":
        return Response(style_sheet(), media_type="text/css")
    if name not in _assets():
        raise InputError("there is no such file")
    place = files("stribeck.studio") / "page"
    for part in name.split("/"):
        place /= part
    return Response(place.read_bytes(), media_type=_KINDS[Path(name).suffix])


@cache
def _assets() -> frozenset[str]:
    """The names of the page's files, which are all that can be asked for."""
    folder = files("stribeck.studio") / "page"
    names = set()
    for item in folder.iterdir():
        if item.is_dir():
            names |= {f"{item.name}/{inner.name}" for inner in item.iterdir()}
        else:
            names.add(item.name)
    return frozenset(n for n in names if Path(n).suffix in _KINDS)
