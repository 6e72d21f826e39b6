"""The description of a co-simulation unit: modelDescription.xml of FMI 2.0, and a page."""

from __future__ import annotations

import html
import re
from xml.etree import ElementTree as ET

from ..._version import __version__
from ...units import unit
from ..model import Model
from .axis import Axis, Value

#: The base units that FMI knows.
_BASES = frozenset({"kg", "m", "s", "A", "K", "mol", "cd", "rad"})
_FACTOR = re.compile(r"([A-Za-z]+)(?:\*\*(\d+))?")


def described(model: Model, axis: Axis, name: str, guid: str, sources: list[str]) -> bytes:
    """modelDescription.xml.

    Args:
        model: What was identified.
        axis: Its values.
        name: The model identifier.
        guid: What tells this unit from others.
        sources: Names of the C files that are compiled.
    """
    law, card = model.law, model.card
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=name,
        guid=guid,
        description=f"Axis of rig {card.rig} under friction of law {law.name}: {axis.motion}",
        version=card.software.get("stribeck", __version__),
        license="BSD-3-Clause",
        generationTool=f"stribeck {__version__}",
        variableNamingConvention="flat",
        numberOfEventIndicators="0",
    )
    simulated = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=name,
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    files = ET.SubElement(simulated, "SourceFiles")
    for source in sources:
        ET.SubElement(files, "File", name=source)
    units = ET.SubElement(root, "UnitDefinitions")
    for written in sorted({v.unit for v in axis.values} - {""}):
        powers = {base: str(n) for base, n in exponents(written).items()}
        ET.SubElement(ET.SubElement(units, "Unit", name=written), "BaseUnit", powers)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description="why a call failed")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize="0.01")
    variables = ET.SubElement(root, "ModelVariables")
    for reference, value in enumerate(axis.values):
        _variable(variables, reference, value)
    structure = ET.SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns"):
        element = ET.SubElement(structure, part)
        for i, value in enumerate(axis.values, 1):
            if value.role == "output":
                ET.SubElement(element, "Unknown", index=str(i))
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _variable(into: ET.Element, reference: int, value: Value) -> None:
    kinds = {
        "output": ("output", "continuous", "calculated"),
        "input": ("input", "discrete" if value.fixed else "continuous", None),
    }
    parameter = ("parameter", "fixed" if value.fixed else "tunable", "exact")
    causality, variability, initial = kinds.get(value.role, parameter)
    attributes = {"causality": causality, "variability": variability}
    if initial is not None:
        attributes["initial"] = initial
    element = ET.SubElement(
        into,
        "ScalarVariable",
        {
            "name": value.name,
            "valueReference": str(reference),
            "description": value.doc,
            **attributes,
        },
    )
    real = {"unit": value.unit} if value.unit else {}
    for word, number in (("min", value.low), ("max", value.high), ("start", value.start)):
        if number is not None:
            real[word] = repr(float(number)).replace("inf", "INF")
    ET.SubElement(element, "Real", real)


def exponents(written: str) -> dict[str, int]:
    """The powers of the base units in a unit; rad is one of them, as FMI has it."""
    above, *below = unit(written).dimension.replace(" ", "").split("/")
    powers: dict[str, int] = {}
    for part, sign in ((above, 1), *((b, -1) for b in below)):
        for base, power in _FACTOR.findall(part):
            if base in _BASES:
                powers[base] = powers.get(base, 0) + sign * int(power or 1)
    return {base: n for base, n in powers.items() if n}


def page(model: Model, axis: Axis, name: str) -> str:
    """The documentation: what the model says of itself, and its variables."""
    rows = "\n".join(
        f"<tr><td>{html.escape(v.name)}</td><td>{_role(v)}</td>"
        f"<td>{'' if v.start is None else f'{v.start:.10g}'}</td>"
        f"<td>{html.escape(v.unit)}</td><td>{html.escape(v.doc)}</td></tr>"
        for v in axis.values
    )
    head = html.escape("\n".join(model.head(whole=True)))
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{html.escape(name)}</title></head>
<body>
<h1>{html.escape(name)}</h1>
<p>{html.escape(axis.motion)}; {html.escape(axis.friction)}.</p>
<table>
<tr><th>variable</th><th></th><th>start</th><th>unit</th><th>meaning</th></tr>
{rows}
</table>
<pre>
{head}
</pre>
</body>
</html>
"""


def _role(value: Value) -> str:
    if value.role in ("output", "input"):
        return value.role
    return "fixed parameter" if value.fixed else "parameter"
