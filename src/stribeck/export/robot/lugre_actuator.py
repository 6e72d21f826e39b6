"""MuJoCo's LuGre friction: a passive motor beside a joint, which holds the Stribeck drop as well.

An element <dcmotor> without input, current or torque has friction alone (MuJoCo 4.0; its XML
reference, actuator/dcmotor, attributes input and lugre): bristles of a stiffness and a damping, a
level that falls from its static to its Coulomb value as exp(-(v/v_s)^2). The viscous term stays
the joint's.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING

from ...errors import InputError
from .joint_file import Change, JointFile, Tag, number
from .reduction import Reduction, lugre
from .spring_pull import inertia

if TYPE_CHECKING:
    from ..model import Model

#: MuJoCo's own time step, s, where a file does not say one.
_STEP = 0.002
#: How far the bristles swing in a step, rad, and their damping ratio. MuJoCo integrates their
#: force explicitly. Measured with 4.0: they rest down to an eighth of the inertia, at any ratio
#: from 0.2 on; at 0.3 rad and a ratio of 0.1 they never do. More damping is no better: where
#: relaxed bristles meet an axis at speed, it acts for a whole step.
_SWING, _RATIO = 0.2, 0.2
#: Elements that this looks at.
KEPT = ("option", "actuator", "key", "dcmotor")


def bristles(
    model: Model, file: JointFile, joint: Tag, actuators: Collection[str]
) -> tuple[Reduction, list[Change], list[str]]:
    """The LuGre law of a card, what it changes in the file beside the joint, and what to know.

    Args:
        model: The card's model.
        file: The user's file.
        joint: The joint, which has the damping.
        actuators: Names of all elements of the actuator section.

    Raises:
        InputError: the rig does not know the inertia, the law never sticks, or the file has what
            such a motor would break, or be broken by.
    """
    mass = inertia(model.rig, model.law, model.values)
    if mass is None:
        raise InputError(
            f"rig {model.rig.name} does not know the inertia of the axis, by which bristles are "
            "made stiff"
        )
    if not model.law.levels(model.p)[1] > 0:
        raise InputError(f"law {model.law.name} never sticks, and bristles do: leave lugre out")
    step = _time_step(file)
    stiffness, damping = _bristle_constants(model, mass, step)
    to = lugre(
        model.law, model.p, model.speeds,
        rotary=model.rig.rotary, stiffness=stiffness, damping=damping,
    )  # fmt: skip
    values = " ".join(number(to[n]) for n in ("sigma_0", "sigma_1", "F_C", "F_S", "v_s"))
    # What a class of defaults might say of actuators is said here, lest it hold.
    text = (
        f'<dcmotor joint="{_escaped(joint.attributes["name"])}" input="none" motorconst="0" '
        f'resistance="1" gear="1" saturation="0 0 0" damping="0" armature="0" lugre="{values}"/>'
    )
    unit, weight = ("N m/rad", "kg m^2") if model.rig.rotary else ("N/m", "kg")
    made_for = f"{mass:.3g} {weight} and a time step of {1e3 * step:g} ms"
    stiff = f"{to['sigma_0']:.3g} {unit}"
    notes = [
        "the friction needs MuJoCo 4.0 or later: older ones know no <dcmotor> without a current",
        f"its bristles ({stiff}) are made for {made_for}: a much lighter axis needs shorter steps",
    ]
    if "actuatorfrcrange" in joint.attributes:
        notes.append("actuatorfrcrange of the joint limits this friction together with the drive")
    return to, [_inserted(file, joint, text, actuators)], notes


def _time_step(file: JointFile) -> float:
    steps = [
        tag.attributes["timestep"] for tag in file.named("option") if "timestep" in tag.attributes
    ]
    try:
        step = float(steps[-1]) if steps else _STEP
    except ValueError:
        step = math.nan
    if not 0 < step < math.inf:
        raise InputError(f"timestep {steps[-1][:40]!r} of <option> is no time")
    return step


def _bristle_constants(model: Model, mass: float, step: float) -> tuple[float, float]:
    """Stiffness and damping of the bristles: the card's where it has them and a step can follow."""
    most = mass * (_SWING / step) ** 2
    values = dict(zip(model.law.names, model.p, strict=True))
    if model.law.name == "lugre" and values["sigma_0"] <= most:
        return float(values["sigma_0"]), float(values["sigma_1"])
    return most, 2.0 * _RATIO * math.sqrt(most * mass)


def _inserted(file: JointFile, joint: Tag, text: str, actuators: Collection[str]) -> Change:
    """Where the motor goes: last in the actuators, so that those before it keep their numbers."""
    name = joint.attributes["name"]
    for tag in file.named("key"):
        if tag.attributes.get("act"):
            raise InputError(
                f"line {tag.line}: a keyframe with act= would lack the value of the bristles: take "
                "the keyframe out first"
            )
    for tag in file.named(*actuators):
        within = tag.parent.name if tag.parent is not None else ""
        if tag.name == "dcmotor" and within == "default":
            raise InputError(
                f"line {tag.line}: a class of <dcmotor> would change this friction: take it out "
                "first"
            )
        if "lugre" in tag.attributes and tag.attributes.get("joint") == name:
            raise InputError(
                f"line {tag.line}: a <dcmotor> gives joint {name!r} a friction of its own: take "
                "it out first"
            )
    sections = [tag for tag in file.named("actuator") if tag.parent is file.root]
    if sections:
        return file.last(sections[-1], text)
    return file.last(file.root, f"<actuator>{text}</actuator>")


def _escaped(name: str) -> str:
    """A name between double quotes; in ASCII, so that any encoding has it."""
    for sign, entity in (("&", "&amp;"), ("<", "&lt;"), ('"', "&quot;")):
        name = name.replace(sign, entity)
    return "".join(c if c.isascii() and c.isprintable() else f"&#{ord(c)};" for c in name)
