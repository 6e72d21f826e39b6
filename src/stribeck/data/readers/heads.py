"""Column heads: what `Position [mm]`, `q_cmd_rad` or `tau_meas_Nm` say they are."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

#: What people call a quantity. A name may stand in two lists: its unit then tells which is meant.
_NAMES = {
    "time": "t time timestamp time_stamp stamp elapsed elapsed_time zeit temps tempo tiempo "
    "时间 時間",
    "position": "position pos x q qm angle theta phi displacement disp stroke joint_position "
    "joint_angle lage weg winkel posizione angolo posicion angulo 位置 角度",
    "command": "command cmd setpoint set_point target reference ref desired goal xd qd qg x_d q_d "
    "soll sollwert consigne",
    "velocity": "velocity vel speed v w omega qd dq qdot q_dot dx xdot x_dot joint_velocity rate "
    "geschwindigkeit drehzahl vitesse velocita velocidad 速度 转速 回転速度 モータ回転速度",
    "acceleration": "acceleration accel acc a qdd ddq qddot q_ddot ddx xddot x_ddot "
    "beschleunigung accelerazione aceleracion 加速度",
    "force": "force f torque tau trq moment effort load_force joint_torque motor_torque "
    "motor_force drive_force feed_force cylinder_force actuator_force axial_force "
    "drive_torque thrust thrust_force kraft antriebskraft motorkraft vorschubkraft zylinderkraft "
    "drehmoment motormoment motordrehmoment antriebsmoment "
    "antriebsdrehmoment couple coppia forza par fuerza "
    "转矩 力矩 扭矩 トルク 推力",
    "current": "current i iq i_q motor_current strom motorstrom courant corrente corriente "
    "电流 電流",
    "voltage": "voltage u v motor_voltage spannung tension tensione 电压 電圧",
    "temperature": "temperature temp t motor_temperature temperatur temperatura 温度",
    "pressure": "pressure p gauge_pressure chamber_pressure druck pression pressione presion "
    "压力 圧力",
    "back_pressure": "back_pressure rod_pressure rod_side_pressure gegendruck",
}
_CHANNELS: dict[str, list[str]] = {}
for _channel, _names in _NAMES.items():
    for _name in _names.split():
        _CHANNELS.setdefault(_name, []).append(_channel)
_MEASURED = {"meas", "measured", "act", "actual", "feedback", "fbk", "present", "ist", "reel",
             "reelle", "mesure", "mesuree", "effettiva", "effettivo", "reale", "attuale", "real",
             "medida", "medido", "实际", "反馈", "当前", "実", "現在",
             "フィードバック"}  # fmt: skip
_COMMANDED = {"cmd", "command", "commanded", "set", "setpoint", "target", "ref", "reference", "req",
              "des", "desired", "demand", "demanded", "goal", "soll", "consigne", "comando",
              "consigna", "action", "指令", "目标", "给定", "目標"}  # fmt: skip
#: Words of a name that say nothing: `Position actual value`, `consigne de position`.
_SILENT = {"value", "val", "wert", "valore", "valeur", "valor", "of", "de", "di", "del"}
#: Two words written as one: `Istposition`, `Lageistwert`, `实际位置`.
_BEFORE = re.compile(r"(ist|soll|实际|反馈|当前|実|現在|フィードバック|指令|目标|给定|目標)(.+)")
_BEHIND = re.compile(r"(.+?)(?:s|en|n)?(ist|soll)(?:wert)?")
_SHORTEST_NOUN = 3  # of a compound in Latin letters
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")
_ACCENTS = re.compile("[\u0300-\u036f]")

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


def named_by_stem(name: str, heads: Iterable[str]) -> str | None:
    """The one head that is a name but for its unit: `tau_rigid_Nm` is `tau_rigid`."""
    stem = take_apart(name).stem
    same = [head for head in heads if take_apart(head).stem == stem]
    return same[0] if len(same) == 1 else None


def is_unit(text: str) -> bool:
    """Whether a piece of a head is a unit and not a word (`mm`, `rad_s2`, `N s/m`)."""
    numerator, *denominators = re.split(r"[_/\s]+", text.strip().strip("[]()"))
    seconds = numerator in ("s", "ms", "us", "µs", "μs", "min", "h")  # nothing divides them
    return (
        numerator in _UNITS
        and all(b in _BELOW for b in denominators)
        and not (seconds and denominators)
    )


#: How well a name tells a channel, the better the less: what says measured, a plain name, one
#: that ends a longer name, a commanded one.
MEASURED, PLAIN, ENDS, COMMANDED = range(4)


def meanings(head: Head) -> dict[str, int]:
    """The channels that a head may name, with a rank.

    A commanded position is the channel `command`; a commanded force is a force of rank
    `COMMANDED` (better than none); a commanded velocity is no channel.
    """
    if plain := dict.fromkeys(_named(head.stem), PLAIN):
        return plain
    words = [p for w in head.stem.split("_") for p in _parts(w) if p not in _SILENT]
    qualifiers = [w for w in words if w in _MEASURED | _COMMANDED]
    rest = [w for w in words if w not in qualifiers]
    if len(qualifiers) == 1 and (bare := _named("_".join(rest))):
        if qualifiers[0] in _MEASURED:
            return {c: MEASURED for c in bare if c != "command"}
        return _commanded(bare)
    for n in range(1, len(rest)):
        if bare := _named("_".join(rest[n:])):
            if not qualifiers:
                return dict.fromkeys(bare, ENDS)
            return _commanded(bare) if qualifiers[0] in _COMMANDED else dict.fromkeys(bare, ENDS)
    return {}


def _parts(word: str) -> tuple[str, ...]:
    """The words of a compound, the word itself where it is none."""
    for pattern, noun in ((_BEFORE, 2), (_BEHIND, 1)):
        match = pattern.fullmatch(word)
        long = match and (not word.isascii() or len(match[noun]) >= _SHORTEST_NOUN)
        if match and long and _named(match[noun]):
            return match.groups()
    return (word,)


def _named(stem: str) -> Sequence[str]:
    return _CHANNELS.get(stem, ())


def _commanded(channels: Sequence[str]) -> dict[str, int]:
    ranks = {"position": ("command", PLAIN), "force": ("force", COMMANDED)}
    return dict(ranks[c] for c in channels if c in ranks)


def _stem(text: str) -> str:
    plain = _ACCENTS.sub("", unicodedata.normalize("NFD", text.strip()))
    text = unicodedata.normalize("NFC", plain)
    return re.sub(r"[\W_]+", "_", _CAMEL.sub("_", text)).strip("_").lower()


def _respelled(unit: str) -> str:
    unit = unit.strip()
    return _RESPELL.get(unit, unit)
