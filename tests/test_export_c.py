"""C99: every law has the same values in C, under a strict compiler and sanitizers."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import float64, types

from exported import SHAPED, VARIANTS, model_of
from stribeck import export
from stribeck.compile_cache import compiled as compiled_here
from stribeck.errors import InputError
from stribeck.export.code.c import MIN_AND_MAX, C, c
from stribeck.export.code.check_vectors import scale, walk
from stribeck.export.code.program import MATH_FUNCTIONS, Name
from stribeck.export.model import Model
from stribeck.friction import LAWS, LOADS, RUB_TYPE, SLIP_TYPE
from stribeck.rig.balanced import slips
from stribeck.space import Array

CC = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
CPP, CLANG, NM = (str(shutil.which(name) or "") for name in ("c++", "clang", "nm"))
pytestmark = pytest.mark.skipif(CC is None, reason="there is no C compiler here")

STRICT = (
    "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror",
)  # fmt: skip
CHECKED = ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
READ = types.Array(float64, 1, "C", readonly=True)
#: Numbers of a row for the driver, before the states: v, v_ref, h, loads.
INPUTS = 3 + len(LOADS)
RANDOM, WALK = 100_000, 10_000
#: Laws, and a Dahl law of either kind that its range has beside the exponent 1.
CASES = (*LAWS, *VARIANTS, "dahl, exponent 0.5", "dahl, exponent 2.5")


def model_in(case: str) -> Model:
    name, _, exponent = case.partition(", exponent ")
    model = model_of(name)
    if exponent:
        model.values[2] = float(exponent)
    return model


def compiled(folder: Path, *arguments: str) -> None:
    completed = subprocess.run(
        [str(CC), *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    assert completed.returncode == 0, completed.stderr


def at_once(calls: Sequence[Callable[[], object]]) -> None:
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for future in [pool.submit(call) for call in calls]:
            future.result()


def driver(models: Sequence[Model]) -> str:
    """A program that walks one of the laws through the rows of a file.

    Mode 0 goes on from row to row, mode 1 takes the states from each row, mode 2 is the self-test.
    A row out: friction, steady friction, compensation, states.
    """
    cases, names = [], range(len(models))
    for i, model in enumerate(models):
        law, n = model.law, model.law.states
        loaded = law.loads or law.terms
        cases.append(f"""
static void run_{i}(const double *in, double *out, int mode)
{{
    static l{i}_law law;
    static l{i}_compensator of;
    static int begun = 0;
    int j = 0;
    if (!begun) {{ l{i}_init(&law); l{i}_compensator_init(&of); begun = 1; }}
    {f"for (j = 0; j < {len(LOADS)}; j++) law.load[j] = of.law.load[j] = in[3 + j];" * bool(loaded)}
    {f"if (mode) for (j = 0; j < {n}; j++) law.z[j] = in[{INPUTS} + j];" * bool(n)}
    out[0] = l{i}_force(&law, in[0], in[2]);
    out[1] = l{i}_steady(&law, in[0]);
    out[2] = l{i}_compensate(&of, in[1], in[0], in[2]);
    {f"for (j = 0; j < {n}; j++) out[3 + j] = law.z[j];" * bool(n)}
    (void)j; (void)mode;
}}""")
    width = max(m.law.states for m in models)
    return "\n".join(
        [
            "#include <stdio.h>\n#include <stdlib.h>",
            *(f'#include "l{i}.h"\nint main_{i}(void);' for i in names),
            *cases,
            "typedef void (*run)(const double *, double *, int);",
            f"static const run runs[] = {{{', '.join(f'run_{i}' for i in names)}}};",
            f"static int (*const tests[])(void) = {{{', '.join(f'main_{i}' for i in names)}}};",
            f"""
