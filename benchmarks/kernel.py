"""One candidate of the slide bed: C in fixed steps, SciPy, the plain reference and the kernel.

Everything runs in this one process on one thread, the same equations on the same parameter sets,
and each is compared with one converged motion: the kernel at a ten-thousandth of its tolerance,
itself checked against the reference extrapolated to a step of zero.
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
from stribeck.rig.motion.drives import BAND, IMPULSE
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
    """The ramp of the paper's section 4.5, from the start of its identification."""
    t = np.arange(round(SECONDS * RATE) + 1) / RATE
    x0 = 0.112 if direction > 0 else 0.325
    return track(Drive.line(0.0, x0, SECONDS, direction * SPEED), t, x0)


def uneven(direction: int) -> Track:
    """A ramp whose speed changes every second, so that no slip repeats the last."""
    stroke = ramp(direction)
    knots = np.arange(0.0, SECONDS + 1.0)
    speed = direction * SPEED * (1.0 + 0.2 * np.sin(2.0 * knots[:-1]))
    x = stroke.x0 + np.append(0.0, np.cumsum(speed))
    return track(Drive(knots, x), stroke.t, stroke.x0)


def rms(x: Array, y: Array) -> Array:
    """The distance of two motions, mm RMS, by row."""
    return 1e3 * np.sqrt(np.mean((x - y) ** 2, axis=-1))  # type: ignore[no-any-return]


def least(
    work: Callable[[], object],
    times: int = TIMES,
    clock: Callable[[], float] = time.thread_time,
) -> float:
    """The least time of several runs of some work, s; by default processor time of this thread."""
    times_taken = []
    for _ in range(times):
        start_time = clock()
        work()
        times_taken.append(clock() - start_time)
    return min(times_taken)


@contextmanager
def with_pool(pool: row_pool.RowPool) -> Iterator[None]:
    """The kernel with a given pool of threads instead of its own."""
    allocator = row_pool.pool
    row_pool.pool = lambda: pool
    try:
        yield
    finally:
        row_pool.pool = allocator


class CLoop:
    """The fixed-step loop of slide_bed.c."""

    def __init__(self, folder: Path) -> None:
        library = folder / "slide_bed.so"
        command = ["gcc", *FLAGS, "-o", str(library), str(SOURCE), "-lm"]
        subprocess.run(command, check=True, capture_output=True)  # noqa: S603 - no outside text
        self.function = ctypes.CDLL(str(library)).slide_bed
        self.function.restype = ctypes.c_double

    def run(self, p: Array, c: Array, stroke: Track, dt: float, positions: Array | None) -> float:
        """Simulate one set and fill `positions`; the sum of squared errors."""

        def pointer(a: Array) -> Any:
            return a.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

        return float(
            self.function(
                pointer(p), pointer(c), pointer(stroke.knots_t), pointer(stroke.knots_x),
                ctypes.c_long(len(stroke.knots_t)), ctypes.c_double(stroke.x0),
                ctypes.c_long(len(stroke.t)), ctypes.c_double(RATE), ctypes.c_double(dt),
                pointer(stroke.measured),
                None if positions is None else pointer(positions),
            )
        )  # fmt: skip


