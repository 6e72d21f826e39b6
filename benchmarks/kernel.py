"""One candidate of the slide bed: C in fixed steps, SciPy, the plain reference and the kernel.

Everything runs in this one process on one thread, the same equations on the same parameter sets,
and each is compared with one converged motion: the kernel at a ten-thousandth of its tolerance,
which is itself checked against the reference extrapolated to a step of zero.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from stribeck.friction import LAWS
from stribeck.rig.motion import reference, row_pool
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.drives import BAND
from stribeck.rig.motion.event_driven import misfits, trajectories
from stribeck.rig.motion.track import Track, track
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.space import Array

LAW = LAWS["stribeck"]
SECONDS, RATE, SPEED = 36.6, 100.0, 5e-3
#: Tolerances of the kernel that keep 1e-3 and 1e-2 mm RMS over the whole search box, and the
#: steps of the C loop that keep about as much.
ACCURACIES = {"1e-3 mm": (1.0, 1e-5), "1e-2 mm": (10.0, 1e-4)}
CONVERGED = 1e-4
#: The least of so many timings counts: another program can only make one longer.
TIMES = 7
#: Candidates of a call, as a search makes it.
CALL = 40

SOURCE = Path(__file__).with_name("slide_bed.c")
FLAGS = ("-O3", "-march=native", "-ffast-math", "-shared", "-fPIC")


def ramp(direction: int) -> Track:
    """The ramp of the paper's section 4.5, from where its identification starts."""
    t = np.arange(round(SECONDS * RATE) + 1) / RATE
    x0 = 0.112 if direction > 0 else 0.325
    return track(Drive.line(0.0, x0, SECONDS, direction * SPEED), t, x0)


def uneven(direction: int) -> Track:
    """The same with a speed that is another one every second: no slip is the one before."""
    on = ramp(direction)
    knots = np.arange(0.0, SECONDS + 1.0)
    speed = direction * SPEED * (1.0 + 0.2 * np.sin(2.0 * knots[:-1]))
    x = on.x0 + np.append(0.0, np.cumsum(speed))
    return track(Drive(knots, x), on.t, on.x0)


def rms(x: Array, y: Array) -> Array:
    """The distance of two motions, mm RMS, by row."""
    return 1e3 * np.sqrt(np.mean((x - y) ** 2, axis=-1))  # type: ignore[no-any-return]


def least(
    work: Callable[[], object],
    times: int = TIMES,
    clock: Callable[[], float] = time.thread_time,
) -> float:
    """The least time that some work takes, s; of this thread on its core unless told otherwise."""
    found = []
    for _ in range(times):
        began = clock()
        work()
        found.append(clock() - began)
    return min(found)


@contextmanager
def of(hands: row_pool.RowPool) -> Iterator[None]:
    """The kernel with other threads than it would take by itself."""
    usual = row_pool.pool
    row_pool.pool = lambda: hands
    try:
        yield
    finally:
        row_pool.pool = usual


class CLoop:
    """The fixed-step loop of slide_bed.c."""

    def __init__(self, folder: Path) -> None:
        library = folder / "slide_bed.so"
        command = ["gcc", *FLAGS, "-o", str(library), str(SOURCE), "-lm"]
        subprocess.run(command, check=True, capture_output=True)  # noqa: S603 - no outside text
        self.function = ctypes.CDLL(str(library)).slide_bed
        self.function.restype = ctypes.c_double

    def run(self, p: Array, c: Array, on: Track, dt: float, out: Array | None) -> float:
        """Simulate one set; positions go to `out`."""

        def pointer(a: Array) -> Any:
            return a.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

        return float(
            self.function(
                pointer(p), pointer(c), pointer(on.knots_t), pointer(on.knots_x),
                ctypes.c_long(len(on.knots_t)), ctypes.c_double(on.x0), ctypes.c_long(len(on.t)),
                ctypes.c_double(RATE), ctypes.c_double(dt), pointer(on.measured),
                None if out is None else pointer(out),
            )
        )  # fmt: skip


