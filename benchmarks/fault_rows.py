"""The perturbations of the fault table: of logs, machines, constants and arithmetic, and none.

A row says how the axis differs from what its rig assumes. Each is one `Row`; `ROWS` lists them.
"""

from __future__ import annotations

import numpy as np

import foreign_path  # noqa: F401 - before what it finds
from fault_row import (
    BACKLASH,
    CLIP,
    CLOCK,
    COARSE,
    CONSTANTS,
    FEW,
    FILTER,
    FROZEN,
    GAIN,
    GAP,
    HOLD,
    LATE,
    LOAD,
    MODEL,
    OUTLIER,
    PLACE,
    RECURS,
    RESET,
    RIPPLE,
    SCATTER,
    SET,
    SIDES,
    SPEED,
    STEP,
    TIME,
    WANDER,
    WRAP,
    Row,
    fault,
)
from foreign import cylinder, driven, joint, presliding, servo, slide_bed
from foreign.friction import Curve, coulomb_viscous
from foreign_axes import SPEEDS

# --- force balances -------------------------------------------------------------------------------

STRIBECK_SLIDE = Curve(30.0, 20.0, 60.0, 0.05)


def _with(**extras: float) -> dict[str, driven.Extras]:
    return {"extras": driven.Extras(**{"offset": 3.0} | extras)}


def _swing(**extras: float) -> dict[str, driven.Extras]:
    return {"extras": driven.Extras(**{"offset": 0.1, "g_sin": 2.0, "g_cos": 0.5} | extras)}


