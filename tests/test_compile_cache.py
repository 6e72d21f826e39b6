"""The compile cache: never out of date, private, and in a folder that can be written."""

from __future__ import annotations

import json
import logging
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import config, float64, njit, typeof

import stribeck
from stribeck.cli.notices import notices
from stribeck.compile_cache import cache_folder, compiled
from stribeck.compile_cache.cache_folder import Folder
from stribeck.compile_cache.content import UnknownContentError, digest

PACKAGE = Path(stribeck.__file__).parent


def python(code: str, *arguments: str, path: Path, **environment: str) -> str:
    """The output of a program in another process, with modules from a folder."""
    completed = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(path), **environment}, cwd=path,
    )  # fmt: skip
    assert completed.returncode == 0, completed.stderr
    return completed.stdout + completed.stderr


# --- nothing is out of date -----------------------------------------------------------------------

_LOOP = """
import sys
import numpy as np
from stribeck.compensate.closed_loop import Reference, compensated
from stribeck.compensate.compensator import Compensator
from stribeck.friction import LAWS
from stribeck.rig import RIGS

rig, law = RIGS["joint"], LAWS["stribeck"]
values = {"F_C": 1.5, "F_S": 2.5, "F_V": 2.0, "v_SS": 0.05, "J": 0.3, "g_sin": 0.8, "g_cos": 0.4,
          "g_0": 0.0}
values |= {name: float(sys.argv[1]) * values[name] for name in ("g_sin", "g_cos")}
p = np.array([values.get(q.name, q.fixed) for q in rig.parameters(law)], dtype=float)
t = np.arange(0.0, 1.0, 1e-3)
reference = Reference("ramp", t, 0.2 * np.minimum(t, 0.7))
moved = compensated(rig, law, p[None], reference, [Compensator(scale=0.0)], (law, p))
print(repr(float(moved.position[0, -1])))
"""


def test_an_edit_of_the_physics_in_another_file_changes_the_closed_loop(tmp_path: Path) -> None:
    shutil.copytree(
        PACKAGE, tmp_path / "stribeck", ignore=shutil.ignore_patterns("__pycache__", "*.nb?")
    )
    before, heavier = (python(_LOOP, factor, path=tmp_path) for factor in ("1", "32"))
    assert before != heavier
    part = tmp_path / "stribeck" / "rig" / "parts" / "loads.py"
    text, count = re.subn(
        r"s, o = (sin\(q \+ c\[2\]\)), (cos\(q \+ c\[2\]\))",
        r"s, o = 32.0 * \1, 32.0 * \2",
        part.read_text(encoding="utf-8"),
    )
    assert count == 1
    part.write_text(text, encoding="utf-8")
    assert python(_LOOP, "1", path=tmp_path) == heavier  # to the last digit


_TWO_FUNCTIONS = """
import numpy as np
from stribeck.compile_cache import tally
from stribeck.friction import slip_law
import shapes
from shapes import saw

@slip_law
def slip(v, p):
    return p[0] * saw(v) + shapes.LEVEL

print(slip(0.5, np.array([1.0])), tally.compiled)
"""
_SHAPES = """
from numba import njit

LEVEL = {level}
WIDTH = {width}

@njit
def saw(v):
    return min(v, WIDTH)
"""


