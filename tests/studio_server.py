"""A studio as a process of its own, and requests as any program can send them."""

from __future__ import annotations

import http.client
import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from patience import PATIENCE


class Answer(NamedTuple):
    """What the studio answered."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)


@dataclass
class Studio:
    """A running studio.

    Args:
        process: It.
        home: Its home.
        address: What it printed.
        cookie: Of its page; empty until `enter`.
    """

    process: subprocess.Popen[str]
    home: Path
    address: str
    cookie: str = ""
    session: str = ""
    port: int = field(init=False)

    def __post_init__(self) -> None:
        match = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/start\?token=([\w-]+)", self.address)
        assert match is not None, self.address
        self.port, self.token = int(match[1]), match[2]

    def ask(
        self,
        method: str,
        path: str,
        body: bytes | Mapping[str, Any] | None = None,
        headers: Mapping[str, str] = {},
    ) -> Answer:
        """Send a request as its page does, but for what `headers` say."""
        own = {"Host": f"127.0.0.1:{self.port}", "Cookie": self.cookie}
        if method not in ("GET", "HEAD"):
            own |= {"Origin": f"http://127.0.0.1:{self.port}", "Sec-Fetch-Site": "same-origin"}
        sent = {name: value for name, value in {**own, **headers}.items() if value}
        data = json.dumps(body).encode() if isinstance(body, Mapping) else body
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        try:
            connection.request(method, path, data, sent)
            answer = connection.getresponse()
            heads = {name.lower(): value for name, value in answer.getheaders()}
            return Answer(answer.status, heads, answer.read())
        finally:
            connection.close()

    def enter(self) -> Answer:
        """Open its address as a browser does."""
        answer = self.ask("GET", f"/start?token={self.token}")
        self.cookie = answer.headers["set-cookie"].partition(";")[0]
        place = answer.headers["location"].split("/")
        if len(place) > 2:
            self.session = f"/api/sessions/{place[2]}"
        return answer

    def choose(self, **choices: Any) -> Any:
        """Change the session, and return it."""
        answer = self.ask("PATCH", self.session, {"choices": choices})
        assert answer.status == 200, answer.body
        return answer.json

    def work(self, kind: str, **more: Any) -> Any:
        """Ask for a job, and return it."""
        answer = self.ask("POST", f"{self.session}/jobs", {"kind": kind, **more})
        assert answer.status == 200, answer.body
        return answer.json["jobs"][-1]

    def work_silently(self, kind: str) -> None:
        """Ask for work of which the list of jobs says nothing."""
        assert self.ask("POST", f"{self.session}/jobs", {"kind": kind}).status == 200

    def until_state(self, holds: Callable[[Any], bool]) -> Any:
        """Wait until the session is in a state, and return it."""
        end = time.monotonic() + PATIENCE
        while not holds(state := self.ask("GET", self.session).json):
            assert time.monotonic() < end, state
            time.sleep(0.05)
        return state

    def until(self, job: int, *states: str) -> Any:
        """Wait until a job is in one of some states, and return it."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            jobs = self.ask("GET", self.session).json["jobs"]
            job_now = next(each for each in jobs if each["id"] == job)
            if job_now["state"] in states:
                return job_now
            time.sleep(0.05)
        raise AssertionError(job_now)

    def end(self) -> None:
        self.process.terminate()
        self.process.wait(PATIENCE)
        if self.process.stdout is not None:
            self.process.stdout.close()


def start(home: Path, *logs: Path | str) -> Studio:
    """A studio on a free port."""
    words = ["studio", *map(str, logs), "--home", str(home), "--no-browser"]
    process = subprocess.Popen(
        [sys.executable, "-m", "stribeck", *words],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=os.environ.copy(),
    )  # fmt: skip
    assert process.stdout is not None
    return Studio(process, home, process.stdout.readline().strip())


@contextmanager
def studio(home: Path, *logs: Path | str) -> Iterator[Studio]:
    """A studio that has been entered, until the block ends."""
    opened = start(home, *logs)
    try:
        opened.enter()
        yield opened
    finally:
        opened.end()


def sliding_log(file: Path, seconds: float = 12.0) -> Path:
    """A log of an axis of 2 kg with friction 5 N + 8 N s/m whose force was measured, as CSV."""
    import numpy as np  # noqa: PLC0415

    rng = np.random.default_rng(3)
    t = np.arange(0.0, seconds, 2e-3)
    w = 2 * np.pi * 0.6
    x, v, a = 0.1 * np.sin(w * t), 0.1 * w * np.cos(w * t), -0.1 * w * w * np.sin(w * t)
    force = 2.0 * a + 5.0 * np.tanh(v / 1e-4) + 8.0 * v + rng.normal(0.0, 0.05, len(t))
    columns = np.stack([t, 1e3 * x, force], axis=1)
    np.savetxt(
        file, columns, delimiter=",", header="t_s,position_mm,force_N", comments="", fmt="%.9g"
    )
    return file


def bed_log(file: Path) -> Path:
    """A log of the paper's bed, whose identification is a search of seconds."""
    from stribeck.report.motion_file import write_twin  # noqa: PLC0415
    from stribeck.rig.twin import TestBed  # noqa: PLC0415

    write_twin(TestBed(), "both", 1, file)
    return file