SLIDE = [
    Row("forced", "", seeds=5),
    Row("forced", "force clipped at 38 N", CLIP, fault("clipped", "force", limit=38.0)),
    Row("forced", "force clipped at 60 N", CLIP, fault("clipped", "force", limit=60.0)),
    *(
        Row("forced", f"force clipped at 38 N, then noise of {sd:g} N", CLIP,
            fault("clipped", "force", limit=38.0) + fault("noisy", "force", sd=sd))
        for sd in (0.5, 2.0)
    ),
    *(
        Row("forced", f"force {1e3 * s:g} ms late", LATE, fault("delayed", "force", seconds=s))
        for s in (3e-3, 10e-3, 25e-3, 50e-3, 150e-3, -10e-3)
    ),
    *(
        Row("forced", f"slow tones, force {1e3 * s:g} ms late", LATE,
            fault("delayed", "force", seconds=s), machine={"tones": 0.06}, standing=True)
        for s in (3e-3, 6e-3, -3e-3)
    ),
    Row("forced", "clock of the force drifts by 10 ms", CLOCK,
        fault("drifting", "force", first=0.0, last=10e-3)),
    Row("forced", "clock of the force drifts by 50 ms", CLOCK,
        fault("drifting", "force", first=0.0, last=50e-3)),
    Row("forced", "force filtered at 5 Hz", FILTER, fault("low_passed", "force", cutoff=5.0)),
    Row("forced", "force filtered at 20 Hz", FILTER, fault("low_passed", "force", cutoff=20.0)),
    Row("forced", "position filtered at 10 Hz", FILTER,
        fault("low_passed", "position", cutoff=10.0)),
    Row("forced", "force renewed every 20 ms", HOLD, fault("held", "force", period=20e-3)),
    Row("forced", "position in steps of 0.1 mm", COARSE, fault("quantised", "position", step=1e-4)),
    Row("forced", "position in steps of 1 mm", COARSE, fault("quantised", "position", step=1e-3)),
    Row("forced", "position wraps at 50 mm", WRAP,
        fault("wrapped", "position", low=0.0, high=0.05)),
    Row("forced", "encoder reset at 6 s", RESET, fault("reset", "position", at=6.0, to=0.2)),
    Row("forced", "position jumps by 5 mm at 6 s", RESET,
        fault("jumped", "position", at=6.0, by=5e-3)),
    Row("forced", "position frozen from 3 to 3.6 s", FROZEN,
        fault("frozen", "position", start=3.0, stop=3.6)),
    Row("forced", "force frozen from 3 to 4.5 s", FROZEN,
        fault("frozen", "force", start=3.0, stop=4.5)),
    Row("forced", "rows missing from 4 to 4.6 s", GAP, fault("gap", start=4.0, stop=4.6)),
    Row("forced", "outliers of 20 mm in 0.1 % of the positions", OUTLIER,
        fault("outlying", "position", share=1e-3, size=0.02)),
    Row("forced", "outliers of 300 N in 0.5 % of the forces", OUTLIER,
        fault("outlying", "force", share=5e-3, size=300.0)),
    Row("forced", "force sensor's zero jumps by 6 N at 8 s", RESET + "|" + TIME,
        fault("jumped", "force", at=8.0, by=6.0)),
    Row("forced", "force sensor shows 0.9 of the force", GAIN, fault("scaled", "force", gain=0.9),
        standing=True),
    Row("forced", "ripple of 6 N at 997 Hz on the force", RIPPLE,
        fault("aliased", "force", amplitude=6.0, frequency=997.0)),
    Row("forced", "friction with 200 v^2", SPEED, machine=_with(square=200.0)),
    Row("forced", "a Stribeck drop of 10 N under Coulomb", SPEED,
        machine={"plus": STRIBECK_SLIDE}),
    Row("forced", "cogging of 6 N every 10 mm", PLACE,
        machine=_with(cogging=6.0, cogging_period=0.01)),
    Row("forced", "friction waves by 30 % every 20 mm", PLACE,
        machine=_with(wave=0.3, wave_period=0.02)),
    Row("forced", "a spring of 150 N/m", PLACE, machine=_with(spring=150.0)),
    Row("forced", "friction warms up: 30 % more at first", TIME,
        machine=_with(warming=0.3, warming_time=6.0)),
    Row("forced", "25 % more friction to the left", SIDES,
        machine={"minus": coulomb_viscous(25.0, 90.0)}),
    Row("forced", "backlash of 1 mm before the encoder", BACKLASH,
        fault("played", "position", width=1e-3)),
    Row("forced", "a neighbour pulls with 8 N at 0.37 Hz", LOAD,
        fault("aliased", "force", amplitude=8.0, frequency=0.37)),
    Row("forced", "3 kg are loaded at 8 s", LOAD, fault("loaded", "force", mass=3.0, at=8.0)),
    Row("forced", "3 kg come and go every 4 s", LOAD,
        fault("fetched", "force", mass=3.0, stays=4.0)),
    Row("forced", "friction wanders by 4 N in 15 s", WANDER,
        fault("wandered", "force", size=4.0, seconds=15.0), machine={"speeds": SPEEDS * 3}),
    Row("forced", "4 kg are carried to the right only", RECURS,
        fault("carried", "force", mass=4.0)),
    Row("forced", "4 N more friction while braking", RECURS, fault("braked", "force", size=4.0)),
    Row("forced", "a tool pushes with 8 N, rightward, between 30 and 60 mm", RECURS,
        fault("pushed", "force", size=8.0, low=0.03, high=0.06)),
    Row("forced", "hysteresis of 4 N in the force sensor", BACKLASH + "|" + RECURS,
        fault("played", "force", width=4.0)),
    *(Row("forced", f"{n} set to its value", values={n: 1.0}, seeds=5) for n in ("M", "F_V")),
    Row("forced", "M set to two thirds of its value", SET, values={"M": 2 / 3}),
    Row("forced", "M set to 1.1 times its value", SET, values={"M": 1.1}),
    Row("forced", "F_V set to 1.3 times its value", SET, values={"F_V": 1.3}),
    Row("forced", "one speed", FEW, machine={"speeds": (0.15,) * 5}),
    Row("forced", "one way", SIDES, machine={"one_way": True}),
]  # fmt: skip

