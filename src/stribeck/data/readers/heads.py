"""Column heads: what `Position [mm]`, `q_cmd_rad` or `tau_meas_Nm` say they are."""

from __future__ import annotations

import re
from dataclasses import dataclass

#: What people call a quantity. A name may stand in two lists: its unit then tells which is meant.
_NAMES = {
    "time": "t time timestamp time_stamp elapsed elapsed_time zeit",
    "position": "position pos x q qm angle theta phi displacement disp stroke joint_position "
    "joint_angle weg winkel",
    "command": "command cmd setpoint set_point target reference ref desired goal xd qd qg x_d q_d "
    "soll sollwert",
    "velocity": "velocity vel speed v w omega qd dq qdot q_dot dx xdot x_dot joint_velocity rate "
    "geschwindigkeit",
    "acceleration": "acceleration accel acc a qdd ddq qddot q_ddot ddx xddot x_ddot",
    "force": "force f torque tau moment effort load_force joint_torque motor_torque motor_force "
    "kraft drehmoment",
    "current": "current i iq i_q motor_current strom",
    "voltage": "voltage u v motor_voltage spannung",
    "temperature": "temperature temp t motor_temperature temperatur",
    "pressure": "pressure p gauge_pressure chamber_pressure druck",
}
_CHANNEL = [(n, channel) for channel, names in _NAMES.items() for n in names.split()]
_MEASURED = {"meas", "measured", "act", "actual", "feedback", "ist"}
_COMMANDED = {"cmd", "command", "commanded", "set", "setpoint", "target", "ref", "reference",
              "des", "desired", "goal", "soll"}  # fmt: skip
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")

_SYMBOLS = (
    "s sec secs second seconds ms msec us usec µs μs min h m mm um µm μm nm cm km in inch rad mrad "
    "urad µrad μrad deg ° degree degrees rev turn turns N mN kN Nm mNm kNm A mA V mV K degC °C C W "
    "Hz bar mbar psi Pa kPa MPa % ‰ kg g rpm counts count inc incs pls pulses cnt"
)
_UNITS = frozenset(_SYMBOLS.split())
_BELOW = {"s", "s2", "s^2", "s²", "ms", "min", "rad", "rad2", "m", "m2", "mm", "A", "V"}
_LONGEST_UNIT = 3
_LONGEST_HEAD = 120  # beyond, a head is prose
_BRACKETED = re.compile(
    r"(.*?)[\s_]*[\[({]([^\[\](){}]*(?:\([^\[\](){}]*\))?[^\[\](){}]*)[\])}]\s*"
)
_SLASHED = re.compile(r"(.*\S)\s+(?:/|in)\s+(\S.*)|(.*\S)\s*,\s*(\S+)")

#: Spellings in which a `_` is no division.
_RESPELL = {"N_m": "N m", "mN_m": "mN m", "kN_m": "kN m"}


@dataclass(frozen=True)
class Head:
    """A column head taken apart.

    Args:
        stem: Its name in lower case, words joined by `_`.
        unit: The unit as written, None if it states none.
    """

    stem: str
    unit: str | None


def take_apart(head: str) -> Head:
    """The name and the unit of a head: `Position [mm]`, `Weg / mm`, `qd_rad_s`, `t (s)`."""
    head = head.strip()
    if len(head) > _LONGEST_HEAD:
        return Head(_stem(head), None)
    if match := _BRACKETED.fullmatch(head):
        return Head(_stem(match[1]), _respelled(match[2]))
    if (match := _SLASHED.fullmatch(head)) and is_unit(match[2] or match[4]):
        return Head(_stem(match[1] or match[3]), _respelled(match[2] or match[4]))
    words = re.split(r"[_\s]+", head)
    for n in range(min(_LONGEST_UNIT, len(words) - 1), 0, -1):
        if is_unit("_".join(words[-n:])):
            return Head(_stem("_".join(words[:-n])), _respelled("_".join(words[-n:])))
    return Head(_stem(head), None)


def is_unit(text: str) -> bool:
    """Whether a piece of a head is a unit and not a word (`mm`, `rad_s2`, `N s/m`)."""
    numerator, *denominators = re.split(r"[_/\s]+", text.strip().strip("[]()"))
    seconds = numerator in ("s", "ms", "us", "µs", "μs", "min", "h")  # nothing divides them
    return (
        numerator in _UNITS
        and all(b in _BELOW for b in denominators)
        and not (seconds and denominators)
    )


def meanings(head: Head) -> dict[str, int]:
    """The channels that a head may name, with a rank: 0 says measured, 1 plain, 2 commanded.

    A commanded position is the channel `command`; a commanded force is a force of rank 2 (better
    than none); a commanded velocity is no channel.
    """
    plain = {channel: 1 for name, channel in _CHANNEL if name == head.stem}
    if plain:
        return plain
    words = head.stem.split("_")
    qualifiers = [w for w in words if w in _MEASURED | _COMMANDED]
    stem = "_".join(w for w in words if w not in qualifiers)
    if len(qualifiers) != 1 or not stem:
        return {}
    bare = [channel for name, channel in _CHANNEL if name == stem]
    if qualifiers[0] in _MEASURED:
        return {c: 0 for c in bare if c != "command"}
    return {
        c: r
        for b in bare
        for c, r in {"position": [("command", 1)], "force": [("force", 2)]}.get(b, [])
    }


def _stem(text: str) -> str:
    return re.sub(r"[\W_]+", "_", _CAMEL.sub("_", text.strip())).strip("_").lower()


def _respelled(unit: str) -> str:
    unit = unit.strip()
    return _RESPELL.get(unit, unit)
