"""A card trained in one direction, against a log that runs in both."""

import pytest

from exported import model_of
from stribeck import identify
from stribeck.compensate.compensation import compensate
from stribeck.export.model import as_model
from stribeck.identify.card import Card, SpeedsCard
from stribeck.identify.validate import untrained_directions
from stribeck.report.contents.decimation import PAGE
from stribeck.report.contents.gather import Contents
from stribeck.report.figures.law_plots import curve_plot
from stribeck.rig.twin import TestBed

LOG = TestBed().run("both", seed=3).recording


def card(law: str, low: float, high: float) -> Card:
    speeds = SpeedsCard(low=low, high=high, unit="mm/s")
    return model_of(law).card.model_copy(update={"speeds": speeds})


def test_the_other_way_is_told() -> None:
    (warning,) = untrained_directions(card("stribeck", -0.1, 60.0), [LOG])
    assert "runs the other way" in warning
    assert "-0.1 to 60 mm/s" in warning


@pytest.mark.parametrize(
    ("law", "low", "high", "ranges"),
    [
        ("stribeck", -80.0, 60.0, None),
        ("stribeck-directional", 0.0, 60.0, None),
        ("stribeck", 0.0, 60.0, "60:300"),
    ],
)
def test_what_was_seen_is_not_told(law: str, low: float, high: float, ranges: str | None) -> None:
    assert untrained_directions(card(law, low, high), [LOG], ranges) == []


def test_exports_and_compensation_name_the_direction_that_was_not_seen() -> None:
    one_way = card("stribeck", -0.1, 60.0)
    sentence = "the training data ran one way (-0.1 to 60 mm/s): nothing was seen of friction"
    assert f"{sentence} at v < 0" in "\n".join(as_model(one_way).head())
    assert "ran one way" not in "\n".join(as_model(card("stribeck", -60.0, 60.0)).head())
    assert card("stribeck", -60.0, 0.1).speeds.one_way.endswith("at v > 0")  # type: ignore[union-attr]


def test_the_curve_to_the_side_that_was_not_seen_is_told_from_the_other() -> None:
    fit = identify(TestBed().run("up", seed=3).recording, rig="slide-bed", budget=60, repeats=1)
    contents = Contents(fit)
    law = contents.law(PAGE, (-0.05, 0.05))
    assert [side.seen for side in law.curve] == [True, False]
    (view,) = curve_plot(contents.frame, law, "").views
    names = [line.name for line in view.lines if line.kind == "dashes"]
    assert names == ["law: stribeck, not seen this way"]
    tried = compensate(fit.card(), speed=0.05, mode="reference", scale=0.8)
    (note, *_) = [n for n in tried.notes if "one way" in n]
    assert "nothing was seen of friction at v < 0" in note
