"""URDF: a card's friction as the <dynamics> of a joint in a user's robot description.

`friction` and `damping` are in N and N s/m for a prismatic joint, in N m and N m s/rad for one that
turns (http://wiki.ros.org/urdf/XML/joint).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import InputError
from .joint_file import Change, JointFile, Tag, joint_named, number
from .reduction import coulomb_viscous
from .reduction_error import reduction_errors

if TYPE_CHECKING:
    from ..model import Model

_TURN, _SLIDE = ("revolute", "continuous"), ("prismatic",)
#: What a joint may stand in: the robot, or a macro of xacro.
_XACRO = "xacro:"


def urdf(model: Model, source: bytes, joint: str) -> tuple[bytes, list[str]]:
    """A URDF file with a joint's friction as the card has it, and what it does not hold.

    Its <dynamics> gets `damping` and `friction`; a joint without one gets one. All other bytes
    stay.

    Args:
        model: The card's model.
        source: The file.
        joint: Name of the joint, revolute or continuous for a rotary card, prismatic for a linear
            one.

    Raises:
        InputError: no URDF, no such joint or several, one of another kind, or one that macros of
            xacro have still to make.
    """
    file = JointFile(source, ("joint", "dynamics", "mimic"))
    _check_root(file)
    joints = [tag for tag in file.named("joint") if _of_the_robot(tag)]
    patched = joint_named(joints, joint, _elsewhere(file))
    _check_kind(patched, rotary=model.rig.rotary)
    reduction = coulomb_viscous(model.law, model.p, model.speeds, rotary=model.rig.rotary)
    values = {"damping": number(reduction["F_V"]), "friction": number(reduction["F_C"])}
    notes = [
        *reduction_errors(model, reduction),
        "what a simulator makes of `friction` is its own affair: see its manual",
    ]
    if any(tag.name.startswith(_XACRO) for tag in patched.around()):
        notes.append("the joint stands in a macro of xacro: each use of it has this friction")
    if any(tag.parent is patched for tag in file.named("mimic")):
        notes.append("the joint mimics another one: most simulators do not look at its friction")
    return file.changed([_change(file, patched, values)]), notes


def _check_root(file: JointFile) -> None:
    name = file.root.name
    if name in ("mujoco", "mujocoinclude"):
        raise InputError("is MJCF (its root is <mujoco>), not URDF: export to mjcf")
    if name != "robot":
        raise InputError(f"is not URDF: its root is <{name[:40]}>, it should be <robot>")


def _of_the_robot(tag: Tag) -> bool:
    """Whether it is a joint, not one that a transmission or a controller refers to."""
    return all(around.name == "robot" or around.name.startswith(_XACRO) for around in tag.around())


def _elsewhere(file: JointFile) -> str:
    """Why a joint may not be there."""
    if any(name.startswith(_XACRO) for name in file.prefixed):
        return "macros of xacro may make it: run `xacro FILE > robot.urdf` and patch that"
    if prefixed := sorted(name for name in file.prefixed if name.endswith(":joint")):
        return f"elements named <{prefixed[0][:40]}> are no joints of URDF"
    return ""


def _check_kind(joint: Tag, *, rotary: bool) -> None:
    name, kind = joint.attributes["name"], joint.attributes.get("type", "")
    where = f"line {joint.line}: joint {name!r}"
    if "${" in kind or "$(" in kind:
        raise InputError(f"{where}: xacro has still to say its type: run xacro first")
    if kind not in _TURN + _SLIDE:
        raise InputError(
            f"{where} is of type {kind[:40] or 'none'}: friction of an axis goes into a revolute, "
            "continuous or prismatic one"
        )
    if rotary != (kind in _TURN):
        card, kinds = ("N m", "revolute or continuous") if rotary else ("N", "prismatic")
        raise InputError(f"{where} is {kind}, and the card is in {card}: it fits a {kinds} one")


def _change(file: JointFile, joint: Tag, values: dict[str, str]) -> Change:
    dynamics = [tag for tag in file.named("dynamics") if tag.parent is joint]
    if len(dynamics) > 1:
        lines = ", ".join(str(tag.line) for tag in dynamics)
        raise InputError(
            f"joint {joint.attributes['name']!r} has {len(dynamics)} <dynamics>, on lines {lines}: "
            "keep one"
        )
    if dynamics:
        return file.attributed(dynamics[0], values)
    written = " ".join(f'{name}="{value}"' for name, value in values.items())
    return file.inside(joint, f"<dynamics {written}/>")
