"""USD: a card's friction as a layer over a joint of a user's stage.

A layer holds opinions about prims that other files define, so that a stage in text (.usda), binary
(.usdc) or of many files takes it alike. The attributes are those of two schemas:

- PhysX, `PhysxJointAxisAPI` (NVIDIA-Omniverse/PhysX, omni/schema/source/physxSchemaAddition/
  schema.usda): static and dynamic friction effort and a viscous coefficient of an axis, named
  `angular` on a revolute joint and `linear` on a prismatic one; read inside articulations alone;
- Newton, `NewtonJointAPI` (newton-usd-schemas 0.6.0, generatedSchema.usda): a level and a damping.

Efforts are in mass distance / s^2 (distance^2 for torques) of the stage's units, damping of
angular axes in effort second / degree.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import InputError
from .joint_file import number
from .reduction import Reduction, coulomb_viscous, static_coulomb_viscous
from .reduction_error import reduction_errors
from .usd_stage import StageJoint, StageUnits, stage_joint

if TYPE_CHECKING:
    from ..model import Model

#: What of a layer is not in SI.
_UNITS = "the attributes: units of the stage, degrees"


def usd(
    model: Model, joint: str, stage: Path | None = None, units: StageUnits | None = None
) -> tuple[bytes, list[str]]:
    """A USD layer in text, and what its friction does not hold of the card's.

    Args:
        model: The card's model.
        joint: The path of a joint's prim; with `stage` its name does.
        stage: The user's stage, read by usd-core: the layer lies over it, in its units.
        units: Of a stage that is not read; metres and kilograms where nothing is said.

    Raises:
        InputError: no path, or the stage cannot be read, has no such joint or one of another kind,
            or says its units itself.
    """
    if stage is None:
        target = StageJoint(_prim_path(joint), units or StageUnits(), {})
        fitting = f"{'revolute' if model.rig.rotary else 'prismatic'} joint {target.path}"
        si = f"{target.units.metres:g} m and {target.units.kilograms:g} kg"
        known = [
            f"the stage is not read: the layer does nothing where it has no {fitting}",
            f"the layer is for a stage of {si} a unit (metersPerUnit, kilogramsPerUnit)",
            "PhysX reads the friction of joints inside articulations alone",
        ]
    else:
        if units is not None:
            raise InputError("the stage says its units itself: leave metres and kilograms out")
        target = stage_joint(stage, joint, rotary=model.rig.rotary)
        known = [f"the layer lies over {stage.name}: keep it beside that file, open it instead"]
    physx = static_coulomb_viscous(model.law, model.p, model.speeds, rotary=model.rig.rotary)
    newton = coulomb_viscous(model.law, model.p, model.speeds, rotary=model.rig.rotary)
    notes = [
        *(f"PhysX: {each}" for each in reduction_errors(model, physx)),
        *(f"Newton: {each}" for each in reduction_errors(model, newton)),
        *known,
        *target.doubts,
    ]
    return _layer(model, target, stage, physx, newton).encode(), notes


def _prim_path(joint: str) -> str:
    names = joint.split("/")
    if len(names) > 1 and not names[0] and all(name.isidentifier() for name in names[1:]):
        return joint
    raise InputError(
        f"{joint!r} is no path of a prim, such as /robot/joints/elbow: write it, or give the stage "
        "to find the joint by its name"
    )


def _layer(
    model: Model, joint: StageJoint, stage: Path | None, physx: Reduction, newton: Reduction
) -> str:
    """The layer's text: its head, and one `over` inside another down to the joint."""
    rotary, units = model.rig.rotary, joint.units
    axis = "angular" if rotary else "linear"
    values = {
        f"physxJointAxis:{axis}:staticFrictionEffort": units.effort(physx["F_S"], rotary=rotary),
        f"physxJointAxis:{axis}:dynamicFrictionEffort": units.effort(physx["F_C"], rotary=rotary),
        f"physxJointAxis:{axis}:viscousFrictionCoefficient": units.damping(
            physx["F_V"], rotary=rotary
        ),
        "newton:friction": units.effort(newton["F_C"], rotary=rotary),
        "newton:damping": units.damping(newton["F_V"], rotary=rotary),
    }
    metadata = {
        "metersPerUnit": f"{units.metres:.17g}",
        "kilogramsPerUnit": f"{units.kilograms:.17g}",
        **joint.metadata,
    }
    if stage is not None:
        around = "@@@" if "@" in stage.name else "@"
        metadata["subLayers"] = f"[{around}./{stage.name}{around}]"
    names = joint.path[1:].split("/")
    lines = [f"float {name} = {number(value)}" for name, value in values.items()]
    apis = f'(\n    prepend apiSchemas = ["PhysxJointAxisAPI:{axis}", "NewtonJointAPI"]\n)'
    for depth, name in enumerate(reversed(names)):
        inside = "\n".join(f"    {line}" for line in "\n".join(lines).split("\n"))
        lines = [f'over "{name}" {apis}' if depth == 0 else f'over "{name}"', f"{{\n{inside}\n}}"]
    head = "\n".join(f"# {line}".rstrip() for line in model.head(_UNITS))
    fields = "\n".join(f"    {name} = {value}" for name, value in metadata.items())
    return "\n".join(["#usda 1.0", head, f"(\n{fields}\n)", "", *lines, ""])
