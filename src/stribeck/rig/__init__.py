"""Rigs, each one declaration. A new rig is a file and its name in `_DECLARED`."""

from collections.abc import Iterator, Mapping, MutableMapping
from importlib import import_module
from typing import cast

from ..constant import Constant
from .rig import Motion, Rig

__all__ = ["RIGS", "Constant", "Motion", "Rig"]

#: Every shipped rig, in the order in which people see them, and the file and the name in it that
#: declare it.
_DECLARED = {
    "slide-bed": "slide_bed.SLIDE_BED",
    "emps": "emps.EMPS",
    "forced": "forced.FORCED",
    "forced-rotary": "forced.FORCED_ROTARY",
    "forced-pendulum": "forced_pendulum.FORCED_PENDULUM",
    "cylinder": "cylinder.CYLINDER",
    "two-chambers": "two_chambers.TWO_CHAMBERS",
    "servo-pendulum": "servo_pendulum.SERVO_PENDULUM",
    "joint": "joint.JOINT_RIG",
    "presliding": "presliding.PRESLIDING",
    "presliding-rotary": "presliding.PRESLIDING_ROTARY",
}


class Rigs(MutableMapping[str, Rig]):
    """The rigs by name: the shipped ones, and those that a program adds.

    A shipped rig is loaded when it is taken, since its compiled code takes time.
    """

    def __init__(self, declared: Mapping[str, str]) -> None:
        self._rigs: dict[str, Rig | str] = dict(declared)

    def __getitem__(self, name: str) -> Rig:
        rig = self._rigs[name]
        if isinstance(rig, str):
            file, _, constant = rig.partition(".")
            rig = cast("Rig", getattr(import_module(f".{file}", __name__), constant))
            self._rigs[name] = rig
        return rig

    def __setitem__(self, name: str, rig: Rig) -> None:
        self._rigs[name] = rig

    def __delitem__(self, name: str) -> None:
        del self._rigs[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rigs)

    def __len__(self) -> int:
        return len(self._rigs)

    def __contains__(self, name: object) -> bool:
        return name in self._rigs


RIGS = Rigs(_DECLARED)