def test_a_law_of_ones_own_follows_its_helpers_in_other_files(tmp_path: Path) -> None:
    printed = []
    for width, level in ((0.25, 0.0), (0.25, 0.0), (0.125, 0.0), (0.125, 2.0), (0.25, 0.0)):
        text = _SHAPES.format(width=width, level=level)
        (tmp_path / "shapes.py").write_text(text, encoding="utf-8")
        path = f"{tmp_path}{os.pathsep}{PACKAGE.parent}"
        variables = {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
        printed.append(python(_TWO_FUNCTIONS, path=tmp_path, PYTHONPATH=path, **variables))
    force = [float(line.split()[0]) for line in printed]
    assert force == [0.25, 0.25, 0.125, 2.125, 0.25]
    # What helps to import the package is compiled with the first; then only what is new.
    assert [int(line.split()[1]) for line in printed[1:]] == [0, 1, 1, 0]


def function_of(source: str, name: str = "f", **names: Any) -> Any:
    space: dict[str, Any] = {"compiled": compiled, "njit": njit, "np": np, **names}
    exec(source, space)  # noqa: S102 - as at a prompt
    return space[name]


def content(source: str, **names: Any) -> str:
    return digest(function_of(source, **names), (float64,))


_CALLS = "@njit\ndef g(x):\n    return {0} * x\n@compiled()\ndef f(x):\n    return g(x) + {1}\n"


def test_content_is_that_of_all_that_is_compiled_in() -> None:
    plain = content(_CALLS.format("2.0", "1.0"))
    assert content("\n# a comment\n" + _CALLS.format("2.0", "1.0")) == plain
    assert content(_CALLS.format("3.0", "1.0")) != plain
    assert content(_CALLS.format("2.0", "-0.0")) != content(_CALLS.format("2.0", "0.0"))
    assert content(_CALLS.format("2.0", "1.0").replace("@njit", "@njit(fastmath=True)")) != plain
    assert content(_CALLS.format("2.0", "1.0").replace("()", "(forceinline=True)")) != plain


@pytest.mark.parametrize(
    ("value", "changed"),
    [
        (1, 2), (1, 1.0), (0.0, -0.0), (True, 1), ((1, 2), (1, (2,))), ("a", b"a"),
        (np.array([1.0, 2.0]), np.array([1.0, 3.0])), (np.zeros((2, 3)), np.zeros((3, 2))),
        (np.float32(1), np.float64(1)), (np.sin, np.cos), (min, max), (float64, float64[:]),
        (frozenset({1, 2}), frozenset({1, 3})), ({"a": 1}, {"a": 2}),
    ],
    ids=repr,
)  # fmt: skip
def test_values_of_globals_are_content(value: Any, changed: Any) -> None:
    source = "@compiled()\ndef f(x):\n    return K\n"
    assert content(source, K=value) == content(source, K=value)
    assert content(source, K=value) != content(source, K=changed)


def test_closures_defaults_and_functions_inside_are_content() -> None:
    factory = "def make(k):\n    @compiled()\n    def f(x):\n        return k * x\n    return f\n"
    two, three = (digest(function_of(factory + f"f = make({k})"), ()) for k in (2, 3))
    assert two != three
    inside = (
        "@compiled()\ndef f(x, y={0}):\n    def g(z):\n        return z + {1}\n    return g(x)\n"
    )
    assert len({content(inside.format(*k)) for k in ((1, 2), (1, 3), (2, 2))}) == 3


def test_functions_that_call_each_other_are_content_of_either() -> None:
    pair = ("@njit\ndef g(x):\n    return f(x - 1) if x > 0 else {0}\n"
            "@compiled()\ndef f(x):\n    return g(x - 1) if x > 0 else {1}\n")  # fmt: skip
    for name in ("f", "g"):
        contents = {
            digest(function_of(pair.format(*k), name), ()) for k in ((1, 2), (3, 2), (1, 4))
        }
        assert len(contents) == 3


class Gains(NamedTuple):
    k: float
    d: float


class Swapped(NamedTuple):
    d: float
    k: float


def test_order_of_named_fields_is_content() -> None:
    Swapped.__name__ = Gains.__name__
    source = "@compiled()\ndef f(x):\n    return x.k\n"
    types = typeof(Gains(1.0, 2.0)), typeof(Swapped(1.0, 2.0))
    assert str(types[0]) == str(types[1])
    assert digest(function_of(source), types[:1]) != digest(function_of(source), types[1:])


def test_a_function_is_compiled_once_for_all_values_of_an_argument() -> None:
    new = float(time.time_ns())  # in no cache

    @compiled()
    def scaled(x: float, n: int, twice: bool) -> float:
        return x * n * (2 if twice else 1) + 0.0 * new

    @compiled()
    def total(x: float, n: int) -> float:
        return scaled(x, 2, True) + scaled(x, 3, n > 1) + scaled(x, n=n, twice=False)  # type: ignore[no-any-return]

    assert total(1.5, 4) == 1.5 * (4 + 6 + 4)
    assert len(scaled.signatures) == 1


_ITSELF = """
from stribeck.compile_cache import compiled, tally

@compiled()
def grown(x, n):
    if n <= 0:
        return x
    return grown(2.0 * x, 3) if n > 5 else grown(x + 1.0, n - 1)

print(grown(1.0, 9), tally.loaded, tally.compiled)
"""


def test_a_function_that_calls_itself_with_a_constant_is_kept(tmp_path: Path) -> None:
    """Machine code of it that another process had loaded crashed that."""
    folder = str(tmp_path / "cache")
    printed = [python(_ITSELF, path=tmp_path, NUMBA_CACHE_DIR=folder).split() for _ in range(2)]
    assert [float(value) for value, _, _ in (line[-3:] for line in printed)] == [5.0, 5.0]
    assert [line[-2:] for line in printed] == [["0", "1"], ["1", "0"]]


def test_what_cannot_be_told_is_compiled_in_each_process() -> None:
    source = "@compiled()\ndef f(x):\n    return 2.0 * x.T.sum()\n"
    with pytest.raises(UnknownContentError, match="object"):
        content(source, sum=object())
    assert function_of(source, sum=object())(np.ones(3)) == 6.0


# --- where it is kept -----------------------------------------------------------------------------


@pytest.fixture
def caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of caches made from here on."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return tmp_path / "stribeck"


def test_what_is_saved_is_loaded_and_private(caches: Path) -> None:
    Folder().save("a", (1, "x"))
    assert Folder().load("a") == (1, "x")
    assert Folder().load("b") is None
    assert caches.stat().st_mode & 0o777 == 0o700


def test_a_damaged_file_is_compiled_anew(caches: Path) -> None:
    Folder().save("a", (1, "x"))
    for data in (b"", (caches / "a").read_bytes()[:-3], b"garbage"):
        (caches / "a").write_bytes(data)
        assert Folder().load("a") is None
    Folder().save("a", 2)
    assert Folder().load("a") == 2


def test_files_unused_for_longest_go_first(caches: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache_folder, "MOST_BYTES", 2500)
    for k, name in enumerate("abcd"):
        Folder().save(name, bytes(1000))
        os.utime(caches / name, (k * 1e5, k * 1e5))
    assert {p.name for p in caches.iterdir()} == {"c", "d"}
    Folder().load("c")
    Folder().save("e", bytes(1000))
    assert {p.name for p in caches.iterdir()} == {"c", "e"}


def test_a_folder_that_others_can_write_is_not_read(
    caches: Path, caplog: pytest.LogCaptureFixture
) -> None:
    Folder().save("a", 1)
    caches.chmod(0o770)
    shared = Folder()
    assert shared.load("a") is None
    shared.save("b", 2)
    assert not (caches / "b").exists()
    (record,) = caplog.records
    assert "others can write there" in record.getMessage()
    assert record.levelno == logging.WARNING


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="root alone may give")
def test_a_folder_of_someone_else_is_not_read(caches: Path) -> None:
    Folder().save("a", 1)
    os.chown(caches, 12345, 12345)
    assert Folder().load("a") is None