int main(int argc, char **argv)
{{
    static double in[{INPUTS + width}], out[{3 + width}];
    int which = atoi(argv[1]), mode = atoi(argv[2]);
    (void)argc;
    if (mode == 2) return tests[which]();
    while (fread(in, sizeof in, 1, stdin) == 1) {{
        runs[which](in, out, mode);
        fwrite(out, sizeof out, 1, stdout);
    }}
    return 0;
}}
""",
        ]
    )


class Laws:
    """All laws in one program, compiled strictly and run under sanitizers."""

    def __init__(self, folder: Path) -> None:
        self.models = [model_in(case) for case in CASES]
        self.folder = folder
        calls: list[Callable[[], object]] = []
        for i, model in enumerate(self.models):
            for name, text in c(model, f"l{i}", SHAPED).items():
                (folder / (f"t{i}.c" if name == "selftest.c" else name)).write_bytes(text)
            calls.append(partial(compiled, folder, *STRICT, *CHECKED, "-c", f"l{i}.c"))
            test = (f"-Dmain=main_{i}", "-c", f"t{i}.c")
            calls.append(partial(compiled, folder, *STRICT, *test))
        (folder / "driver.c").write_text(driver(self.models))
        calls.append(partial(compiled, folder, "-std=c99", *CHECKED, "-c", "driver.c"))
        at_once(calls)
        objects = [f"{p}{i}.o" for i in range(len(self.models)) for p in "lt"]
        compiled(folder, *CHECKED, "driver.o", *objects, "-lm", "-o", "driver")
        self.width = max(m.law.states for m in self.models)

    def run(self, index: int, mode: int, rows: Array) -> Array:
        """The results of a law's C for rows of v, v_ref, h, loads and states."""
        full = np.zeros((len(rows), INPUTS + self.width))
        full[:, : rows.shape[1]] = rows
        completed = self.call(index, mode, full.tobytes())
        assert completed.returncode == 0, completed.stderr.decode()
        results: Array = np.frombuffer(completed.stdout).reshape(len(rows), -1)
        return results

    def call(self, index: int, mode: int, stdin: bytes) -> subprocess.CompletedProcess[bytes]:
        return subprocess.run(
            [str(self.folder / "driver"), str(index), str(mode)],
            input=stdin, capture_output=True, check=False,
        )  # fmt: skip


@pytest.fixture(scope="module")
def laws(tmp_path_factory: pytest.TempPathFactory) -> Laws:
    return Laws(tmp_path_factory.mktemp("c"))


def speeds(rng: np.random.Generator, n: int) -> Array:
    """Speeds of both signs from far below any that is measured to far above."""
    drawn: Array = rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(-12.0, 2.0, n)
    return drawn


def loads(rng: np.random.Generator, model: Model, n: int) -> Array:
    level = max(abs(x) for x in model.law.levels(model.p))
    drawn: Array = rng.uniform(-5.0, 5.0, (n, len(LOADS))) * np.array(
        [level, level, level, 0.2, 0.0]
    )
    drawn[:, LOADS.index("temperature")] = rng.uniform(270.0, 340.0, n)
    return drawn


def rows_of(rng: np.random.Generator, model: Model, n: int) -> Array:
    """v, v_ref, h, loads: rest, creeping, reversals, and motion as the reference has it."""
    v = speeds(rng, n)
    v[rng.random(n) < 0.1] = 0.0
    v[rng.random(n) < 0.01] = -0.0
    v_ref = np.where(rng.random(n) < 0.5, v, rng.uniform(-0.1, 0.1, n))
    h = 10.0 ** rng.uniform(-5.0, -1.0, n)
    return np.column_stack([v, v_ref, h, loads(rng, model, n)])


def off(computed: Array, expected: Array, floor: Array | float = 0.0) -> float:
    """The largest error relative to the expected value plus a floor."""
    assert np.isfinite(expected).all()
    return float(np.max(np.abs(computed - expected) / np.maximum(np.abs(expected) + floor, 1e-300)))


@pytest.mark.parametrize("index", range(len(CASES)), ids=CASES)
def test_steady_sliding_is_the_laws(laws: Laws, index: int) -> None:
    # Relative to the friction alone: no law takes a difference of large numbers here.
    model = laws.models[index]
    rng = np.random.default_rng(index)
    v, load = speeds(rng, RANDOM), loads(rng, model, RANDOM)
    rows = np.column_stack([v, v, np.full(RANDOM, 1e-3), load])
    expected = slips(model.law.slip, v, model.p)
    expected *= [scale(model, at) for at in load] if model.law.terms else 1.0
    assert off(laws.run(index, 0, rows)[:, 1], expected) <= 1e-12
    at_rest = laws.run(index, 0, np.array([[0.0, 0.0, 1.0], [-0.0, 0.0, 1.0]]))
    if not model.law.terms:
        np.testing.assert_allclose(at_rest[:, 1], model.law.levels(model.p)[::-1], rtol=1e-15)


