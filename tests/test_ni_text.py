"""Text of LabVIEW and SignalExpress, written by the published layouts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from opened_logs import log_of
from stribeck.data import read
from stribeck.errors import InputError

N = 50
T = 0.002 * np.arange(N)
X = 4.0 * np.sin(20.0 * T) + T
F = 30.0 * np.cos(20.0 * T)

_HEAD = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t.
Multi_Headings\tYes
X_Columns\t{columns}
Time_Pref\tRelative
Operator\tengineer
Date\t2026/03/01
Time\t10:11:12.123
***End_of_Header***\t
\t
"""
_SEGMENT = """Channels\t2\t\t
Samples\t{n}\t{n}\t
Date\t2026/03/01\t2026/03/01\t
Time\t10:11:12.123\t10:11:12.123\t
Y_Unit_Label\tmm\tN\t
X_Dimension\tTime\tTime\t
X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t
Delta_X\t0.002000\t0.002000\t
***End_of_Header***\t\t\t
"""


def segment(columns: str, scale: float = 1.0) -> str:
    rows = zip(T, scale * X, F, strict=True)
    if columns == "Multi":
        names = "X_Value\tposition\tX_Value\tforce\tComment"
        lines = [f"{t:.6f}\t{x:.17g}\t{t:.6f}\t{f:.17g}" for t, x, f in rows]
    elif columns == "No":
        names = "X_Value\tposition\tforce\tComment"
        lines = [f"\t{x:.17g}\t{f:.17g}" for _, x, f in rows]
    else:
        names = "X_Value\tposition\tforce\tComment"
        lines = [f"{t:.6f}\t{x:.17g}\t{f:.17g}" for t, x, f in rows]
    lines[3] += "\ta remark"
    return _SEGMENT.format(n=N) + "\n".join([names, *lines]) + "\n"


def lvm(columns: str) -> str:
    return _HEAD.format(columns=columns) + segment(columns)


def write(folder: Path, content: str, name: str = "log.lvm") -> Path:
    path = folder / name
    path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize("columns", ["One", "Multi", "No"])
@pytest.mark.parametrize("comma", [False, True])
def test_lvm(columns: str, comma: bool, tmp_path: Path) -> None:
    text = lvm(columns).replace(".", ",") if comma else lvm(columns)
    path = write(tmp_path, text.replace("\n", "\r\n"))
    reader, log = log_of(path)
    assert reader == "lvm"
    assert [(c.name, c.unit, c.count) for c in log.channels] == [
        ("position", "mm", N), ("force", "N", N),
    ]  # fmt: skip
    recording = read(path)
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.position, 1e-3 * X)
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, F)


def test_segments_of_lvm(tmp_path: Path) -> None:
    path = write(tmp_path, lvm("One") + "\n" + segment("One", 2.0))
    _, log = log_of(path)
    assert log.problems == (
        'has 2 segments: the first is read; columns={"episode": "2"} takes the next',
    )
    _, log = log_of(path, episode="2")
    np.testing.assert_allclose(log.tables()[0].columns["position"], 2.0 * X)
    with pytest.raises(InputError, match="has no segment 3: there are 1 to 2"):
        log_of(path, episode="3")


def test_lvm_that_was_cut_off(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="its heads do not end"):
        read(write(tmp_path, lvm("One")[:200]))


def test_lvm_with_damaged_names_and_steps(tmp_path: Path) -> None:
    """A column before any times goes by its step; a step beyond all times is none."""
    text = lvm("One").replace("X_Value\t", "X_Values\t")
    _, log = log_of(write(tmp_path, text))
    assert "position" in [c.name for c in log.channels]
    for number in ("1e308", "inf"):
        with pytest.raises(InputError):
            log_of(write(tmp_path, lvm("No").replace("\t0.002", f"\t{number}")))


_EXPRESS = "channel names:\nposition [mm]\tforce [N]\t\nstart times:\n"


def test_signal_express(tmp_path: Path) -> None:
    rows = "\n".join(f"{x:.17g}\t{f:.17g}\t" for x, f in zip(X, F, strict=True))
    head = f"{_EXPRESS}03/28/2026 10:11:32.000\t03/28/2026 10:11:32.004\t\n"
    path = write(tmp_path, f"{head}dt:\n0.002000\t0.002000\t\ndata:\n{rows}\n", "log.txt")
    reader, log = log_of(path)
    assert reader == "signal-express"
    assert [c.rate for c in log.channels] == pytest.approx([500.0, 500.0])
    recording = read(path)
    np.testing.assert_allclose(recording.position, 1e-3 * X[2:])
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, F[:-2], atol=1e-9)
    with pytest.raises(InputError, match="its heads do not end"):
        read(write(tmp_path, head))
    with pytest.raises(InputError, match="names 2 channels and 2 steps of time: export it again"):
        read(write(tmp_path, f"{head}dt:\n0.002\t1e308\t\ndata:\n{rows}\n"))