def scipy_motion(p: Array, c: Array, on: Track) -> Array:
    """Positions by SciPy's solve_ivp (LSODA) with events, piece by piece of stick and slip."""
    band, level = c[BAND], float(LAW.slip(0.0, p))
    rate = (on.knots_x[1] - on.knots_x[0]) / (on.knots_t[1] - on.knots_t[0])
    s = float(np.sign(rate))

    def command(t: float) -> float:
        return float(on.knots_x[0] + rate * (t - on.knots_t[0]))

    def held(t: float, y: Array) -> list[float]:  # the momentum, as a velocity, in its dead band
        F = reference.drive(c, command(t) - y[1])
        return [float(reference.push(c, F, -level, level)), 0.0]

    def slipping(t: float, y: Array) -> list[float]:
        a = reference.acceleration(LAW.slip, p, c, command(t) - y[1], y[0], s)
        return [a, y[0]]

    def loose(_: float, y: Array) -> float:
        return float(abs(y[0]) - band)

    def rest(_: float, y: Array) -> float:
        return float(s * y[0] - band)

    loose.terminal = rest.terminal = True  # type: ignore[attr-defined]
    loose.direction, rest.direction = 1.0, -1.0  # type: ignore[attr-defined]
    x = np.full(len(on.t), np.nan)
    now, at, end = 0.0, on.x0, float(on.t[-1])
    while now < end:
        reach = (level + c[5]) / ((c[1] + c[3]) if s > 0 else (c[2] + c[4]))
        edge = min(end, max(now, (at + s * reach - on.knots_x[0]) / rate))
        begun, state = now, [0.0, at]
        if edge < end:
            found = solve_ivp(
                held, (edge, end), state, "LSODA", events=loose, rtol=1e-8, atol=1e-10
            )
            edge = float(found.t[-1])
        x[(on.t >= begun) & (on.t <= edge)] = at
        now = edge
        if now >= end:
            break
        found = solve_ivp(
            slipping, (now, end), [s * band, at], "LSODA", dense_output=True, events=rest,
            rtol=1e-7, atol=1e-9, max_step=0.05,
        )  # fmt: skip
        rows = (on.t > now) & (on.t <= found.t[-1])
        x[rows] = found.sol(on.t[rows])[1]  # type: ignore[misc]
        now, at = float(found.t[-1]), float(found.y[1, -1])
    return x


def richardson(p: Array, c: Array, on: Track, dt: float) -> Array:
    """The reference at a step of zero, from two steps and its second order."""
    coarse, _ = reference.trajectory(LAW, p, c, on, dt)
    fine, _ = reference.trajectory(LAW, p, c, on, 0.5 * dt)
    return fine + (fine - coarse) / 3.0


def spread(values: Array) -> dict[str, float]:
    """Median and worst."""
    return {"median": float(np.median(values)), "worst": float(np.max(values))}


def apiece(p: Array, c: Array, on: Track, tolerance: float) -> Array:
    """What the kernel takes for each set, s, after the others: the processor has not learnt it.

    Each is a call by itself, less what a call takes that ends at once, for a mass of zero.
    """
    rows = [(p[k : k + 1], c[k : k + 1]) for k in range(len(p))]
    empty = np.zeros_like(c[:1])
    taken, nothing = np.full((2, len(p)), np.inf)
    for _ in range(TIMES):
        for k, (q, d) in enumerate(rows):
            began = time.thread_time()
            misfits(LAW, q, d, on, tolerance)
            done = time.thread_time()
            misfits(LAW, q, empty, on, tolerance)
            nothing[k] = min(nothing[k], time.thread_time() - done)
            taken[k] = min(taken[k], done - began)
    return taken - float(np.median(nothing))