@pytest.mark.parametrize("index", range(len(CASES)), ids=CASES)
def test_a_walk_is_the_laws_and_the_compensators(laws: Laws, index: int) -> None:
    # Relative to the force alone, although a bristle's force passes through zero.
    model = laws.models[index]
    tolerance = 1e-9 if model.law.states else 1e-12
    rows = rows_of(np.random.default_rng(100 + index), model, WALK)
    expected = walk(model, SHAPED, rows[:, :3], rows[:, 3:])
    results = laws.run(index, 0, rows)
    assert off(results[:, 0], expected.forces) <= tolerance
    assert off(results[:, 2], expected.outputs) <= tolerance


@compiled_here(float64[::1](SLIP_TYPE, float64[:, ::1], READ))
def slipped(slip: Any, rows: Array, p: Array) -> Array:
    """Friction of a law without states and loads at each row."""
    forces = np.empty(len(rows))
    for i in range(len(rows)):
        forces[i] = slip(rows[i, 0], p)
    return forces


@compiled_here(float64[::1](RUB_TYPE, float64[:, ::1], float64[:, ::1], READ, float64[:, ::1]))
def rubbed(rub: Any, rows: Array, z: Array, p: Array, after: Array) -> Array:
    """Friction of any other law at each row from states z, (n, k); fills their next, `after`."""
    forces = np.empty(len(rows))
    for i in range(len(rows)):
        forces[i] = rub(rows[i, 0], rows[i, 2], z[i], rows[i, 3:], p, after[i])
    return forces


@pytest.mark.parametrize("index", range(len(CASES)), ids=CASES)
def test_one_span_from_any_states_under_any_loads(laws: Laws, index: int) -> None:
    model = laws.models[index]
    law, n = model.law, model.law.states
    tolerance = 1e-9 if n else 1e-12
    rng = np.random.default_rng(200 + index)
    rows, z = rows_of(rng, model, RANDOM), states(rng, model, RANDOM)
    results = laws.run(index, 1, np.column_stack([rows, z]))
    after = np.zeros_like(z)
    if law.rub is None:
        expected = slipped(law.slip, rows, model.p)
    else:
        expected = rubbed(law.rub, rows, z, model.p, after)
    expected *= [scale(model, row[3:]) for row in rows] if law.terms else 1.0
    assert off(results[:, 0], expected) <= tolerance
    if n:
        assert off(results[:, 3 : 3 + n], after) <= tolerance


