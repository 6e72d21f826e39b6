"""Candidates of the slide bed on a GPU and on the processor, where there is a GPU.

One ramp of 36.6 s at 100 Hz, parameter sets uniform in the search box, 10^3 to 10^6 of them a call;
everything that a call costs is in its time, copies to the device and back as well.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from kernel import LAW, least, ramp
from stribeck.rig import crew, cuda
from stribeck.rig.drive import Drive
from stribeck.rig.kernel import misfits, trajectories
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from stribeck.rig.track import Track, track

SIZES = (1_000, 10_000, 100_000, 1_000_000)
#: The least of so many timings counts: another program can only make one longer.
TIMES = 3
NOISE = 3e-4


def measure(quick: bool = False) -> dict[str, Any]:
    """Seconds a call of both, and how far apart what they find is; or why there is no GPU."""
    if why := cuda.missing():
        return {"missing": why}
    on, sizes = recorded(), SIZES[:-1] if quick else SIZES
    p, c = SLIDE_BED.split(LAW, SLIDE_BED.sample(LAW, np.random.default_rng(2013), max(sizes)))
    p, c = np.ascontiguousarray(p), np.ascontiguousarray(c)
    compiling = wall(lambda: cuda.misfits(LAW, p[:1], c[:1], on), 1)
    found: dict[str, Any] = {
        "device": _device(),
        "threads": crew.threads(),
        "compile_s": compiling,
        "candidates": {},
    }
    for n in sizes:
        sets = LAW, p[:n], c[:n], on
        here, there = misfits(*sets), cuda.misfits(*sets)
        found["candidates"][str(n)] = {
            "cpu_s": wall(lambda a=sets: misfits(*a)),  # type: ignore[misc]
            "gpu_s": wall(lambda a=sets: cuda.misfits(*a)),  # type: ignore[misc]
            "apart": float(np.nanmax(np.abs(there / here - 1))),
            "same_nan": bool((np.isnan(here) == np.isnan(there)).all()),
        }
    return found


def recorded() -> Track:
    """The ramp as the paper's parameter set runs through it, with noise."""
    on = ramp(1)
    x, _ = trajectories(LAW, *SLIDE_BED.split(LAW, PUBLISHED["right"]), on)
    noisy = x[0] + NOISE * np.random.default_rng(2013).standard_normal(len(on.t))
    return track(Drive(on.knots_t, on.knots_x), on.t, on.x0, noisy)


def wall(work: Callable[[], object], times: int = TIMES) -> float:
    """The least time that some work takes by the clock on the wall, s: others do it, too."""
    return least(work, times, time.perf_counter)


def _device() -> str:
    from numba import cuda as target  # noqa: PLC0415 - only where there is a device

    name = getattr(target.get_current_device(), "name", "numba's simulator")
    return name.decode() if isinstance(name, bytes) else str(name)


def tables(found: dict[str, Any]) -> list[str]:
    """What was found as Markdown, a line a line."""
    if "missing" in found:
        return [f"Not measured: no GPU at hand ({found['missing']})."]
    lines = [
        f"{found['device']} beside {found['threads']} threads of the processor.",
        f"A law is compiled once a process, in {found['compile_s']:.1f} s.",
        "",
        "| candidates a call | processor / s | GPU / s | ratio | apart, relative |",
        "|---:|---:|---:|---:|---:|",
    ]
    for n, one in found["candidates"].items():
        lines.append(
            f"| {int(n):,} | {one['cpu_s']:.3g} | {one['gpu_s']:.3g} "
            f"| {one['cpu_s'] / one['gpu_s']:.1f} | {one['apart']:.1e} |"
        )
    return lines
