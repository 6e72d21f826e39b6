"""The twin of the paper's test bed, recorded: one call from settings to a log with its truth."""

from __future__ import annotations

from .twin import Direction, Held, Loop, Mode, TestBed, Twin


def twin(
    direction: Direction = "both",
    *,
    seed: int = 0,
    speed: float = 5e-3,
    noise: float = 0.3e-3,
    rate: float = 100.0,
    echo_rate: float = 50.0,
    loop: Loop = "sensors",
    mode: Mode = "control",
    drive: Held = "current",
    supply: float = 24.0,
) -> Twin:
    """Record the paper's test bed (section 4.1, figure 3), simulated with its sensors.

    Args:
        direction: Ramp up, down, or both: up and then down.
        seed: Of the sensor noise.
        speed: Of the ramp, m/s.
        noise: Standard deviation of an ultrasonic echo, m.
        rate: Of the log, Hz.
        echo_rate: Of the transducer, Hz.
        loop: What the controller goes by: what it reads (`sensors`), or the position (`ideal`).
        mode: Ramps (`control`); or the whole range and then home (`test`); or `home`.
        drive: What the drive holds from sample to sample: `current` or `voltage`.
        supply: Voltage of the supply, V.

    Returns:
        The log as `recording`, and the truth: `law`, its parameters `truth` and what really
        happened, `motion`.

    Raises:
        InputError: a setting that the test bed cannot have.
    """
    bed = TestBed(
        speed=speed, echo_noise=noise, rate=rate, echo_rate=echo_rate,
        loop=loop, mode=mode, held=drive, supply=supply,
    )  # fmt: skip
    return bed.run(direction, seed=seed)