def direction_found(direction: int, n: int, few: int, loop: CLoop | None) -> dict[str, Any]:
    """One direction of the ramp: errors and times of everybody, and the ratios set by set."""
    on = ramp(direction)
    p, c = SLIDE_BED.split(LAW, SLIDE_BED.sample(LAW, np.random.default_rng(2012 + direction), n))
    p, c = np.ascontiguousarray(p), np.ascontiguousarray(c)
    converged, _ = trajectories(LAW, p, c, on, CONVERGED)
    some = range(0, n, max(1, n // few))
    exact = np.array([richardson(p[k], c[k], on, 1e-5) for k in some])
    found: dict[str, Any] = {
        "sets": n,
        "converged_from_extrapolated_reference_mm": spread(rms(converged[list(some)], exact)),
    }
    for accuracy, (tolerance, dt) in ACCURACIES.items():
        x, _ = trajectories(LAW, p, c, on, tolerance)
        whole = least(lambda s=tolerance: misfits(LAW, p, c, on, s)) / n  # type: ignore[misc]
        each = apiece(p, c, on, tolerance)
        one: dict[str, Any] = {
            "tolerance": tolerance,
            "kernel_error_mm": spread(rms(x, converged)),
            "kernel_us": spread(1e6 * each) | {"in_one_call": 1e6 * whole},
        }
        if loop is not None:
            picked, out = range(0, n, max(1, n // (10 * few))), np.empty(len(on.t))
            seconds, error = [], []
            for k in picked:
                seconds.append(least(lambda k=k, dt=dt: loop.run(p[k], c[k], on, dt, None), 2))  # type: ignore[misc]
                loop.run(p[k], c[k], on, dt, out)
                error.append(rms(out, converged[k]))
            c_ms, kernel = 1e3 * np.array(seconds), 1e3 * each[list(picked)]
            one |= {
                "c_step_s": dt,
                "c_sets": len(seconds),
                "c_ms": spread(c_ms),
                "c_error_mm": spread(np.array(error)),
                "c_over_kernel": {
                    "median": float(np.median(c_ms / kernel)),
                    "worst": float(np.min(c_ms / kernel)),
                    "median_c_over_worst_kernel": float(np.median(c_ms) / (1e3 * each).max()),
                },
            }
        found[accuracy] = one
    found["others"] = others(p, c, on, converged, list(some)[: min(3, few)])
    return found


def others(p: Array, c: Array, on: Track, converged: Array, sets: list[int]) -> dict[str, Any]:
    """SciPy and the reference, on a few sets."""
    found: dict[str, Any] = {}
    reference.trajectory(LAW, p[0], c[0], on, 1e-3)  # compiled
    roads: dict[str, Callable[[int], Array]] = {
        "scipy solve_ivp, LSODA with events": lambda k: scipy_motion(p[k], c[k], on),
        "reference, step 2e-5 s": lambda k: reference.trajectory(LAW, p[k], c[k], on, 2e-5)[0],
    }
    for name, road in roads.items():
        seconds, error = [], []
        for k in sets:
            began = time.thread_time()
            x = road(k)
            seconds.append(time.thread_time() - began)
            error.append(rms(x, converged[k]))
        found[name] = {
            "sets": len(sets),
            "ms": spread(1e3 * np.array(seconds)),
            "error_mm": spread(np.array(error)),
        }
    return found


def uneven_found(n: int) -> dict[str, Any]:
    """A command under which no slip repeats: each has to be integrated."""
    on = uneven(1)
    p, c = SLIDE_BED.split(LAW, SLIDE_BED.sample(LAW, np.random.default_rng(2013), n))
    converged, _ = trajectories(LAW, p, c, on, CONVERGED)
    found: dict[str, Any] = {"sets": n}
    for accuracy, (tolerance, _) in ACCURACIES.items():
        x, _ = trajectories(LAW, p, c, on, tolerance)
        found[accuracy] = {
            "kernel_us": 1e6 * least(lambda s=tolerance: misfits(LAW, p, c, on, s)) / n,  # type: ignore[misc]
            "kernel_error_mm": spread(rms(x, converged)),
        }
    return found


def threads_found(turns: int) -> dict[str, Any]:
    """Throughput of one and of two threads, calls of a search and great ones, taken in turns."""
    on = ramp(1)
    if row_pool.threads() < 2:  # noqa: PLR2004
        return {"cores": row_pool.threads()}
    hands = {1: row_pool.RowPool(1), 2: row_pool.RowPool(2)}
    found: dict[str, Any] = {"cores": row_pool.threads(), "same_bits": True, "calls": {}}
    for candidates, in_a_turn in ((CALL, 20), (100 * CALL, 1)):
        at = SLIDE_BED.sample(LAW, np.random.default_rng(7), candidates)
        seconds: dict[int, list[float]] = {1: [], 2: []}
        for _ in range(turns if candidates == CALL else max(turns // 20, 2)):
            bits = set()
            for n, taken in seconds.items():
                with of(hands[n]):
                    some = []
                    for _ in range(in_a_turn):
                        began = time.perf_counter()
                        sse = SLIDE_BED.misfits(LAW, at, on)
                        some.append(time.perf_counter() - began)
                taken.append(float(np.median(some)))
                bits.add(sse.tobytes())
            found["same_bits"] &= len(bits) == 1
        one, two = np.array(seconds[1]), np.array(seconds[2])
        found["calls"][str(candidates)] = {
            "one_thread_us": 1e6 * float(one.min()),
            "two_threads_us": 1e6 * float(two.min()),
            "gain": {
                "median": float(np.median(one / two)),
                "of_least": float(one.min() / two.min()),
            },
        }
    hands[2].dismiss()
    return found


def measure(quick: bool = False) -> dict[str, Any]:
    """Everything, as JSON; `quick` takes few sets, to see that it runs."""
    n, few = (40, 2) if quick else (1000, 10)
    with tempfile.TemporaryDirectory() as folder, of(row_pool.RowPool(1)):
        loop = CLoop(Path(folder)) if shutil.which("gcc") else None
        found: dict[str, Any] = {
            "ramp": {"seconds": SECONDS, "rate_hz": RATE, "speed_mm_s": 1e3 * SPEED},
            "c": " ".join(("gcc", *FLAGS)) if loop else "gcc is not there: no C figures",
            "right": direction_found(1, n, few, loop),
            "left": direction_found(-1, n, few, loop),
            "no slip repeats": uneven_found(n),
        }
    found["threads"] = threads_found(20 if quick else 200)
    return found


def tables(found: dict[str, Any]) -> list[str]:
    """What was found as Markdown, a line a line."""
    lines = [
        "| ramp | accuracy | who | median | worst | error, median / mm | error, worst / mm |",
        "|---|---|---|---|---|---|---|",
    ]
    for direction in ("right", "left"):
        for accuracy in ACCURACIES:
            one, begin = found[direction][accuracy], f"| {direction} | {accuracy} |"
            if "c_ms" in one:
                lines.append(
                    f"{begin} C, step {one['c_step_s']:g} s | {_us(1e3, one['c_ms'])} "
                    f"| {_mm(one['c_error_mm'])} |"
                )
            lines.append(
                f"{begin} kernel | {_us(1.0, one['kernel_us'])} | {_mm(one['kernel_error_mm'])} |"
            )
            if "c_over_kernel" in one:
                ratio = one["c_over_kernel"]
                lines.append(
                    f"{begin} C over kernel | {ratio['median']:.0f} | {ratio['worst']:.0f} | | |"
                )
        for name, one in found[direction]["others"].items():
            lines.append(
                f"| {direction} | | {name} | {_us(1e3, one['ms'])} | {_mm(one['error_mm'])} |"
            )
    for accuracy in ACCURACIES:
        one = found["no slip repeats"][accuracy]
        lines.append(
            f"| uneven | {accuracy} | kernel, each slip a new one | {one['kernel_us']:.1f} us | "
            f"| {_mm(one['kernel_error_mm'])} |"
        )
    threads = found["threads"]
    if threads["cores"] < 2:  # noqa: PLR2004
        return lines
    bits = "the same bits" if threads["same_bits"] else "OTHER BITS"
    for candidates, one in threads["calls"].items():
        gain = one["gain"]
        said = (
            f"Two threads do {gain['median']:.2f} times as much as one with {int(candidates):,} "
            f"candidates a call (median of turns; {gain['of_least']:.2f} by the least times), "
            f"{bits}."
        )
        lines += ["", said]
    return lines


def _us(scale: float, found: dict[str, float]) -> str:
    return f"{scale * found['median']:,.1f} us | {scale * found['worst']:,.1f} us"


def _mm(found: dict[str, float]) -> str:
    return f"{found['median']:.1e} | {found['worst']:.1e}"