SWING = [
    Row("forced_pendulum", "", seeds=5),
    *(
        Row("forced_pendulum", f"torque {1e3 * s:g} ms late", LATE,
            fault("delayed", "force", seconds=s))
        for s in (10e-3, 40e-3)
    ),
    Row("forced_pendulum", "torque clipped at 2 N m", CLIP, fault("clipped", "force", limit=2.0)),
    Row("forced_pendulum", "torque clipped at 2 N m, then noise of 0.03 N m", CLIP,
        fault("clipped", "force", limit=2.0) + fault("noisy", "force", sd=0.03)),
    Row("forced_pendulum", "friction with 0.1 w^2", SPEED, machine=_swing(square=0.1)),
    Row("forced_pendulum", "a Stribeck drop of 0.4 N m under Coulomb", SPEED,
        machine={"curve": Curve(0.9, 0.5, 0.2, 0.4)}),
    Row("forced_pendulum", "cogging of 0.15 N m every 0.1 rad", PLACE,
        machine=_swing(cogging=0.15, cogging_period=0.1)),
    Row("forced_pendulum", "a spring of 0.5 N m/rad", PLACE, machine=_swing(spring=0.5)),
    Row("forced_pendulum", "friction warms up: 40 % more at first", TIME,
        machine=_swing(warming=0.4, warming_time=10.0)),
    Row("forced_pendulum", "a neighbour pulls with 0.3 N m at 0.23 Hz", LOAD,
        fault("aliased", "force", amplitude=0.3, frequency=0.23)),
    Row("forced_pendulum", "angle wraps at 0.4 rad", WRAP,
        fault("wrapped", "position", low=0.4 - 2.0 * np.pi, high=0.4)),
    Row("forced_pendulum", "g_sin set to 0.8 times its value", SET, values={"g_sin": 0.8}),
]  # fmt: skip

CASCADE = [
    Row("emps", "", seeds=5),
    *(
        Row("emps", f"voltage {1e3 * s:g} ms late", LATE, fault("delayed", "voltage", seconds=s))
        for s in (5e-3, 20e-3)
    ),
    Row("emps", "voltage clipped at 3 V", CLIP, fault("clipped", "voltage", limit=3.0)),
    Row("emps", "voltage clipped at 3 V, then noise of 0.05 V", CLIP,
        fault("clipped", "voltage", limit=3.0) + fault("noisy", "voltage", sd=0.05)),
    Row("emps", "gtau 10 % too large", GAIN + "|gtau", constants={"gtau": 38.67}, standing=True),
    Row("emps", "a Stribeck drop of 20 N under Coulomb", SPEED,
        machine={"curve": Curve(40.0, 20.3935, 203.5034, 0.1)}),
    Row("emps", "position in steps of 1 mm", COARSE, fault("quantised", "position", step=1e-3)),
    Row("emps", "M set to 1.2 times its value", SET, values={"M": 1.2}),
]  # fmt: skip

ROD = [
    Row("rod", "", seeds=5),
    Row("rod", "force 15 ms late", LATE, fault("delayed", "force", seconds=15e-3)),
    Row("rod", "pressure sensor shows 1.1 of the pressure", GAIN + "|bore|pressure",
        fault("scaled", "pressure", gain=1.1), standing=True),
    Row("rod", "bore 10 % too small", GAIN + "|bore", machine={"known_bore": 0.0225},
        standing=True),
    Row("rod", "bore of another cylinder, left at its default", CONSTANTS + "|bore",
        machine={"axis": cylinder.Cylinder(20.0, 10.0, 300.0, 5e-5, 0.03, 2e-5, 3.0)},
        constants={"bore": None}, standing=True),
    Row("rod", "pressure frozen from 2 to 3 s", FROZEN,
        fault("frozen", "pressure", start=2.0, stop=3.0)),
    Row("rod", "force clipped at 200 N", CLIP, fault("clipped", "force", limit=200.0)),
    Row("rod", "force clipped at 200 N, then noise of 3 N", CLIP,
        fault("clipped", "force", limit=200.0) + fault("noisy", "force", sd=3.0)),
]  # fmt: skip

# --- simulated rigs -------------------------------------------------------------------------------

#: Factors on the breakaway level from slip to slip, 15 % of scatter.
SCATTERED = (1.0, 1.18, 0.84, 1.07, 0.93, 1.24, 0.79, 1.02, 1.12, 0.88)


def _bed(**constants: float) -> dict[str, slide_bed.Bed]:
    return {"constants": slide_bed.Bed(**constants)}


