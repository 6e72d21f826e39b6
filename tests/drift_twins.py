"""Twins of axes that are logged again and again: levels, days, logs, steps and seasons.

A plain simulator of what is estimated, number by number, with no part of the package in it.
"""

import math
import random
from dataclasses import dataclass


@dataclass(frozen=True)
class Twin:
    """An axis.

    Args:
        level: Its friction.
        day: Standard deviation from day to day.
        log: Standard deviation from log to log of a day.
        logs: Logs a day.
        step: A change of its level.
        at: Index of the first log after it.
        slope: What a degree does.
        season: Amplitude of the temperature over the year, degrees.
        wear: What a log adds.
    """

    level: float = 1.35
    day: float = 0.0
    log: float = 0.057
    logs: int = 1
    step: float = 0.0
    at: int = 0
    slope: float = 0.0
    season: float = 0.0
    wear: float = 0.0

    def estimates(self, count: int, seed: int) -> list[tuple[int, float, float]]:
        """Day, estimate and temperature of so many logs."""
        draw = random.Random(seed)  # noqa: S311 - a simulator
        result = []
        effect = 0.0
        for k in range(count):
            day, of_day = divmod(k, self.logs)
            if of_day == 0:
                effect = draw.gauss(0.0, self.day)
            warmth = self.season * math.sin(2.0 * math.pi * day / 365.0)
            value = self.level + effect + draw.gauss(0.0, self.log) + self.wear * k
            value += self.slope * warmth + (self.step if k >= self.at and self.step else 0.0)
            result.append((day, value, 20.0 + warmth))
        return result
