"""A card trained in one direction, against a log that runs in both."""

import pytest

from exported import model_of
from stribeck.identify.card import Card, SpeedsCard
from stribeck.identify.validate import untrained_directions
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