BED = [
    Row("bed", "", exact=True, seeds=5),
    Row("bed", "", seeds=5),
    *(
        Row("bed", f"F_fm of {F:g} N, the default of 23.5 N", CONSTANTS,
            machine=_bed(F_fm=F), standing=True,
            seeds=3)
        for F in (15.0, 20.0, 30.0)
    ),
    Row("bed", "F_fm of 40 N, beyond the default's tolerance", CONSTANTS, machine=_bed(F_fm=40.0),
        standing=True),
    Row("bed", "k_hat 10 % above the default", CONSTANTS, machine=_bed(k_hat_up=3850.0),
        standing=True),
    Row("bed", "k_hat 25 % above the default", CONSTANTS, machine=_bed(k_hat_up=4375.0),
        standing=True),
    Row("bed", "m twice the default", CONSTANTS, machine=_bed(m=21.8), standing=True),
    # A slide that lags a steady ramp is one of more friction: no log tells them apart.
    *(
        Row("bed", "position 100 ms late", LATE, fault("delayed", "position", seconds=0.1),
            exact=exact, standing=True)
        for exact in (True, False)
    ),
    Row("bed", "clock of the position drifts by 1 s", CLOCK,
        fault("drifting", "position", first=0.0, last=1.0), exact=True),
    Row("bed", "position filtered at 2 Hz", FILTER,
        fault("low_passed", "position", cutoff=2.0), exact=True),
    Row("bed", "position in steps of 3 mm", COARSE,
        fault("quantised", "position", step=3e-3), exact=True),
    Row("bed", "encoder reset at 30 s", RESET, fault("reset", "position", at=30.0, to=0.0),
        exact=True),
    Row("bed", "position frozen from 20 to 26 s", FROZEN,
        fault("frozen", "position", start=20.0, stop=26.0), exact=True),
    Row("bed", "rows missing from 20 to 24 s", GAP, fault("gap", start=20.0, stop=24.0),
        exact=True),
    Row("bed", "outliers of 30 mm in 0.3 % of the positions", OUTLIER,
        fault("outlying", "position", share=3e-3, size=0.03), exact=True),
    Row("bed", "breakaway scatters by 15 %", SCATTER, machine={"scatter": SCATTERED}, exact=True),
    Row("bed", "Gauss' exponent of 2 under 1", MODEL,
        machine={"curve": Curve(130.0, 60.0, 958.3, 5e-3, 2.0)}, exact=True),
    Row("bed", "a Stribeck drop under Coulomb", MODEL, machine={"law": "coulomb-viscous"},
        exact=True),
    Row("bed", "F_V set to its value", values={"F_V": 1.0}, exact=True, seeds=5),
    # A spring that is as much stiffer makes up for it: one log in two does not contest it.
    Row("bed", "F_V set to 1.2 times its value", f"{SET}|of F_V moves", values={"F_V": 1.2},
        exact=True, standing=True),
]  # fmt: skip


def _servo(**constants: float) -> dict[str, servo.Servo]:
    return {"axis": servo.Servo(**{"armature": 3e-3, "q_offset": 0.02} | constants)}


PENDULUM = [
    Row("pendulum", "", exact=True, seeds=5),
    Row("pendulum", "", seeds=5),
    Row("pendulum", "kp 10 % above what is set", CONSTANTS + "|kp", constants={"kp": 360.0},
        standing=True),
    Row("pendulum", "a supply of 7 V, the default of 7.4 V", CONSTANTS, machine=_servo(vin=7.0),
        constants={"vin": None}, standing=True),
    Row("pendulum", "duty 15 % above the default", CONSTANTS, machine=_servo(duty=0.0033),
        standing=True),
    Row("pendulum", "angle 1 ms late", LATE, fault("delayed", "position", seconds=1e-3),
        exact=True),
    Row("pendulum", "angle 30 ms late", LATE, fault("delayed", "position", seconds=0.03),
        exact=True),
    Row("pendulum", "angle filtered at 5 Hz", FILTER, fault("low_passed", "position", cutoff=5.0),
        exact=True),
    Row("pendulum", "a Stribeck drop under Coulomb", MODEL,
        machine={"bam": servo.Bam(0.02, 0.008, 0.03, 0.5)}, exact=True),
    Row("pendulum", "friction that grows with load under Coulomb", MODEL,
        machine={"bam": servo.Bam(0.02, 0.008, 0.0, 1.0, 1.0, 0.15, 0.15)}, exact=True),
    Row("pendulum", "k_t set to its value", values={"k_t": 1.0}, exact=True, seeds=3),
    *(
        Row("pendulum", f"{name} set to {times:g} times its value", SET, values={name: times},
            exact=exact)
        for exact in (True, False) for name, times in (("armature", 1.5), ("k_t", 1.2))
    ),
    Row("pendulum", "masses 20 % above the logged ones", "mass|constant|proportion|logs state",
        fault("scaled", "mass", gain=0.8), exact=True, standing=True),
]  # fmt: skip