def states(rng: np.random.Generator, model: Model, n: int) -> Array:
    """States of a law as long walks leave them."""
    k = model.law.states
    z = rng.uniform(-1.0, 1.0, (n, k))
    if model.law.name.startswith("gms"):
        z[:, k // 2 :] = rng.integers(0, 2, (n, k - k // 2))
    elif k == 1:  # a deflection
        z *= 2.0 * max(abs(x) for x in model.law.levels(model.p)) / model.p[0]
    return z


@pytest.mark.parametrize("index", range(len(CASES)), ids=CASES)
def test_the_self_test_of_every_law_passes(laws: Laws, index: int) -> None:
    completed = laws.call(index, 2, b"")
    assert (completed.returncode, completed.stdout) == (0, b"0 of 256 rows differ\n")


@pytest.mark.parametrize("name", ["stribeck-free", "lugre", "bam-m4"])
def test_the_self_test_sees_any_parameter_that_is_off_by_a_millionth(
    tmp_path: Path, name: str
) -> None:
    files = c(model_of(name))
    lines = re.findall(rb"    law->p\[FRICTION_\w+\] = .*;", files["friction.c"])
    assert len(lines) == len(model_of(name).p)
    for file, text in files.items():
        (tmp_path / file).write_bytes(text)
    for i, line in enumerate(lines):
        spoilt = files["friction.c"].replace(line, line[:-1] + b" * 1.000001;")
        (tmp_path / f"f{i}.c").write_bytes(spoilt)
    at_once([
        partial(compiled, tmp_path, "-std=c99", f"f{i}.c", "selftest.c", "-lm", "-o", f"t{i}")
        for i in range(len(lines))
    ])  # fmt: skip
    for i, line in enumerate(lines):
        assert (
            subprocess.run([str(tmp_path / f"t{i}")], check=False, capture_output=True).returncode
            == 1
        ), line


def test_two_axes_do_not_share_their_states(tmp_path: Path) -> None:
    for name, text in c(model_of("lugre")).items():
        (tmp_path / name).write_bytes(text)
    (tmp_path / "two.c").write_text("""\
#include "friction.h"
#include <stdio.h>
int main(void)
{
    friction_law a, b, alone;
    friction_compensator of, other;
    int i;
    double F = 0.0, G = 0.0;
    friction_init(&a); friction_init(&b); friction_init(&alone);
    friction_compensator_init(&of); friction_compensator_init(&other);
    for (i = 0; i < 100; i++) {
        friction_force(&b, -0.01 * i, 1e-3);
        friction_compensate(&other, 0.02, -0.01 * i, 1e-3);
        F = friction_force(&a, 1e-5 * i, 1e-3);
        friction_compensate(&of, 1e-5 * i, 0.0, 1e-3);
    }
    for (i = 0; i < 100; i++) G = friction_force(&alone, 1e-5 * i, 1e-3);
    b.p[0] = 0.0;
    return !(F == G && a.z[0] == alone.z[0] && a.p[0] == alone.p[0]
             && of.law.z[0] != other.law.z[0]);
}
""")
    compiled(tmp_path, "-std=c99", "two.c", "friction.c", "-lm", "-o", "two")
    assert subprocess.run([str(tmp_path / "two")], check=False).returncode == 0


@pytest.mark.skipif(not NM, reason="there is no nm here")
@pytest.mark.parametrize("level", ["-O0", "-O2"])
def test_no_library_is_linked_but_that_of_math_h_and_nothing_is_allocated(
    laws: Laws, tmp_path: Path, level: str
) -> None:
    names = range(len(laws.models))
    at_once([
        partial(compiled, laws.folder, "-std=c99", level, "-fno-stack-protector", "-c",
                             f"l{i}.c", "-o", str(tmp_path / f"l{i}.o"))
        for i in names
    ])  # fmt: skip
    listed = subprocess.run(
        [NM, "-u", *(str(tmp_path / f"l{i}.o") for i in names)],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    linked = {name.lstrip("_") for name in re.findall(r"\bU (\S+)", listed)}
    mathematics = {"fabs" if name == "abs" else name for name in MATH_FUNCTIONS} - {"min", "max"}
    if "sincos" in linked:  # gcc makes one call of a sine and a cosine of the same angle
        linked |= {"sin", "cos"}
    allowed = {*mathematics, "sincos", "memcpy", "memset"}
    assert {"exp", "tanh", "log", "pow", "sin", "cos"} <= linked <= allowed


@pytest.mark.skipif(not CPP, reason="there is no C++ compiler here")
def test_headers_are_cpp_as_well(laws: Laws) -> None:
    names = range(len(laws.models))
    calls = "\n".join(
        f"    l{i}_law a{i}; l{i}_init(&a{i}); sum += l{i}_force(&a{i}, 0.01, 1e-3);" for i in names
    )
    includes = "\n".join(f'#include "l{i}.h"' for i in names)
    text = f"{includes}\nint main() {{ double sum = 0.0;\n{calls}\nreturn sum > 0.0 ? 0 : 1; }}\n"
    (laws.folder / "all.cpp").write_text(text)
    objects = [f"l{i}.o" for i in names]
    completed = subprocess.run(
        [CPP, "-Wall", "-Wextra", "-Wpedantic", "-Werror", *CHECKED, "all.cpp", *objects,
         "-o", "all"],
        cwd=laws.folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert completed.returncode == 0, completed.stderr
    assert subprocess.run([str(laws.folder / "all")], check=False).returncode == 0


@pytest.mark.skipif(not CLANG, reason="there is no clang here")
def test_clang_finds_nothing_either(laws: Laws) -> None:
    sources = [f"l{i}.c" for i in range(len(laws.models))]
    completed = subprocess.run(
        [CLANG, *STRICT, "-fsyntax-only", *sources],
        cwd=laws.folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert completed.returncode == 0, completed.stderr


@pytest.mark.parametrize("name", ["", "1st", "a b", "double", "x" * 42, "f\n"])
def test_a_name_that_c_does_not_take_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="C takes letters"):
        c(model_of("stribeck"), name)


@pytest.fixture(scope="module")
def mathematics(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Array]:
    """Calls a function that laws may call, as C calls it, over arrays."""
    folder = tmp_path_factory.mktemp("math")
    arguments = (Name("a", "real"), Name("b", "real"))
    cases = "\n".join(
        f"        case {i}: y = {C().call(name, arguments[:count])}; break;"
        for i, (name, count) in enumerate(MATH_FUNCTIONS.items())
    )
    (folder / "math.c").write_text(
        "#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n"
        + "\n".join(MIN_AND_MAX.values())
        + f"""
int main(int argc, char **argv)
{{
    double in[2];
    int which = atoi(argv[1]);
    (void)argc;
    while (fread(in, sizeof in, 1, stdin) == 1) {{
        double a = in[0], b = in[1], y = 0.0;
        (void)b;
        switch (which) {{
{cases}
        default: break;
        }}
        fwrite(&y, sizeof y, 1, stdout);
    }}
    return 0;
}}
"""
    )
    compiled(folder, *STRICT, *CHECKED, "math.c", "-lm", "-o", "math")

    def call(name: str, a: Array, b: Array | float = 0.0) -> Array:
        rows = np.column_stack(np.broadcast_arrays(a, b)).astype(float)
        completed = subprocess.run(
            [str(folder / "math"), str(list(MATH_FUNCTIONS).index(name))],
            input=rows.tobytes(), capture_output=True, check=False,
        )  # fmt: skip
        assert completed.returncode == 0, completed.stderr.decode()
        results: Array = np.frombuffer(completed.stdout)
        return results

    return call


#: Numbers on which mathematics goes wrong first.
EDGES = np.array([
    0.0, -0.0, 5e-324, -5e-324, 1e-310, 2.2250738585072014e-308, 1e-20, -1e-20, 0.25, -0.25, 0.5,
    -0.5, 1.0, -1.0, -1.0 + 2**-53, 2.0, -3.0, 1e5, 1e300, 1.7976931348623157e308, -1e300,
    np.inf, -np.inf, np.nan,
])  # fmt: skip


@pytest.mark.parametrize("name", MATH_FUNCTIONS)
def test_mathematics_is_right_where_numbers_end(
    mathematics: Callable[..., Array], name: str
) -> None:
    a, b = EDGES, np.zeros(len(EDGES))
    if MATH_FUNCTIONS[name] > 1:
        a, b = (grid.ravel() for grid in np.meshgrid(EDGES, EDGES))
    computed, expected = mathematics(name, a, b), in_python(name, a, b)
    np.testing.assert_allclose(computed, expected, rtol=1e-15)
    np.testing.assert_array_equal(
        np.signbit(computed[expected == 0.0]), np.signbit(expected[expected == 0.0])
    )


def in_python(name: str, a: Array, b: Array) -> Array:
    """The values of Python or numpy."""
    if name in ("min", "max"):
        extreme = min if name == "min" else max
        return np.array([extreme(x, y) for x, y in zip(a.tolist(), b.tolist(), strict=True)])
    function = getattr(np, {"pow": "power"}.get(name, name))
    with np.errstate(all="ignore"):
        values: Array = function(a, *[b] * (MATH_FUNCTIONS[name] - 1))
    return values


def test_the_head_says_what_friction_is_added_to() -> None:
    assert "add it to the force that is asked of the drive" in "\n".join(model_of("lugre").head())
    servo = model_of("bam-m4")  # on a rig whose drive takes volts
    values = {q.name: v for q, v in zip(servo.parameters.every, servo.values, strict=True)}
    head = "\n".join(servo.head())
    assert "add it to the torque that is asked of the drive" in head
    assert f"takes volts: {values['R'] / values['k_t']:.4g} V for a N m" in head


def test_an_export_shows_its_files_and_no_bytes() -> None:
    shown = repr(export(model_of("stribeck"), "c"))
    sizes = re.findall(r"([\w.]+), ([\d,]+) bytes", shown)
    assert {name for name, _ in sizes} == {"friction.c", "friction.h", "selftest.c"}
    assert "\\" not in shown
    assert len(shown) < 200
