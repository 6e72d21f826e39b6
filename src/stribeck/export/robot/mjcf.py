"""MuJoCo: a card's friction as attributes of a joint in a user's MJCF file.

`frictionloss` is a level, `damping` a viscous term; `armature`, where asked for, the rotor's
inertia; `bristles`, where asked for, hold the static peak. Source of what is said of MuJoCo here:
its XML reference, elements body/joint, default and option, and its chapter Computation, sections
"Friction loss" and "Parameters" (of the constraint solver).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...errors import InputError
from .joint_file import Change, JointFile, Tag, joint_named, number
from .lugre_actuator import KEPT, bristles
from .reduction import Reduction, coulomb_viscous
from .reduction_error import RigUnits, reduction_errors
from .spring_pull import inertia

if TYPE_CHECKING:
    from ..model import Model

#: Elements of the actuator section, which may add to the damping of their joint.
_ACTUATORS = (
    "general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle",
    "dcmotor", "pid", "plugin",
)  # fmt: skip
_KEPT = ("joint", "freejoint", "default", "include", "attach", "flag", *_ACTUATORS, *KEPT)
#: Where a joint of a body may stand; elsewhere elements of that name refer to one.
_BODIES = ("body", "frame", "replicate", "worldbody")
_TURNS, _SLIDES = "hinge", "slide"
#: A firm constraint: what gives way at rest becomes a thousandth.
_FIRM = {"solimpfriction": "0.9999 0.9999 0.001 0.5 2"}
#: MuJoCo's defaults of solref and solimp: time constant, s; impedances at rest and at most.
_TIME_CONSTANT, _D_0, _D_WIDTH = 0.02, 0.9, 0.95
_FIRM_D = 0.9999


def mjcf(
    model: Model,
    source: bytes,
    joint: str,
    *,
    lugre: bool = False,
    firm: bool = False,
    armature: bool = False,
) -> tuple[bytes, list[str]]:
    """A MuJoCo file with a joint's friction as the card has it, and what it does not hold.

    The joint's attributes win over those of its class. All bytes outside its tag stay;
    with `lugre` an actuator is put in.

    Args:
        model: The card's model.
        source: The file.
        joint: Name of the joint, a hinge for a rotary card and a slide for a linear one.
        lugre: Whether a passive motor with LuGre friction stands in for `frictionloss`: it holds
            static friction and the Stribeck drop, and needs MuJoCo 4.0.
        firm: Whether `solimpfriction` is set as well, so that the joint creeps a thousandth of
            what it would at rest.
        armature: Whether the joint gets the rotor's inertia too, where the rig identified one.

    Raises:
        InputError: no MJCF, no such joint or several, one of another kind, or something in the
            file that would replace what is written.
    """
    file = JointFile(source, _KEPT)
    _check_root(file)
    tag = joint_named(_joints(file), joint, _elsewhere(file))
    _check_kind(file, tag, rotary=model.rig.rotary)
    changes, known = list[Change](), list[str]()
    if lugre:
        to, changes, known = bristles(model, file, tag, _ACTUATORS)
    else:
        to = coulomb_viscous(model.law, model.p, model.speeds, rotary=model.rig.rotary)
        known = _creep(file, tag, model, to, firm=firm)
    values = {"frictionloss": "0" if lugre else number(to["F_C"]), "damping": number(to["F_V"])}
    if armature:
        values["armature"] = number(_armature(model))
    if firm:
        values |= _FIRM
    notes = [*reduction_errors(model, to), *known, *_doubts(file, tag)]
    return file.changed([*changes, file.attributed(tag, values)]), notes


def creep(force: float, inertia: float, damping: float = 0.0, *, firm: bool = False) -> float:
    """The speed at which a joint creeps under a force below its frictionloss, m/s (rad/s).

    The constraint is soft: at rest its force is that of a damper whose coefficient follows from
    its reference (time constant T and damping ratio 1) and its impedance d_0 at a violation of 0,
    v = ((F - D v) / M) (1 - d_0)/d_0 d_width T/2 with the joint's own damping D.

    Args:
        force: N (N m).
        inertia: Of the axis, kg (kg m^2).
        damping: Of the joint, N s/m (N m s/rad).
        firm: Whether `solimpfriction` is as `mjcf` sets it.
    """
    at_rest, most = (_FIRM_D, _FIRM_D) if firm else (_D_0, _D_WIDTH)
    mobility = (1.0 - at_rest) / at_rest * most * _TIME_CONSTANT / 2.0 / inertia
    return force * mobility / (1.0 + damping * mobility)


def _check_root(file: JointFile) -> None:
    name = file.root.name
    if name == "robot":
        raise InputError("is URDF (its root is <robot>), not MJCF: export to urdf")
    if name not in ("mujoco", "mujocoinclude"):
        raise InputError(f"is not MJCF: its root is <{name[:40]}>, it should be <mujoco>")


def _joints(file: JointFile) -> list[Tag]:
    """Joints of bodies; equality constraints, tendons and defaults have elements named so too."""
    return [
        tag
        for tag in file.named("joint", "freejoint")
        if tag.parent is not None and tag.parent.name in _BODIES
    ]


def _elsewhere(file: JointFile) -> str:
    """Where a joint may be that the file does not have."""
    if includes := file.named("include"):
        named = ", ".join(tag.attributes.get("file", "?") for tag in includes[:5])
        return f"its included files are not followed ({named}): patch the one that has the joint"
    if file.named("attach"):
        return "attached models are not followed: patch the file that has the joint"
    return ""


def _check_kind(file: JointFile, joint: Tag, *, rotary: bool) -> None:
    name, kind = joint.attributes["name"], _value(file, joint, "type") or _TURNS
    known = {tag.attributes.get("class") for tag in file.named("default")}
    if (
        "type" not in joint.attributes
        and (joint_class := _class(joint))
        and joint_class not in {"main", *known}
    ):
        raise InputError(
            f"line {joint.line}: joint {name!r} has class {joint_class[:40]!r}, which this file "
            "does not define: write type= on the joint"
        )
    if joint.name == "freejoint":
        kind = "free"
    if kind not in (_TURNS, _SLIDES):
        raise InputError(
            f"line {joint.line}: joint {name!r} is of type {kind[:40]}: friction of an axis goes "
            "into a hinge or a slide"
        )
    if rotary != (kind == _TURNS):
        card, fitting = ("N m", _TURNS) if rotary else ("N", _SLIDES)
        raise InputError(
            f"line {joint.line}: joint {name!r} is a {kind}, and the card is in {card}: it fits "
            f"a {fitting}"
        )
    if _value(file, joint, "springdamper") is not None:
        raise InputError(
            f"line {joint.line}: joint {name!r} has springdamper, by which MuJoCo replaces its "
            "damping: take it out first"
        )


def _value(file: JointFile, joint: Tag, name: str) -> str | None:
    """An attribute as MuJoCo reads it: the joint's own, or that of its class and those above it."""
    if name in joint.attributes:
        return joint.attributes[name]
    joint_class = _class(joint)
    sections = file.named("default")
    of_class = [
        tag
        for tag in sections
        if (tag.attributes.get("class") == joint_class if joint_class else not _inside_another(tag))
    ]
    while of_class:
        settings = [tag for tag in file.named("joint") if tag.parent in of_class]
        for tag in reversed(settings):  # what is said last holds
            if name in tag.attributes:
                return tag.attributes[name]
        above = of_class[0].parent
        if not _inside_another(of_class[0]):
            return None
        of_class = [tag for tag in sections if tag is above]
        if of_class and not _inside_another(of_class[0]):
            of_class = [tag for tag in sections if not _inside_another(tag)]
    return None


