"""The studio answers the browser that opened its address, and nobody else."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from patience import PATIENCE
from stribeck.errors import InputError
from stribeck.studio.uploads import LONGEST, file_name
from studio_server import Studio, sliding_log, start, studio


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    folder = tmp_path_factory.mktemp("studio")
    with studio(folder / "home", sliding_log(folder / "axis.csv")) as running:
        yield running


def test_the_start_address_works_once_and_its_cookie_is_strict(
    opened: Studio, tmp_path: Path
) -> None:
    with studio(tmp_path / "home") as other:
        fresh = start(tmp_path / "home")
        cookie = fresh.enter().headers["set-cookie"].split("; ")
        fresh.end()
        assert cookie[0] == other.cookie
        assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie)
    again = opened.ask("GET", f"/start?token={opened.token}", headers={"Cookie": ""})
    assert again.status == 403
    assert "set-cookie" not in again.headers
    wrong = opened.ask("GET", "/start?token=nonsense", headers={"Cookie": ""})
    assert (wrong.status, "set-cookie" in wrong.headers) == (403, False)


def test_the_cookie_outlives_a_restart_and_its_secret_is_the_owners_alone(tmp_path: Path) -> None:
    with studio(tmp_path / "home") as running:
        first = running.cookie
        answer = running.ask("GET", "/")
        assert "set-cookie" not in answer.headers
        assert (tmp_path / "home" / "secret").stat().st_mode & 0o077 == 0
    with studio(tmp_path / "home") as running:
        assert running.cookie == first  # a page that was open goes on after a restart


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Cookie": ""}, 403),
        ({"Cookie": "stribeck-studio=guess"}, 403),
        ({"Cookie": "stribeck-studio=\udcff".encode("utf-8", "replace").decode()}, 403),
        ({"Host": "evil.example"}, 421),
        ({"Host": "evil.example:80"}, 421),
        ({"Host": "127.0.0.1"}, 421),
        ({"Host": "127.0.0.1:1"}, 421),
        ({"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"}, 403),
        ({"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "cors"}, 403),
    ],
)
@pytest.mark.parametrize(
    "path", ["/", "/page/main.js", "/api/sessions", "SESSION", "SESSION/events"]
)
def test_reading_is_refused(
    opened: Studio, path: str, headers: dict[str, str], status: int
) -> None:
    answer = opened.ask("GET", path.replace("SESSION", opened.session), headers=headers)
    assert answer.status == status
    assert b"axis.csv" not in answer.body


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": ""},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Host": "evil.example"},
        {"Cookie": ""},
    ],
)
def test_writing_is_refused(opened: Studio, headers: dict[str, str]) -> None:
    before = opened.ask("GET", opened.session).json
    for method, path, body in (
        ("PATCH", opened.session, {"choices": {"rig": "emps"}}),
        ("POST", f"{opened.session}/jobs", {"kind": "identify"}),
        ("POST", f"{opened.session}/undo", {}),
        ("POST", "/api/sessions", {"name": "theirs"}),
        ("POST", f"{opened.session}/files?name=x.csv", {"a": 1}),
    ):
        assert opened.ask(method, path, body, headers).status in (403, 421)
    assert opened.ask("GET", opened.session).json == before


def test_a_page_is_told_to_load_nothing_from_elsewhere(opened: Studio) -> None:
    answer = opened.ask("GET", "/")
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "http" not in policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["cache-control"] == "no-store"


@pytest.mark.parametrize(
    "name",
    [
        "../index.html",
        "..%2f..%2f..%2fserver.py",
        "%2e%2e/home.py",
        "/etc/passwd",
        "vendor/../index.html",
    ],
)
def test_only_the_pages_own_files_can_be_asked_for(opened: Studio, name: str) -> None:
    answer = opened.ask("GET", f"/page/{name}")
    assert answer.status in (400, 404)
    assert b"import" not in answer.body


@pytest.mark.parametrize(
    ("sent", "kept"),
    [
        ("axis.csv", "axis.csv"),
        ("../../etc/passwd", "passwd"),
        ("C:\\logs\\Scope 1.csv", "Scope 1.csv"),
        ("a/b/../c.csv", "c.csv"),
        ("x\0y\n.csv", "x_y_.csv"),
        ("log@1s:2s.csv", "log_1s_2s.csv"),
        ("pos.csv+force.csv", "pos.csv_force.csv"),
        ("<img src=x>.csv", "_img src=x_.csv"),
        (".hidden", "hidden"),
        ("Messung ä 位置.csv", "Messung ä 位置.csv"),
    ],
)
def test_names_are_never_paths(sent: str, kept: str) -> None:
    assert file_name(sent) == kept


@pytest.mark.parametrize("sent", ["", "..", "/", "...", "___"])
def test_a_name_of_which_nothing_is_left_is_refused(sent: str) -> None:
    with pytest.raises(InputError, match="no name for a file"):
        file_name(sent)


def test_a_long_name_keeps_its_extension() -> None:
    name = file_name("x" * 500 + ".csv")
    assert len(name) == LONGEST
    assert name.endswith("x.csv")


def test_an_upload_lies_within_the_home_whatever_its_name(opened: Studio) -> None:
    before = {p for p in opened.home.parent.rglob("*") if opened.home not in p.parents}
    sent = opened.ask("POST", f"{opened.session}/files?name=..%2F..%2Fout.csv", b"t_s,x_mm\n0,1\n")
    assert sent.status == 200
    assert sent.json["logs"][-1]["name"] == "out.csv"
    assert {p for p in opened.home.parent.rglob("*") if opened.home not in p.parents} == before
    assert [p.name for p in (opened.home / "logs").rglob("*") if p.is_file()] == ["out.csv"]
    opened.ask("POST", f"{opened.session}/undo", {})


def test_an_upload_over_the_budget_is_refused_and_nothing_of_it_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import asyncio  # noqa: PLC0415
    from collections.abc import AsyncIterator  # noqa: PLC0415

    from stribeck.studio import uploads  # noqa: PLC0415
    from stribeck.studio.home import Home  # noqa: PLC0415

    monkeypatch.setattr(uploads, "LARGEST", 1000)

    async def body() -> AsyncIterator[bytes]:
        for _ in range(3):
            yield b"x" * 400

    with Home(tmp_path) as home:
        with pytest.raises(InputError, match="larger than"):
            asyncio.run(uploads.store(home, "large.csv", body()))
        assert not list((tmp_path / "logs").iterdir())
        assert home.logs() == {}


@pytest.mark.parametrize(
    ("body", "line"),
    [
        (b"{", "no JSON"),
        (b"[1]", "no JSON object"),
        (b'{"choices": 3}', "send an object"),
        (b'{"choices": {"nonsense": 1}}', "nonsense"),
        (b'{"choices": {"logs": [{"id": "../../etc"}]}}', "logs.0.id"),
        (b'{"choices": {"logs": [{"id": "0123456789abcdef"}]}}', "no such log"),
        (b'{"choices": {"seed": 1e400}}', "choices"),
        (b'{"choices": {"rig": "' + b"x" * 1000 + b'"}}', "rig"),
        (b'{"choices": {"columns": {"": "x"}}}', "columns"),
        (b"x" * (1 << 19), "too long"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_line(opened: Studio, body: bytes, line: str) -> None:
    before = opened.ask("GET", opened.session).json
    answer = opened.ask("PATCH", opened.session, body)
    assert answer.status == 400
    assert line in answer.json["error"]
    assert "\n" not in answer.json["error"]
    assert opened.ask("GET", opened.session).json == before


def test_numbers_that_no_job_and_no_log_has_are_refused_in_a_line(opened: Studio) -> None:
    great = 10**30
    for method, path, body in (
        ("GET", f"jobs/{great}/result", None),
        ("POST", f"jobs/{great}/cancel", {}),
        ("POST", "jobs", {"kind": "plan", "parent": great}),
        ("GET", f"logs/{great}/contents", None),
        ("POST", f"logs/{great}/map", {}),
    ):
        answer = opened.ask(method, f"{opened.session}/{path}", body)
        assert answer.status == 400, path
        assert answer.json["error"] in (
            "there is no such job", "there is no such log", "choose a fit that is done"
        )  # fmt: skip


def test_a_request_that_names_two_hosts_is_refused(opened: Studio) -> None:
    lines = (
        "GET /api/sessions HTTP/1.1",
        f"Host: 127.0.0.1:{opened.port}",
        "Host: evil.example",
        f"Cookie: {opened.cookie}",
        "Connection: close",
    )
    with socket.create_connection(("127.0.0.1", opened.port), timeout=PATIENCE) as connection:
        connection.sendall("\r\n".join((*lines, "", "")).encode())
        answer = connection.makefile("rb").readline()
    assert int(answer.split()[1]) in (400, 421)
