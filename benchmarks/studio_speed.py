"""The studio on a log of ten million rows: first picture, drag latency, memory, long tasks.

    python benchmarks/studio_speed.py [ROWS]
    python benchmarks/studio_speed.py shown     # the result that is kept, in words

The log is made in a temporary folder: an axis with friction, noise on position and force, 1 kHz.
The page is opened in the system's Chromium, its range dragged thirty times; requests for random
windows are timed beside it. Times are wall times of this machine and read as such; counts and
bytes are not. What the tasks of the page's main thread take while it is dragged is told twice: by
the clock, which other programs on the machine prolong, and in processor time, which they do not.
The result is studio_speed.json beside this file.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
import time
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

RESULT = Path(__file__).with_suffix(".json")
#: Requests for random windows, drags on the page, and its width.
REQUESTS, DRAGS, PIXELS = 300, 30, 1180
#: A task of the page's main thread is long from here on, ms, as the standard has it.
LONG = 50
_OBSERVE = """
window.long = [];
new PerformanceObserver((list) => window.long.push(...list.getEntries().map((e) => e.duration)))
  .observe({ entryTypes: ["longtask"] });
"""


def log(file: Path, rows: int) -> None:
    """A recording of an axis whose force was measured, of so many rows."""
    rng = np.random.default_rng(0)
    t = 1e-3 * np.arange(rows)
    w = 2 * np.pi * 0.5
    x = 0.1 * np.sin(w * t) + rng.normal(0.0, 1e-6, rows)
    force = 5.0 * np.sign(np.cos(w * t)) + 2.0 * np.cos(w * t) + rng.normal(0.0, 0.05, rows)
    np.savez(file, t_s=t, position_m=x, force_N=force)


def peak(process: int) -> int:
    """The most memory that a process has had, MB."""
    status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    match = re.search(r"VmHWM:\s+(\d+)", status)
    return int(match[1]) // 1024 if match else 0


def requests(port: int, cookie: str, session: str, seconds: float) -> list[float]:
    """How long the lines of random windows take, ms, sorted."""
    rng = np.random.default_rng(1)
    times = []
    for _ in range(REQUESTS):
        width = seconds * 10 ** rng.uniform(-6, 0)
        since = rng.uniform(0, seconds - width)
        window = f"since={since}&until={since + width}&pixels={PIXELS}&mended=1"
        place = f"{session}/logs/0/lines?{window}"
        start = time.perf_counter()
        connection = HTTPConnection("127.0.0.1", port)
        connection.request("GET", place, headers={"Cookie": cookie})
        body = connection.getresponse().read()
        times.append(1e3 * (time.perf_counter() - start))
        connection.close()
        if not json.loads(body)["t"]:
            raise SystemExit(f"{place}: no lines")
    return sorted(times)


def longest_tasks(trace: bytes) -> dict[str, Any]:
    """Of a trace of Chromium: how long the main thread's tasks took, ms.

    The tasks that start and end the trace itself are not of the page.
    """
    events = json.loads(trace)["traceEvents"]
    threads = {
        (e["pid"], e["tid"])
        for e in events
        if e["name"] == "thread_name" and e["args"]["name"] == "CrRendererMain"
    }
    tasks = [e for e in events if e["name"].endswith("RunTask") and (e["pid"], e["tid"]) in threads]
    spent = sorted(1e-3 * e.get("tdur", 0) for e in tasks)
    return {
        "tasks": len(tasks),
        "longest_ms_of_processor": spent[-1],
        "p99_ms_of_processor": spent[-len(spent) // 100],
        "longest_ms_by_the_clock": 1e-3 * max(e.get("dur", 0) for e in tasks),
    }


def page(address: str) -> tuple[dict[str, Any], str, str]:
    """The log on the page; then its cookie, and its session's address."""
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        window = chromium.new_page(viewport={"width": 1280, "height": 900})
        window.set_default_timeout(120_000)
        window.add_init_script(_OBSERVE)
        window.goto(address)
        window.wait_for_selector("main button.main")
        start = time.perf_counter()
        window.click("main button.main")
        window.wait_for_selector(".u-over")
        first = time.perf_counter() - start
        window.wait_for_selector(".tiles")
        judged = time.perf_counter() - start
        window.evaluate("window.long.length = 0")
        chromium.start_tracing(page=window, categories=["toplevel", "devtools.timeline"])
        rng = np.random.default_rng(2)
        for k in range(DRAGS):
            box: Any = window.locator(".u-over").first.bounding_box()
            left = rng.uniform(0.05, 0.6)
            right = left + rng.uniform(0.05, 0.35)
            window.mouse.move(box["x"] + left * box["width"], box["y"] + 50)
            window.mouse.down()
            window.mouse.move(box["x"] + right * box["width"], box["y"] + 60, steps=8)
            with window.expect_response("**/lines?*"):
                window.mouse.up()
            if k % 5 == 4:  # noqa: PLR2004 - before a window is a few samples wide
                with window.expect_response("**/lines?*"):
                    window.get_by_role("button", name="All", exact=True).click()
        window.wait_for_timeout(300)
        tasks = longest_tasks(chromium.stop_tracing())
        long = window.evaluate("window.long")
        cookies = {c["name"]: c["value"] for c in window.context.cookies()}
        session = "/api/sessions/" + window.url.split("/")[-2]
        chromium.close()
    cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
    measured = {
        "first_picture_s": first,
        "judged_s": judged,
        "tasks": {**tasks, "long_tasks_ms": long},
    }
    return measured, cookie, session


def words(result: dict[str, Any]) -> str:
    """A result, a line each."""
    request = result["request_ms"]
    lines = [
        ("rows", f"{result['rows']:,}"),
        ("from the command to the address", f"{result['start_s']:.2g} s"),
        ("first picture", f"{result['first_picture_s']:.2g} s"),
        ("judged by the data gate", f"{result['judged_s']:.2g} s"),
        ("answer to a dragged range, median", f"{request['median']:.2g} ms"),
        ("the same, 99th percentile", f"{request['p99']:.2g} ms"),
        (
            "longest task of the page in 30 drags",
            f"{result['tasks']['longest_ms_of_processor']:.2g} ms of processor time",
        ),
        ("memory of the server at most", f"{1e-3 * result['peak_MB']:.2g} GB"),
    ]  # fmt: skip
    return "\n".join(f"{name:<38}{value}" for name, value in lines)


def main() -> None:
    """Measure, print, and keep the result."""
    if sys.argv[1:] == ["shown"]:
        print(words(json.loads(RESULT.read_text(encoding="utf-8"))))
        return
    rows = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**7
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "axis.npz"
        log(file, rows)
        command = [sys.executable, "-m", "stribeck", "studio", str(file), "--no-browser"]
        start = time.perf_counter()
        process = subprocess.Popen(  # noqa: S603 - our own command
            [*command, "--home", f"{folder}/home"], stdout=subprocess.PIPE, text=True
        )
        address = (process.stdout or sys.stdin).readline().strip()
        started = time.perf_counter() - start
        try:
            measured, cookie, session = page(address)
            times = requests(int(address.split(":")[2].split("/")[0]), cookie, session, 1e-3 * rows)
            result = {
                "rows": rows, "file_MB": file.stat().st_size >> 20, "start_s": started, **measured,
                "request_ms": {"median": times[len(times) // 2], "p99": times[-len(times) // 100]},
                "peak_MB": peak(process.pid),
            }  # fmt: skip
        finally:
            process.terminate()
            process.wait()
    RESULT.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(words(result))


if __name__ == "__main__":
    main()
