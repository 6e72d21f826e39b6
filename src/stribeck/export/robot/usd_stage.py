"""A joint of a user's USD stage, by OpenUSD's own library (usd-core).

The stage is composed as any program would, whatever files and formats it consists of.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from ...errors import InputError
from .joint_file import one_named

#: Joints of one axis, and what schemas call it.
_AXES = {"PhysicsRevoluteJoint": "angular", "PhysicsPrismaticJoint": "linear"}
#: What a root layer says for the whole stage, and what opens instead of it has to say again.
_METADATA = ("defaultPrim", "upAxis", "timeCodesPerSecond", "startTimeCode", "endTimeCode")
#: What adds to the friction of a joint, by its attribute; {} is the axis.
_BESIDE = {
    "drive:{}:physics:damping": "the damping of a drive, which acts beside the friction",
    "physxJoint:jointFriction": "PhysX's older friction, a share of the force transmitted",
}
#: Of an error of the library.
_LONGEST = 200


class StageUnits(NamedTuple):
    """What a unit of a stage is.

    Args:
        metres: Of distance, m: `metersPerUnit`.
        kilograms: Of mass, kg: `kilogramsPerUnit`.
    """

    metres: float = 1.0
    kilograms: float = 1.0

    def effort(self, value: float, *, rotary: bool) -> float:
        """A force of N or torque of N m, in the stage's units."""
        return value / (self.kilograms * self.metres ** (2 if rotary else 1))

    def damping(self, value: float, *, rotary: bool) -> float:
        """A damping of N s/m, or of N m s/rad: then per degree."""
        if rotary:
            return math.radians(self.effort(value, rotary=True))
        return value / self.kilograms


class StageJoint(NamedTuple):
    """A joint of a stage.

    Args:
        path: Of its prim, such as `/robot/joints/elbow`.
        units: Of the stage.
        metadata: What the head of a layer over the stage takes from it, as text by name.
        doubts: What else in the stage has a say in the friction of the joint, a sentence each.
    """

    path: str
    units: StageUnits
    metadata: dict[str, str]
    doubts: tuple[str, ...] = ()


def stage_joint(file: Path, joint: str, *, rotary: bool) -> StageJoint:
    """A joint by its name or the path of its prim, and what a layer over it has to know.

    Args:
        file: The stage's root layer.
        joint: Name or path.
        rotary: Whether it has to turn; else it has to slide.

    Raises:
        InputError: usd-core is not installed, the file is no stage, or the joint is not there,
            there more than once, of another kind, or part of an instance, which no layer changes.
    """
    try:
        from pxr import Tf, Usd, UsdPhysics, UsdUtils  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise InputError(
            "a stage is read by usd-core: pip install 'stribeck[usd]', or leave the stage out "
            "and give the path of the joint"
        ) from error
    if not file.is_file():
        raise InputError("no such file")
    diagnostics = UsdUtils.CoalescingDiagnosticDelegate()  # else the library prints them
    try:
        stage = Usd.Stage.Open(str(file))
    except Tf.ErrorException as error:
        raise InputError("OpenUSD reads no stage from it: is it the right file?") from error
    finally:
        diagnostics.TakeUncoalescedDiagnostics()
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    joints = [prim for prim in prims if prim.IsA(UsdPhysics.Joint)]
    paths = [str(prim.GetPath()) for prim in joints]
    names = paths if joint.startswith("/") else [prim.GetName() for prim in joints]
    prim = joints[one_named(names, joint, paths)]
    _check_kind(prim, rotary=rotary)
    doubts = list(_beside(prim, _AXES[prim.GetTypeName()]))
    if not any(each.HasAPI(UsdPhysics.ArticulationRootAPI) for each in prims):
        doubts.append("the stage has no articulation, and PhysX reads joint friction inside one")
    if missing := stage.GetCompositionErrors():
        first = " ".join(str(missing[0]).split())[:_LONGEST]
        doubts.append(f"the stage is not whole, {len(missing)} of its parts do not load: {first}")
    metadata = {
        name: _text(stage.GetMetadata(name))
        for name in _METADATA
        if stage.HasAuthoredMetadata(name)
    }
    units = StageUnits(stage.GetMetadata("metersPerUnit"), stage.GetMetadata("kilogramsPerUnit"))
    if not all(0 < each < math.inf for each in units):
        raise InputError(
            f"its units are of {units.metres} m and {units.kilograms} kg: correct them"
        )
    return StageJoint(str(prim.GetPath()), units, metadata, tuple(doubts))


def _check_kind(prim: Any, *, rotary: bool) -> None:
    where, kind = f"joint {prim.GetPath()}", prim.GetTypeName()
    if prim.IsInstanceProxy():
        raise InputError(
            f"{where} is part of an instance, which no layer changes: make it instanceable = false "
            "first"
        )
    if kind not in _AXES:
        raise InputError(
            f"{where} is a {kind}: friction of an axis goes into a {' or a '.join(_AXES)}"
        )
    if rotary != (_AXES[kind] == "angular"):
        card, fitting = ("N m", "angular") if rotary else ("N", "linear")
        (fits,) = (name for name, axis in _AXES.items() if axis == fitting)
        raise InputError(f"{where} is a {kind}, and the card is in {card}: it fits a {fits}")


def _beside(prim: Any, axis: str) -> Iterator[str]:
    """What else gives the joint a friction or a damping."""
    for name, words in _BESIDE.items():
        attribute = prim.GetAttribute(name.format(axis))
        if attribute and attribute.Get():
            yield f"the joint has {attribute.GetName()} = {attribute.Get():g}, {words}"


def _text(value: object) -> str:
    """A value of metadata as a layer writes it."""
    return json.dumps(value) if isinstance(value, str) else f"{value:.17g}"