_COMPILES = """
from stribeck.cli.notices import notices
with notices():
    from stribeck.friction import law_named
    print(law_named("karnopp").name)
    import os
    print(os.environ.get("NUMBA_CACHE_DIR"))
"""


def test_without_a_home_it_compiles_into_a_temporary_folder_and_says_so_once() -> None:
    nowhere = "/dev/null/home"
    lines = python(_COMPILES, path=PACKAGE.parent, HOME=nowhere, XDG_CACHE_HOME=nowhere,
                  NUMBA_CACHE_DIR="").splitlines()  # fmt: skip
    law, temporary, warning, time = lines
    assert law == "karnopp"
    assert warning == (
        f"stribeck: cannot keep compiled code in {nowhere}/stribeck/compiled (Not a directory): "
        "compiling into a temporary folder, for this run alone"
    )
    assert re.fullmatch(r"stribeck: compiled \d+ functions in \d+\.\d s", time)
    assert "stribeck-" in temporary
    assert not Path(temporary).exists()


def test_without_a_home_figures_are_drawn_without_a_word() -> None:
    code = """
import logging
from stribeck.cli.notices import notices
with notices():
    import matplotlib as mpl
    print(mpl.get_cachedir())
    logging.getLogger("matplotlib.font_manager").warning("a font is missing")
"""
    nowhere = "/dev/null/home"
    said = python(code, path=PACKAGE.parent, HOME=nowhere, XDG_CACHE_HOME=nowhere,
                  XDG_CONFIG_HOME=nowhere, MPLCONFIGDIR="").splitlines()  # fmt: skip
    temporary, warning = said
    assert "matplotlib-" in temporary
    assert warning == "a font is missing"


def test_the_first_run_says_that_it_compiles_and_the_second_nothing(tmp_path: Path) -> None:
    runs = [
        python(_COMPILES, path=PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path)).splitlines()
        for _ in range(2)
    ]
    assert runs[0][2] == "stribeck: compiling for this machine, once"
    assert runs[0][3].startswith("stribeck: compiled ")
    assert [len(run) for run in runs] == [4, 2]


def test_a_command_tells_only_of_its_own_compiling(capsys: pytest.CaptureFixture[str]) -> None:
    source = f"@compiled()\ndef f(x):\n    return x + {os.getpid()}.25\n"
    function_of(source)(1.0)
    with notices():
        pass
    assert capsys.readouterr().err == ""
    with notices():
        function_of(source.replace("+", "-"))(1.0)
    lines = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"stribeck: compiled 1 functions in \d+\.\d s", lines[-1])


def test_a_program_that_does_not_listen_reads_nothing(tmp_path: Path) -> None:
    code = "from stribeck.friction import law_named; law_named('karnopp')"
    assert python(code, path=PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path)) == ""


def test_warm_takes_every_file_that_compiles() -> None:
    compiling = {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        for path in PACKAGE.rglob("*.py")
        if re.search(
            r"^(@|\w+ = )(compiled|slip_law|rub_law)\b", path.read_text("utf-8"), re.MULTILINE
        )
    }
    assert len(compiling) > 15
    code = (
        "from stribeck.cli.warm import warm; warm(); warm(json=True); "
        "import sys; print(*sys.modules)"
    )
    summary, *document, modules = python(code, path=PACKAGE.parent).splitlines()
    assert compiling <= set(modules.split())
    counted = re.match(r"(?:all )?(\d+) (?:of (\d+) )?functions ", summary)
    assert counted is not None
    answer = json.loads("\n".join(document))
    assert answer["compiled"] + answer["loaded"] >= int(counted[2] or counted[1])
    assert answer["folder"] in summary
