"""What drives record of their torque, as their makers document it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..errors import InputError


@dataclass(frozen=True)
class Convention:
    """How a family of drives records its torque or current.

    Args:
        name: As a `[drive]` table names it.
        drives: Maker and family.
        object: The object, parameter or register that is recorded.
        table: What a chain takes over from it: the signal, and numbers that the maker fixes.
        needs: Numbers that are of the motor or its drive, and have to be stated.
        meaning: What a value is, in half a line.
        document: Where that stands.
        address: Of the document; empty where it has none.
        note: What else one must know; may be empty.
        examples: How the numbers that it needs are written, where that is special.
    """

    name: str
    drives: str
    object: str
    table: Mapping[str, str]
    needs: tuple[str, ...]
    meaning: str
    document: str
    address: str = ""
    note: str = field(default="", kw_only=True)
    examples: Mapping[str, str] = field(default_factory=dict, kw_only=True)


_TORQUE = {"signal": "‰ of rated torque"}
_INFOSYS = "https://infosys.beckhoff.com/content/1033"

_DECLARED = (
    Convention(
        "cia402-torque", "CiA 402 drives (IEC 61800-7-201)", "0x6077 torque actual value",
        _TORQUE, ("rated_torque",),
        "‰ of the motor rated torque, 0x6076, which is in mN m (mN for a linear motor)",
        "Synapticon, object dictionary 0x6076; Kollmorgen AKD CANopen, 7.7.2.5",
        "https://www.easymanua.ls/kollmorgen/akd/manual?p=102",
        note="makers differ in what they enter as 0x6076: look for yours first",
    ),
    Convention(
        "cia402-current", "CiA 402 drives (IEC 61800-7-201)", "0x6078 current actual value",
        {"signal": "‰ of rated current"}, ("rated_current", "kt"),
        "‰ of the motor rated current, 0x6075, which is in mA, of direct current, rms or peak, "
        "as the drive has it",
        "Elmo, CANopen DSP 402 guide, object 0x6075; Bonfiglioli CM-EtherCAT, 12.5.26",
        "https://www.manualsdir.com/manuals/558390/elmomc-canopen-dsp-402-implementation-guide.html?page=112",
    ),
    Convention(
        "akd", "Kollmorgen AKD", "0x6077 torque actual value", _TORQUE, ("rated_torque",),
        "‰ of the rated torque", "AKD CANopen, 7.7.2.5",
        "https://www.easymanua.ls/kollmorgen/akd/manual?p=102",
    ),
    Convention(
        "amk", "AMK", "0x6077 torque actual value", _TORQUE, ("rated_torque",),
        "0.1 % of the rated torque M_N; the drive is off by up to 3 % of it",
        "PDK 206016 DS402 Standard, 0x6077",
        "https://doku.amk-motion.com/en/Subsystems/PDK_206016_DS402_Standard_en/",
    ),
    Convention(
        "ax2000", "Beckhoff AX2000-B750", "IDN 84 with scaling IDN 86",
        {"signal": "‰ of rated current"}, ("rated_current", "kt"),
        "0.1 % of the motor's continuous current, IDN 111",
        "AX2000-B750, IDN 86 torque/force data scaling type",
        f"{_INFOSYS}/ax2000-b750/15064264971.html",
    ),
    Convention(
        "ax5000", "Beckhoff AX5000, firmware 2.10 and later", "S-0-0084 torque feedback value",
        {"signal": "‰ of peak torque"}, ("peak_torque",),
        "0.1 % of the configured channel peak torque, P-0-0094",
        "AX5000 IDN description, S-0-0084 and P-0-0094",
        f"{_INFOSYS}/ax5000_idn_description/1453062027.html",
    ),
    Convention(
        "ax5000-current", "Beckhoff AX5000", "P-0-0459 actual torque generating current; S-0-0084 "
        "before firmware 2.10",
        {"signal": "‰ of peak current"}, ("peak_current", "kt"),
        "0.1 % of the configured channel peak current, P-0-0092",
        "AX5000 IDN description, P-0-0459 and S-0-0084",
        f"{_INFOSYS}/ax5000_idn_description/1226373003.html",
    ),
    Convention(
        "ax8000", "Beckhoff AX8000, AMP8000", "0x6077 torque/force actual value",
        {"signal": "‰ of standstill torque"}, ("standstill_torque",),
        "0.1 % of the motor's standstill torque M_0, 0x6076",
        "AX8xxx object description, 6077", f"{_INFOSYS}/ax8xxx_object/18798585483.html",
    ),
    Convention(
        "active-cube", "Bonfiglioli Active Cube", "0x6077 torque actual value",
        _TORQUE, ("rated_torque",), "1000 is the rated motor torque",
        "CM-EtherCAT, 12.5.25", "https://manualshive.com/ru/manual/bonfiglioli-vectron/"
        "active-cube-series/2787057?page=90",
    ),
    Convention(
        "dynamixel-xl330", "Robotis Dynamixel XL330", "present current (126)",
        {"signal": "counts", "scale": "1 mA"}, ("kt",), "counts of 1 mA",
        "e-Manual XL330-M288, control table", "https://emanual.robotis.com/docs/en/dxl/x/xl330-m288/",
        note="speed in counts of 0.229 r/min, position 4096 counts a turn",
        examples={"kt": "0.52 N m/A ± 5 %"},
    ),
    Convention(
        "dynamixel-xm430", "Robotis Dynamixel XM430", "present current (126)",
        {"signal": "counts", "scale": "2.69 mA"}, ("kt",), "counts of about 2.69 mA",
        "e-Manual XM430-W350, current limit (38), goal current (102), present current (126)",
        "https://emanual.robotis.com/docs/en/dxl/x/xm430-w350/",
        examples={"kt": "0.52 N m/A ± 5 %"},
    ),
    Convention(
        "el72x1-peak", "Beckhoff EL72x1, EP7211 with 0x2002:54 = 0", "0x6077 torque actual value",
        {"signal": "‰ of rated current"}, ("rated_current", "kt"),
        "0.1 % of the rated current, which is a peak value; kt, 0x2003:16, is of rms: "
        "M = value/1000 · rated current/√2 · kt",
        "EL72x1, input/output data, 2001:11", f"{_INFOSYS}/el72x1/1976658571.html",
        examples={"rated_current": "2.4 A peak"},
    ),
    Convention(
        "el72x1-rms", "Beckhoff EL72x1, EP7211 with 0x2002:54 = 1", "0x6077 torque actual value",
        {"signal": "‰ of rated current"}, ("rated_current", "kt"),
        "0.1 % of the rated current, which is an rms value: M = value/1000 · rated current · kt",
        "EL72x1, input/output data, 2001:11", f"{_INFOSYS}/el72x1/1976658571.html",
    ),
    Convention(
        "lenze-i700", "Lenze i700", "0x6071 torque demand", _TORQUE, ("rated_torque",),
        "0.1 %; 100 % is the rated motor torque, 0x6076",
        "i700 reference manual DMS 3.0, 7.10", "https://www.easymanua.ls/lenze/i700/manual?p=235",
    ),
    Convention(
        "mecademic", "Mecademic Meca500, MCS500", "GetRtTargetJointTorq",
        {"signal": "% of peak torque"}, ("peak_torque",),
        "% of the greatest torque allowed, joint by joint, and calculated",
        "Programming manual 11.3, GetRtTargetJointTorq",
        "https://resources.mecademic.com/en/doc/MC-PM-MECA500/11.3/manual/rt-data_commands/"
        "GetRtTargetJointTorq.html",
    ),
    Convention(
        "mitsubishi-mr", "Mitsubishi MR-J4, MR-J5 (MR Configurator)", "instantaneous torque",
        {"signal": "% of rated torque"}, ("rated_torque",), "% of the rated torque",
        "MR-J4 instruction manual, 14.4.1 (the item); its unit as recorded by MR Configurator in "
        "K. Mnich, friction-identification, a3MR.csv",
        "https://manualshive.com/en/manual/mitsubishi-electric/mr-j4/238382?page=539",
    ),
    Convention(
        "mr-j2s-analog", "Mitsubishi MR-J2S-A", "analog output, generated torque",
        {"signal": "V"}, ("scale",), "8 V is the maximum torque",
        "MR-J2S-A instruction manual, 5.2.2",
        "http://www.manualsdir.com/manuals/121327/mitsubishi-electronics-melservo-mr-j2s-a.html",
        note="scale is the maximum torque over 8 V",
        examples={"scale": "0.48 N m/V"},
    ),
    Convention(
        "moteus-current", "mjbots moteus", "register 0x004 Q current", {"signal": "A"}, ("kt",),
        "current of the q axis, A", "moteus protocol, register 0x004",
        "https://docs.rs/moteus-protocol/latest/moteus_protocol/register/enum.Register.html",
        examples={"kt": "0.52 N m/A ± 5 %"},
    ),
    Convention(
        "moteus-torque", "mjbots moteus", "register 0x003 torque", {"signal": "N m"}, (),
        "torque, N m", "moteus protocol, register 0x003",
        "https://docs.rs/moteus-protocol/latest/moteus_protocol/register/enum.Register.html",
    ),
    Convention(
        "nanotec", "Nanotec PD, PxA", "0x6077 torque actual value", _TORQUE, ("rated_torque",),
        "‰ of the rated torque, which is that at the rated current 0x203B:01",
        "Object dictionary, 6077h torque actual value",
        "https://us.nanotec.com/products/manual/PD4E_USB_EN/object_dictionary%252Fod_motion_0x6077.html/",
    ),
    Convention(
        "odrive", "ODrive", "Iq measured", {"signal": "A"}, ("kt",),
        "current of the q axis, A; kt = 8.27/KV N m/A, KV in r/min per V",
        "ODrive documentation, motor current and torque estimation",
        "https://docs.odriverobotics.com/v/latest/manual/overview.html",
        examples={"kt": "0.52 N m/A ± 5 %"},
    ),
    Convention(
        "panasonic-minas-e", "Panasonic MINAS E", "readout of current torque output (2, 5)",
        {"signal": "counts"}, ("scale",), "2000 is the rated torque",
        "MINAS E-series manual, communication command 2, mode 5",
        "http://www.manualsdir.com/manuals/180158/panasonic-minas-e-series.html?page=169",
        note="scale is the rated torque over 2000",
        examples={"scale": "0.00064 N m"},
    ),
    Convention(
        "smc-lecsn-t", "SMC LECSN-T", "0x6077 torque actual value", _TORQUE, ("rated_torque",),
        "0.1 %; 100 % is the rated torque", "LECSN-T manual, 18.5.4.8",
        "https://www.easymanua.ls/smc-networks/lecsn-t-series/manual?p=505",
    ),
    Convention(
        "universal-robots", "Universal Robots", "I actual (actual joint currents)",
        {"signal": "A"}, ("kt",), "current of the joint's motor; its size is not documented",
        "RealTime 5.10 (I actual)",
        "https://www.universal-robots.com/manuals/EN/HTML/SW5_25_1/Content/prod-clientinterfaces/"
        "RealTime5.10.htm",
        note="kt and gear are not published: friction stays in A, or kt comes from a known load",
        examples={"kt": "0.52 N m/A ± 5 %"},
    ),
    Convention(
        "yaskawa-sigma7", "Yaskawa Σ-7 (MECHATROLINK)", "TRQ monitor",
        {"signal": "% of rated torque"}, ("rated_torque",),
        "% of the rated torque times 10^n, n by common parameter 48 (by default); or counts of "
        "the maximum torque/0x40000000 by common parameter 47",
        "Σ-7 MECHATROLINK command manual, 2.7.2",
        "https://manualshive.com/en/manual/yaskawa/s-7-series/s-7-series_command-manual_3572116-65.html",
    ),
)  # fmt: skip

#: Known conventions by name.
CONVENTIONS: Mapping[str, Convention] = {c.name: c for c in _DECLARED}


def convention_named(name: str, place: str = "drives") -> Convention:
    """A convention by its name.

    Raises:
        InputError: there is none of that name.
    """
    if name not in CONVENTIONS:
        raise InputError(
            f"{place}: no drive convention {name!r}: there are {', '.join(CONVENTIONS)}"
        )
    return CONVENTIONS[name]