def _arm(**constants: float) -> dict[str, joint.Joint]:
    arm = {"J": 0.2, "g_sin": 1.0, "g_cos": 2.0, "g_0": 0.3, "kp": 70.0, "kd": 4.4}
    return {"axis": joint.Joint(**arm | constants)}


ARM = [
    Row("arm", "", seeds=5),
    Row("arm", "kp and kd 15 % below those set", GAIN + "|kp", constants={"kp": 80.5, "kd": 5.06},
        standing=True),
    Row("arm", "kp 20 % above that set", GAIN + "|kp", constants={"kp": 56.0}, standing=True),
    Row("arm", "kp and kd left at their defaults", CONSTANTS + "|kp",
        constants={"kp": None, "kd": None}, standing=True),
    *(
        Row("arm", f"angle {1e3 * s:g} ms late", LATE, fault("delayed", "position", seconds=s))
        for s in (0.5e-3, 2e-3)
    ),
    Row("arm", "angle 20 ms late", LATE, fault("delayed", "position", seconds=0.02)),
    Row("arm", "torque held for a sample of 10 ms", HOLD, machine=_arm(hold=2.0)),
    Row("arm", "breakaway scatters by 15 %", SCATTER, machine={"scatter": SCATTERED}),
    Row("arm", "a neighbour pulls with 0.4 N m", LOAD, machine={"neighbour": 0.4}),
    Row("arm", "angle in steps of 5 mrad", COARSE, fault("quantised", "position", step=5e-3)),
    Row("arm", "corners: steps of the command", STEP, machine={"step": 0.2}),
    Row("arm", "F_V set to its value", values={"F_V": 1.0}, seeds=3),
    Row("arm", "F_V set to 1.5 times its value", SET, values={"F_V": 1.5}),
]  # fmt: skip

LUGRE = presliding.LuGre(1.2e6, 600.0, 18.0, 12.0, 2e-2, 50.0)

BRISTLES = [
    Row("bristles", "", seeds=5),
    Row("bristles", "", machine={"law": LUGRE, "name": "lugre"}, seeds=5),
    Row("bristles", "stiff: 1.2e7 N/m", STEP,
        machine={"law": presliding.dahl(1.2e7, 14.0, 50.0), "noise": 0.1e-6}),
    Row("bristles", "corners: triangles of force", STEP, machine={"corners": True}),
    Row("bristles", "force 5 ms late", LATE, fault("delayed", "force", seconds=5e-3)),
    Row("bristles", "force sensor shows 1.1 of the force", GAIN,
        fault("scaled", "force", gain=1.1), standing=True),
    Row("bristles", "position creeps by 4 um", TIME,
        fault("aliased", "position", amplitude=4e-6, frequency=0.06)),
    Row("bristles", "LuGre under Dahl", MODEL, machine={"law": LUGRE, "name": "dahl"}),
    Row("bristles", "force clipped at 9 N", CLIP, fault("clipped", "force", limit=9.0)),
    Row("bristles", "force clipped at 9 N, then noise of 0.1 N", CLIP,
        fault("clipped", "force", limit=9.0) + fault("noisy", "force", sd=0.1)),
    Row("bristles", "M set to its value", values={"M": 1.0}, seeds=3),
    Row("bristles", "M set to 1.3 times its value", SET, values={"M": 1.3}),
]  # fmt: skip

ROWS: tuple[Row, ...] = (*SLIDE, *SWING, *CASCADE, *ROD, *BED, *PENDULUM, *ARM, *BRISTLES)
