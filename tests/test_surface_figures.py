"""The figures of the surfaces against the surfaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.contour import QuadContourSet

from stribeck.bench.surfaces import SURFACES, surface
from surface_figures import draw_surfaces, draw_twins, relief, sheet, twins


@pytest.fixture(autouse=True)
def _coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("surface_figures._POINTS", 31)  # marks and words, not looks


@pytest.mark.parametrize("name", SURFACES)
def test_a_relief_marks_the_optima_where_they_are(name: str) -> None:
    (axes,) = relief(SURFACES[name]).axes
    (marks,) = axes.lines
    x, y, _ = marks.get_data_3d()  # type: ignore[attr-defined]
    assert np.allclose(np.stack([x, y], axis=1), SURFACES[name].optima)
    assert "cost" in axes.get_zlabel().lower()  # type: ignore[attr-defined]


def test_the_sheet_says_what_table_1_says() -> None:
    labels = {text.get_text() for text in sheet().texts}
    for s in SURFACES.values():
        assert f"{s.title} ({s.name})" in labels
        assert f"±{s.half:g}" in labels
    assert {"$10^{-9}$", "$10^{-8}$", "0.999", "0.1", "−186.73"} <= labels


def test_each_twin_stands_below_its_surface_in_the_same_colours() -> None:
    maps = [a for a in twins(7).axes if a.lines]
    surface_axes, twins_axes = maps[:5], maps[5:]
    for original, axes, twin_axes in zip(SURFACES.values(), surface_axes, twins_axes, strict=True):
        twin = surface(original.name, twin=7)
        for shown, shown_surface in ((axes, original), (twin_axes, twin)):
            assert np.allclose(shown.lines[0].get_xydata(), shown_surface.optima)
            assert shown.get_xlim() == (-original.half, original.half)
        filled = [
            next(c for c in a.collections if isinstance(c, QuadContourSet))
            for a in (axes, twin_axes)
        ]
        assert list(filled[0].levels) == list(filled[1].levels)
        assert not axes.patches
        assert len(twin_axes.patches) == 1  # the wall of the surface's own box


def test_files_are_written_as_png_and_svg(tmp_path: Path) -> None:
    files = [*draw_surfaces(tmp_path), *draw_twins(3, tmp_path)]
    assert {f.name for f in files} == {
        f"{name}.{ending}"
        for name in (*(f"surface_{n}" for n in SURFACES), "surfaces", "twins_3")
        for ending in ("png", "svg")
    }
    for file in files:
        start = file.read_bytes()[:300]
        assert start.startswith(b"\x89PNG") or b"<?xml" in start
