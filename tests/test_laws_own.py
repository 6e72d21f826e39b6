"""The law of one's own that docs/laws.md shows, run as it stands there."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stribeck
from stribeck.friction import slip_law

PAGE = Path(__file__).parent.parent / "docs" / "laws.md"
#: What the twin's slide rubs leftward: the published set, SI.
F_S, F_C = 152.28, 40.42

_TELL = """
import json
import numpy as np
v = np.array([-1e-2, 0.0, 1e-3, 1e-2])
print(json.dumps({
    "values": fit.values, "J": fit.score.value, "held": fit.holdout[0].score.value,
    "force": MY_LAW.friction(v, np.array([100.0, 40.0, 500.0, 2e-3])).tolist(),
}))
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the block finds on a twin made for it, in a process and a folder of its own."""
    (block,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    folder = tmp_path_factory.mktemp("own")
    (folder / "demo").mkdir()
    (folder / "mine.py").write_text(block + _TELL, encoding="utf-8")
    for command in (["-m", "stribeck", "twin", "demo/twin.csv"], ["mine.py"]):
        done = subprocess.run(
            [sys.executable, *command], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def test_the_law_of_the_page_is_the_function_it_shows(said: dict[str, Any]) -> None:
    v, F = np.array([-1e-2, 0.0, 1e-3, 1e-2]), np.array(said["force"])
    expected = np.where(v < 0, -1, 1) * (40 + 60 * 2 / (np.exp(v / 2e-3) + np.exp(-v / 2e-3)))
    np.testing.assert_allclose(F, expected + 500 * v, rtol=1e-12)


def test_it_finds_the_friction_of_the_twin(said: dict[str, Any]) -> None:
    # Sensor noise is 0.3 mm: a law that differs from the twin's by the shape of its drop comes
    # down to the noise, on what it saw and on what it did not.
    assert 0.28 < said["J"] < 0.35
    assert 0.28 < said["held"] < 0.40
    assert abs(said["values"]["F_S"] / F_S - 1) < 0.1
    assert abs(said["values"]["F_C"] / F_C - 1) < 0.1


def test_a_law_typed_at_a_prompt_compiles_too() -> None:
    space: dict[str, Any] = {"slip_law": slip_law}
    exec("@slip_law\ndef slip(v, p):\n    return p[0] * v\n", space)  # noqa: S102 - a prompt does that
    assert space["slip"](0.5, np.array([3.0])) == 1.5


def test_the_page_shows_every_law_there_is() -> None:
    text = PAGE.read_text(encoding="utf-8")
    for name in stribeck.LAWS:
        assert f"`{name.removesuffix('-directional')}`" in text, name