def _class(joint: Tag) -> str | None:
    """The class of defaults that a joint has, its own or its bodies'."""
    around = (tag.attributes.get("childclass") for tag in joint.around())
    return joint.attributes.get("class") or next(filter(None, around), None)


def _inside_another(default: Tag) -> bool:
    """Whether a class of defaults refines another one."""
    return default.parent is not None and default.parent.name == "default"


def _armature(model: Model) -> float:
    """The rotor's inertia, kg m^2."""
    for q, value in zip(model.parameters.every, model.values, strict=True):
        if q.name == "armature":
            return float(value)
    raise InputError(
        f"rig {model.rig.name} identifies no armature: what it has is the inertia of the whole "
        "axis, which the bodies of the file have already"
    )


def _creep(file: JointFile, joint: Tag, model: Model, to: Reduction, *, firm: bool) -> list[str]:
    """What the softness of the constraint does at rest."""
    mass = inertia(model.rig, model.law, model.values)
    overridden = any(_value(file, joint, name) for name in ("solreffriction", "solimpfriction"))
    if mass is None or overridden or not to["F_C"] > 0:
        return []
    units, half = RigUnits(model), 0.5 * to["F_C"]
    weight = "kg m^2" if model.rig.rotary else "kg"
    load = f"under half the level ({half:.3g} {units.force}) an axis of {mass:.3g} {weight}"
    speeds = {each: units.speed(creep(half, mass, to["F_V"], firm=each)) for each in (False, True)}
    sentence = f"at rest MuJoCo gives way: {load} creeps at {speeds[firm]}"
    if not firm:
        sentence += f', with solimpfriction="{_FIRM["solimpfriction"]}" at {speeds[True]}'
    return [sentence]


def _doubts(file: JointFile, joint: Tag) -> Iterator[str]:
    """What else in the file has a say in the friction of the joint."""
    name = joint.attributes["name"]
    for tag in file.named("flag"):
        for flag in ("frictionloss", "damper", "passive", "constraint"):
            if tag.attributes.get(flag) == "disable":
                yield f"the file switches {flag} off for all joints (line {tag.line}, <flag>)"
    if any(tag.name == "replicate" for tag in joint.around()):
        yield "the joint stands in <replicate>: each of its copies has this friction"
    for tag in file.named(*_ACTUATORS):
        if tag.attributes.get("joint") == name and "damping" in tag.attributes:
            yield (
                f"<{tag.name}> on line {tag.line} adds its own damping to the joint (MuJoCo 3.7 "
                "and later)"
            )