def scipy_motion(p: Array, c: Array, stroke: Track) -> Array:
    """Positions by SciPy's solve_ivp (LSODA) with events, piece by piece of stick and slip."""
    band, level = c[BAND], float(LAW.slip(0.0, p))
    rate = (stroke.knots_x[1] - stroke.knots_x[0]) / (stroke.knots_t[1] - stroke.knots_t[0])
    s = float(np.sign(rate))

    def command(t: float) -> float:
        return float(stroke.knots_x[0] + rate * (t - stroke.knots_t[0]))

    # The momentum in its dead band.
    def sticking(t: float, y: Array) -> list[float]:
        F = reference.drive(c, command(t) - y[1])
        return [F - min(max(F, -level), level), 0.0]

    def slipping(t: float, y: Array) -> list[float]:
        a = reference.acceleration(LAW.slip, p, c, command(t) - y[1], y[0], s)
        return [a, y[0]]

    def loose(_: float, y: Array) -> float:
        return float(abs(y[0]) - c[IMPULSE])

    def standstill(_: float, y: Array) -> float:
        return float(s * y[0] - band)

    loose.terminal = standstill.terminal = True  # type: ignore[attr-defined]
    loose.direction, standstill.direction = 1.0, -1.0  # type: ignore[attr-defined]
    x = np.full(len(stroke.t), np.nan)
    reached, at, end = 0.0, stroke.x0, float(stroke.t[-1])
    while reached < end:
        reach = (level + c[5]) / ((c[1] + c[3]) if s > 0 else (c[2] + c[4]))
        edge = min(end, max(reached, (at + s * reach - stroke.knots_x[0]) / rate))
        stick_start, state = reached, [0.0, at]
        if edge < end:
            piece = solve_ivp(
                sticking, (edge, end), state, "LSODA", events=loose, rtol=1e-8, atol=1e-10
            )
            edge = float(piece.t[-1])
        x[(stroke.t >= stick_start) & (stroke.t <= edge)] = at
        reached = edge
        if reached >= end:
            break
        piece = solve_ivp(
            slipping, (reached, end), [s * band, at], "LSODA", dense_output=True, events=standstill,
            rtol=1e-7, atol=1e-9, max_step=0.05,
        )  # fmt: skip
        rows = (stroke.t > reached) & (stroke.t <= piece.t[-1])
        x[rows] = piece.sol(stroke.t[rows])[1]  # type: ignore[misc]
        reached, at = float(piece.t[-1]), float(piece.y[1, -1])
    return x


def richardson(p: Array, c: Array, stroke: Track, dt: float) -> Array:
    """The reference at a step of zero, from two steps and its second order."""
    coarse, _ = reference.trajectory(LAW, p, c, stroke, dt)
    finer, _ = reference.trajectory(LAW, p, c, stroke, 0.5 * dt)
    return finer + (finer - coarse) / 3.0


def spread(values: Array) -> dict[str, float]:
    """Median and worst."""
    return {"median": float(np.median(values)), "worst": float(np.max(values))}


def seconds_each(p: Array, c: Array, stroke: Track, tolerance: float) -> Array:
    """The kernel's seconds for each set, each after all others: no learnt branches.

    Each is a call by itself, less the time of a call that ends at once, for a mass of zero.
    """
    rows = [(p[k : k + 1], c[k : k + 1]) for k in range(len(p))]
    empty = np.zeros_like(c[:1])
    seconds, nothing = np.full((2, len(p)), np.inf)
    for _ in range(TIMES):
        for k, (q, d) in enumerate(rows):
            start_time = time.thread_time()
            misfits(LAW, q, d, stroke, tolerance)
            middle_time = time.thread_time()
            misfits(LAW, q, empty, stroke, tolerance)
            nothing[k] = min(nothing[k], time.thread_time() - middle_time)
            seconds[k] = min(seconds[k], middle_time - start_time)
    return seconds - float(np.median(nothing))


