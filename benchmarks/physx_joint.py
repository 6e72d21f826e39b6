"""Exported friction in PhysX, beside our own simulation of the card.

    python benchmarks/physx_joint.py          measure, and write physx_joint.json beside this file
    python benchmarks/physx_joint.py --show   its table

The slide and the hinge of `simulators.py`, each a joint of a USD stage under the layer of `export
--to usd`, moved by PhysX itself on the CPU. It needs `pip install ovphysx physx-usd-schemas` beside
the extra `usd`.
"""

from __future__ import annotations

import json
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import simulators
from run import plain
from stribeck.export import export

RESULTS = Path(__file__).with_suffix(".json")
#: PhysX's step, s.
STEP = 0.002
STAGE = """#usda 1.0
(
    defaultPrim = "rig"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)
def PhysicsScene "scene"
{{
    vector3f physics:gravityDirection = (0, 0, -1)
    float physics:gravityMagnitude = 0
}}
def Xform "rig" (prepend apiSchemas = ["PhysicsArticulationRootAPI", "PhysxArticulationAPI"])
{{
    float physxArticulation:sleepThreshold = 0
    def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {{
        float physics:mass = 1
        float3 physics:diagonalInertia = (1, 1, 1)
    }}
    def Xform "body" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI",
                                           "PhysxRigidBodyAPI"])
    {{
        float physics:mass = {inertia}
        float3 physics:diagonalInertia = ({inertia}, {inertia}, {inertia})
        float physxRigidBody:angularDamping = 0
        float physxRigidBody:linearDamping = 0
    }}
    def PhysicsFixedJoint "ground"
    {{
        rel physics:body1 = </rig/base>
    }}
    def {kind} "axis"
    {{
        uniform token physics:axis = "Z"
        rel physics:body0 = </rig/base>
        rel physics:body1 = </rig/body>
    }}
}}
"""
KINDS = {"slide": "PhysicsPrismaticJoint", "hinge": "PhysicsRevoluteJoint"}


class Joint:
    """A joint of a stage in PhysX, moved step by step."""

    def __init__(self, physx: Any, file: Path) -> None:
        import ovstage  # noqa: PLC0415 - needed for this benchmark alone
        from ovphysx.types import TensorType  # noqa: PLC0415 - the same

        self._physx, self._stage = physx, ovstage.Stage(file.parent.name)
        ovstage.population.open_usd(
            self._stage, str(file), ordinal=1, domains=ovstage.PopulationDomain.ALL
        )
        self._stage.advance_write_floor(ordinal=1).wait()
        physx.wait_task(physx.attach_ovstage(self._stage, read_ordinal=1))
        physx.wait_all()
        self._tensors = {
            name: physx.create_tensor_binding(
                pattern="/rig*", tensor_type=getattr(TensorType, f"ARTICULATION_DOF_{name}")
            )
            for name in ("POSITION", "VELOCITY", "ACTUATION_FORCE", "FRICTION_PROPERTIES")
        }

    def read(self, name: str) -> np.ndarray:
        """A quantity of the joint."""
        tensor = self._tensors[name]
        values = np.zeros(tensor.shape, np.float32)
        tensor.read(values)
        return values.ravel()

    def write(self, name: str, value: float) -> None:
        """Set a quantity of the joint."""
        tensor = self._tensors[name]
        tensor.write(np.full(tensor.shape, value, np.float32))

    def step(self, force: float) -> tuple[float, float]:
        """Position and velocity after a step under a force."""
        self.write("ACTUATION_FORCE", force)
        self._physx.step(STEP)
        self._physx.wait_all()
        return float(self.read("POSITION")[0]), float(self.read("VELOCITY")[0])

    def close(self) -> None:
        """Leave the stage."""
        self._physx.wait_task(self._physx.detach_ovstage())
        self._stage.destroy()


def motions(axis: simulators.Axis, joint: Joint, static: float) -> dict[str, float]:
    """The motions of `simulators.py`."""

    def run(spring: float, span: float, v0: float, force: float) -> tuple[np.ndarray, np.ndarray]:
        joint.write("VELOCITY", v0)
        joint.write("POSITION", 0.0)
        x, steps = [(0.0, v0)], round(span / STEP)
        for i in range(steps):
            x.append(joint.step(force + spring * (axis.pull * STEP * i - x[-1][0])))
        return np.array(x).T  # type: ignore[return-value]

    x, _ = run(axis.spring, simulators.PULL, 0.0, 0.0)
    stretch = axis.pull * STEP * np.arange(len(x)) - x
    return {
        "breakaway": axis.spring * float(stretch.max()),
        "jump": float(np.ptp(stretch[len(stretch) // 2 :])),
        "stop": float(run(0.0, 2.0, axis.coast, 0.0)[0][-1]),
        "speed": float(run(0.0, simulators.FREE, 0.1 * axis.coast, axis.push)[1][-1]),
        "creep": float(run(0.0, simulators.HOLD, 0.0, 0.5 * static)[0][-1]),
    }


def measure() -> dict[str, Any]:
    """The motion of each axis under each law."""
    import ovphysx  # noqa: PLC0415 - needed for this benchmark alone
    import ovstage  # noqa: PLC0415 - the same
    from ovphysx.samples.python_samples.schema_support import (  # noqa: PLC0415 - the same
        physx_schema_paths,
    )

    warnings.simplefilter("ignore", DeprecationWarning)  # of its tensors
    ovphysx.PhysX.set_cpu_mode(True)
    physx = ovphysx.PhysX()
    schemas = [*physx_schema_paths(), ovphysx.newton_schema_root()]
    ovstage.population.register_usd_schemas([str(path) for path in schemas])
    rows = []
    for axis in simulators.AXES:
        for law in simulators.LAWS:
            model = simulators.card_model(axis, law)
            ours = {"who": "ours", **simulators.our_motions(axis, model)}
            with tempfile.TemporaryDirectory() as folder:
                stage = Path(folder, "stage.usda")
                stage.write_text(STAGE.format(inertia=axis.inertia, kind=KINDS[axis.joint]))
                (layer,) = export(model, "usd", joint="axis", into=stage).write(
                    stage.with_name("f")
                )
                joint = Joint(physx, layer)
                read = [float(value) for value in joint.read("FRICTION_PROPERTIES")]
                theirs = {"who": "PhysX", **motions(axis, joint, model.law.levels(model.p)[1])}
                joint.close()
            rows += [
                {"axis": axis.name, "law": law, **ours},
                {"axis": axis.name, "law": law, "read": read, **theirs},
            ]
    return {"engine": f"PhysX (ovphysx {ovphysx.__version__}) at time steps", "rows": rows}


def main() -> None:
    """Measure, or show what was measured."""
    if "--show" not in sys.argv[1:]:
        RESULTS.write_text(json.dumps(measure(), indent=1) + "\n", encoding="utf-8")
    for table in simulators.tables(json.loads(RESULTS.read_text(encoding="utf-8"))):
        print(plain(table))


if __name__ == "__main__":
    main()
