"""The same integrator on a GPU, one thread a candidate: for 10^5 candidates a call and more.

There is no second copy of the physics: `kernel._walk`, what it calls and the law are compiled again
for CUDA from the functions they are on the processor, a program a law.

Sums of squares are the processor's within 1e-9 relative where a slide sticks and slips (in all but
3 of 16,000 runs, 5e-8 at worst), not bit for bit: CUDA's `exp` and `pow` round otherwise, and it
fuses other products into sums. Two things make more of such rounding. A misfit that is next to
nothing beside the motion is a difference of large sums, 1e-15 of the sum of squared displacements
off on either machine. And a slide that goes on without sticking, as under Coulomb friction, goes in
the longest steps that are stable; these carry
rounding up towards the tolerance: 2e-6 relative at worst, as much as the last digit of a parameter
does on the processor.

Needs `pip install 'stribeck[gpu]'` and an NVIDIA driver. It is imported by whoever asks for a GPU.
"""

from __future__ import annotations

import math
from functools import cache
from importlib.util import find_spec
from types import CellType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import config, float64, void
from numba.core.dispatcher import Dispatcher

from ..errors import InputError
from ..space import Array
from . import kernel

try:
    from numba import cuda
except ImportError:  # a numba without the target of its own that numba-cuda replaces
    cuda = None

if TYPE_CHECKING:
    from ..friction import Law
    from .track import Track

#: Threads of a block: a warp, as candidates differ in cost and share nothing.
THREADS = 32
#: Fewest blocks of a launch; numba warns of fewer, and a thread without a candidate costs nothing.
FEWEST = 128
#: Most candidates of a launch: what they take of the device's memory is then below 32 MiB, beside
#: the track and, for each thread that the device keeps in flight, 9 KiB for the path of a slip.
CHUNK = 1 << 17

_A1, _A2 = float64[::1], float64[:, ::1]
#: Parameters, constants, the track, an empty array for the trajectories that are not stored, the
#: sums of squares, the tolerance.
SIGNATURE = void(_A2, _A2, _A1, _A1, _A2, _A1, float64, _A1, _A1, _A2, _A1, _A1, float64)

#: numpy as CUDA knows it: it has the scalar functions of `math`, and not all of numpy's.
_NUMPY = ModuleType("numpy")
vars(_NUMPY).update({**vars(np), **vars(math)})


def missing() -> str | None:
    """Why nothing can be computed on a GPU here, in a line; None where it can."""
    simulated = config.ENABLE_CUDASIM  # numba's own simulator of a device, for tests
    if cuda is None or (not simulated and find_spec("numba_cuda") is None):
        return "numba-cuda is not installed: pip install 'stribeck[gpu]'"
    if cuda.is_available():
        return None
    said = str(cuda.cuda_error() or "").strip().partition("\n")[0]
    return said.rstrip(".:") or "the CUDA toolkit was not found: pip install 'stribeck[gpu]'"


def ready() -> None:
    """Nothing, where there is a GPU to compute on.

    Raises:
        InputError: there is none, with the reason.
    """
    if why := missing():
        raise InputError(f"device cuda: {why}; without a GPU use device cpu")


def misfits(law: Law, p: Array, c: Array, on: Track, tolerance: float = 1.0) -> Array:
    """Sums of squared position misfits, m^2, (n,): `kernel.misfits`, computed on the GPU.

    Args:
        law: Any law that numba can compile for CUDA, too: scalar arithmetic, `math`.
        p: (n, k) parameters of the law.
        c: (n, 10) constants.
        on: The track.
        tolerance: Scales the error allowed in a step.

    Raises:
        InputError: there is no GPU to compute on, or the law cannot be compiled for it.
    """
    ready()
    run = _compiled(law)
    p, c = (np.ascontiguousarray(a, dtype=float) for a in (p, c))
    on = kernel.from_zero(on)
    knots_t, knots_x, extremes, t, measured, score, sums, nothing = (
        cuda.to_device(np.ascontiguousarray(a, dtype=float))
        for a in (on.knots_t, on.knots_x, on.extremes, on.t, on.measured, on.score, on.sums, ())
    )
    sse = np.empty(len(p))
    for begin in range(0, len(p), CHUNK):
        part = slice(begin, begin + CHUNK)
        found = cuda.device_array(len(sse[part]))
        blocks = max(FEWEST, -(-len(found) // THREADS))
        run[blocks, THREADS](
            cuda.to_device(p[part]), cuda.to_device(c[part]), knots_t, knots_x, extremes, t,
            float(on.x0), measured, score, sums, nothing, found, tolerance,
        )  # fmt: skip
        sse[part] = found.copy_to_host()
    return sse


def candidate(slip: Any) -> FunctionType:
    """The program of a thread under a law: its candidate's sum of squares.

    Args:
        slip: The compiled law; its source is what is compiled for CUDA.
    """
    made: dict[Any, Any] = {}
    walk, law = _on_device(kernel._walk, made), _on_device(slip, made)  # noqa: SLF001 - its twin
    rows, columns = kernel.LEG, kernel.WIDTH

    def program(
        p: Any, c: Any, knots_t: Any, knots_x: Any, extremes: Any, t: Any, x0: Any,
        measured: Any, score: Any, sums: Any, nothing: Any, sse: Any, tolerance: Any,
    ) -> None:  # fmt: skip
        row = cuda.grid(1)
        if row < len(p):
            path = cuda.local.array((rows, columns), float64)
            sse[row] = walk(
                law, p[row], c[row], knots_t, knots_x, extremes, t, x0, measured, score, sums,
                nothing, nothing, False, tolerance, path,
            )  # fmt: skip

    return program  # type: ignore[return-value]


def _compiled(law: Law) -> Any:
    if not isinstance(law.slip, Dispatcher):
        raise InputError(
            f"law {law.name}: device cuda compiles a law from its source, and this one is no "
            "function that numba has compiled (see slip_law); use device cpu"
        )
    if not (law.static and law.sticks):
        raise InputError(
            f"law {law.name}: device cuda takes static laws that stick at rest; use device cpu"
        )
    try:
        return _program(law.slip)
    except Exception as error:  # numba's errors have no common ancestor across its packages
        said = next((x for x in str(error).splitlines() if x.strip()), type(error).__name__)
        raise InputError(
            f"law {law.name} cannot be compiled for CUDA: {said}; use device cpu"
        ) from error


@cache
def _program(slip: Any) -> Any:
    return cuda.jit(SIGNATURE)(candidate(slip))


def _on_device(compiled: Dispatcher, made: dict[Any, Any]) -> Any:
    """A function of the processor, and all it calls, as functions of the device.

    The code is the same; what its names stand for is not. A function with one signature of its own
    cannot be called on a device, nor one that allows itself fast mathematics: CUDA takes any of
    that as leave to divide inexactly.

    Args:
        compiled: The function.
        made: Those that have been translated; grows.
    """
    own = compiled.py_func
    if own not in made:

        def stands_for(value: Any) -> Any:
            if value is np:
                return _NUMPY
            return _on_device(value, made) if isinstance(value, Dispatcher) else value

        names: dict[str, Any] = {"__name__": own.__module__}
        cells = tuple(CellType(stands_for(x.cell_contents)) for x in own.__closure__ or ())
        twin = FunctionType(own.__code__, names, own.__name__, own.__defaults__, cells)
        made[own] = cuda.jit(device=True)(twin)
        for name in own.__code__.co_names:
            if name in own.__globals__:
                names[name] = stands_for(own.__globals__[name])
    return made[own]