def direction_results(
    direction: int, n: int, n_reference: int, loop: CLoop | None
) -> dict[str, Any]:
    """One direction of the ramp: errors and times of kernel and C loop, and their ratios by set."""
    stroke = ramp(direction)
    p, c = SLIDE_BED.split(LAW, SLIDE_BED.sample(LAW, np.random.default_rng(2012 + direction), n))
    p, c = np.ascontiguousarray(p), np.ascontiguousarray(c)
    converged, _ = trajectories(LAW, p, c, stroke, CONVERGED)
    some = range(0, n, max(1, n // n_reference))
    exact = np.array([richardson(p[k], c[k], stroke, 1e-5) for k in some])
    results: dict[str, Any] = {
        "sets": n,
        "converged_from_extrapolated_reference_mm": spread(rms(converged[list(some)], exact)),
    }
    for accuracy, (tolerance, dt) in ACCURACIES.items():
        x, _ = trajectories(LAW, p, c, stroke, tolerance)
        whole = least(lambda s=tolerance: misfits(LAW, p, c, stroke, s)) / n  # type: ignore[misc]
        kernel_seconds = seconds_each(p, c, stroke, tolerance)
        row: dict[str, Any] = {
            "tolerance": tolerance,
            "kernel_error_mm": spread(rms(x, converged)),
            "kernel_us": spread(1e6 * kernel_seconds) | {"in_one_call": 1e6 * whole},
        }
        if loop is not None:
            picked = range(0, n, max(1, n // (10 * n_reference)))
            positions = np.empty(len(stroke.t))
            seconds, error = [], []
            for k in picked:
                seconds.append(least(lambda k=k, dt=dt: loop.run(p[k], c[k], stroke, dt, None), 2))  # type: ignore[misc]
                loop.run(p[k], c[k], stroke, dt, positions)
                error.append(rms(positions, converged[k]))
            c_ms, kernel = 1e3 * np.array(seconds), 1e3 * kernel_seconds[list(picked)]
            row |= {
                "c_step_s": dt,
                "c_sets": len(seconds),
                "c_ms": spread(c_ms),
                "c_error_mm": spread(np.array(error)),
                "c_over_kernel": {
                    "median": float(np.median(c_ms / kernel)),
                    "worst": float(np.min(c_ms / kernel)),
                    "median_c_over_worst_kernel": float(
                        np.median(c_ms) / (1e3 * kernel_seconds).max()
                    ),
                },
            }
        results[accuracy] = row
    results["others"] = other_simulators(p, c, stroke, converged, list(some)[: min(3, n_reference)])
    return results


def other_simulators(
    p: Array, c: Array, stroke: Track, converged: Array, sets: list[int]
) -> dict[str, Any]:
    """SciPy and the reference, on a few sets."""
    results: dict[str, Any] = {}
    reference.trajectory(LAW, p[0], c[0], stroke, 1e-3)  # compiled
    roads: dict[str, Callable[[int], Array]] = {
        "scipy solve_ivp, LSODA with events": lambda k: scipy_motion(p[k], c[k], stroke),
        "reference, step 2e-5 s": lambda k: reference.trajectory(LAW, p[k], c[k], stroke, 2e-5)[0],
    }
    for name, road in roads.items():
        seconds, error = [], []
        for k in sets:
            start_time = time.thread_time()
            x = road(k)
            seconds.append(time.thread_time() - start_time)
            error.append(rms(x, converged[k]))
        results[name] = {
            "sets": len(sets),
            "ms": spread(1e3 * np.array(seconds)),
            "error_mm": spread(np.array(error)),
        }
    return results


def uneven_results(n: int) -> dict[str, Any]:
    """A command under which no slip repeats: each has to be integrated."""
    stroke = uneven(1)
    p, c = SLIDE_BED.split(LAW, SLIDE_BED.sample(LAW, np.random.default_rng(2013), n))
    converged, _ = trajectories(LAW, p, c, stroke, CONVERGED)
    results: dict[str, Any] = {"sets": n}
    for accuracy, (tolerance, _) in ACCURACIES.items():
        x, _ = trajectories(LAW, p, c, stroke, tolerance)
        results[accuracy] = {
            "kernel_us": 1e6 * least(lambda s=tolerance: misfits(LAW, p, c, stroke, s)) / n,  # type: ignore[misc]
            "kernel_error_mm": spread(rms(x, converged)),
        }
    return results


def thread_results(turns: int) -> dict[str, Any]:
    """Throughput of one and of two threads, at calls of a search and at large ones, alternating."""
    stroke = ramp(1)
    if row_pool.threads() < 2:  # noqa: PLR2004
        return {"cores": row_pool.threads()}
    pools = {1: row_pool.RowPool(1), 2: row_pool.RowPool(2)}
    results: dict[str, Any] = {"cores": row_pool.threads(), "same_bits": True, "calls": {}}
    for candidates, in_a_turn in ((CALL, 20), (100 * CALL, 1)):
        at = SLIDE_BED.sample(LAW, np.random.default_rng(7), candidates)
        seconds: dict[int, list[float]] = {1: [], 2: []}
        for _ in range(turns if candidates == CALL else max(turns // 20, 2)):
            bits = set()
            for n, medians in seconds.items():
                with with_pool(pools[n]):
                    some = []
                    for _ in range(in_a_turn):
                        start_time = time.perf_counter()
                        sse = SLIDE_BED.misfits(LAW, at, (stroke,))
                        some.append(time.perf_counter() - start_time)
                medians.append(float(np.median(some)))
                bits.add(sse.tobytes())
            results["same_bits"] &= len(bits) == 1
        single, two = np.array(seconds[1]), np.array(seconds[2])
        results["calls"][str(candidates)] = {
            "one_thread_us": 1e6 * float(single.min()),
            "two_threads_us": 1e6 * float(two.min()),
            "gain": {
                "median": float(np.median(single / two)),
                "of_least": float(single.min() / two.min()),
            },
        }
    pools[2].dismiss()
    return results


def measure(quick: bool = False) -> dict[str, Any]:
    """All results, as JSON; `quick` takes few sets, to see that it runs."""
    n, n_reference = (40, 2) if quick else (1000, 10)
    with tempfile.TemporaryDirectory() as folder, with_pool(row_pool.RowPool(1)):
        loop = CLoop(Path(folder)) if shutil.which("gcc") else None
        results: dict[str, Any] = {
            "ramp": {"seconds": SECONDS, "rate_hz": RATE, "speed_mm_s": 1e3 * SPEED},
            "c": " ".join(("gcc", *FLAGS)) if loop else "gcc is not there: no C figures",
            "right": direction_results(1, n, n_reference, loop),
            "left": direction_results(-1, n, n_reference, loop),
            "no slip repeats": uneven_results(n),
        }
    results["threads"] = thread_results(20 if quick else 200)
    return results


def tables(results: dict[str, Any]) -> list[str]:
    """The results as lines of Markdown."""
    lines = [
        "| ramp | accuracy | who | median | worst | error, median / mm | error, worst / mm |",
        "|---|---|---|---|---|---|---|",
    ]
    for direction in ("right", "left"):
        for accuracy in ACCURACIES:
            row, begin = results[direction][accuracy], f"| {direction} | {accuracy} |"
            if "c_ms" in row:
                lines.append(
                    f"{begin} C, step {row['c_step_s']:g} s | {_us(1e3, row['c_ms'])} "
                    f"| {_mm(row['c_error_mm'])} |"
                )
            lines.append(
                f"{begin} kernel | {_us(1.0, row['kernel_us'])} | {_mm(row['kernel_error_mm'])} |"
            )
            if "c_over_kernel" in row:
                ratio = row["c_over_kernel"]
                lines.append(
                    f"{begin} C over kernel | {ratio['median']:.0f} | {ratio['worst']:.0f} | | |"
                )
        for name, row in results[direction]["others"].items():
            lines.append(
                f"| {direction} | | {name} | {_us(1e3, row['ms'])} | {_mm(row['error_mm'])} |"
            )
    for accuracy in ACCURACIES:
        row = results["no slip repeats"][accuracy]
        lines.append(
            f"| uneven | {accuracy} | kernel, each slip a new one | {row['kernel_us']:.1f} us | "
            f"| {_mm(row['kernel_error_mm'])} |"
        )
    threads = results["threads"]
    if threads["cores"] < 2:  # noqa: PLR2004
        return lines
    bits = "the same bits" if threads["same_bits"] else "OTHER BITS"
    for candidates, row in threads["calls"].items():
        gain = row["gain"]
        speedup = (
            f"Two threads do {gain['median']:.2f} times as much as one with {int(candidates):,} "
            f"candidates a call (median of turns; {gain['of_least']:.2f} by the least times), "
            f"{bits}."
        )
        lines += ["", speedup]
    return lines


def _us(scale: float, times: dict[str, float]) -> str:
    return f"{scale * times['median']:,.1f} us | {scale * times['worst']:,.1f} us"


def _mm(errors: dict[str, float]) -> str:
    return f"{errors['median']:.1e} | {errors['worst']:.1e}"
