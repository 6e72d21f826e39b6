"""Rigs, each one declaration. A new rig is a file and its name in RIGS."""

from .cylinder import CYLINDER
from .emps import EMPS
from .forced import FORCED, FORCED_ROTARY
from .forced_pendulum import FORCED_PENDULUM
from .joint import JOINT_RIG
from .presliding import PRESLIDING, PRESLIDING_ROTARY
from .rig import Constant, Motion, Rig
from .servo_pendulum import SERVO_PENDULUM
from .slide_bed import SLIDE_BED

__all__ = ["RIGS", "Constant", "Motion", "Rig"]

RIGS: dict[str, Rig] = {
    rig.name: rig
    for rig in (
        SLIDE_BED,
        EMPS,
        FORCED,
        FORCED_ROTARY,
        FORCED_PENDULUM,
        CYLINDER,
        SERVO_PENDULUM,
        JOINT_RIG,
        PRESLIDING,
        PRESLIDING_ROTARY,
    )
}
