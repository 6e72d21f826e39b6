"""Constants that logs state in place of the rig's: the card has them, and the page says whose."""

from __future__ import annotations

import numpy as np

from stribeck import Recording, identify
from stribeck.identify.card import Card
from stribeck.report.page.fit_tables import constants

T = np.linspace(0.0, 2.0, 401)


def log(kp: float) -> Recording:
    command = 0.3 * np.sin(4.0 * T)
    position = 0.28 * np.sin(4.0 * T - 0.1) + 0.28 * np.sin(0.1)
    stated = {"mass": 0.5, "kp": kp, "torque_enable": 1.0}
    extra = {name: np.full(len(T), value) for name, value in stated.items()}
    return Recording(T, position, command=command, extra=extra, rotary=True)


def test_the_page_shows_what_the_logs_state() -> None:
    fit = identify([log(100.0), log(300.0)], rig="servo-pendulum", budget=10, repeats=1)
    card = fit.card()
    assert card.stated == {"m": [0.5, 0.5], "kp": [100.0, 300.0]}
    assert str(card) == repr(card)
    assert repr(card).startswith("<Card of coulomb-viscous on servo-pendulum: F_C = ")
    table = constants(card)
    assert table is not None
    rows = {row[0].text: [cell.text for cell in row[1:]] for row in table.rows}
    assert rows["m"] == ["0.5", "–", "kg", "the logs"]
    assert rows["kp"][0] == "100 to 300"
    assert rows["l"][-1] == "the paper"
    assert Card.model_validate_json(card.text()).stated == card.stated
    assert '"stated"' not in card.model_copy(update={"stated": {}}).text()
