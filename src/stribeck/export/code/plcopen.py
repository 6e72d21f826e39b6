"""PLCopen XML (TC6, version 2.01): the units of the Structured Text as a project to import.

The same units as in `st`: what they declare as typed variables, what they do as the same text.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

from ..._version import __version__
from ...compensate.compensator import Compensator
from ..model import Model
from .ascii_text import ascii_text
from .pou import ProgramUnit, Variable, program_units
from .st import harmless, head

#: Namespaces of the schema and of what formatted text is written in.
TC6, XHTML = "http://www.plcopen.org/xml/tc6_0201", "http://www.w3.org/1999/xhtml"
#: The schema wants a date; the same card gives the same file, so it is not today's.
_DATE = "1970-01-01T00:00:00"
_POU = {"FUNCTION": "function", "FUNCTION_BLOCK": "functionBlock"}
_SECTIONS = (
    ("inputVars", "inputs"),
    ("inOutVars", "shared"),
    ("outputVars", "outputs"),
    ("localVars", "own"),
)
_ELEMENTARY = {"LREAL", "DINT", "BOOL"}


def plcopen(
    model: Model, name: str = "Friction", compensator: Compensator | None = None
) -> dict[str, bytes]:
    """PLCopen XML of a model.

    Args:
        model: What was identified.
        name: Of the file and the law's function block; what all other units begin with.
        compensator: Its settings; full feed-forward from the reference's velocity by default.

    Raises:
        InputError: a name that the language does not take, or a law that cannot be translated.
    """
    units = program_units(model, name, compensator)
    project = ET.Element("project", xmlns=TC6)
    ET.SubElement(
        project,
        "fileHeader",
        companyName="stribeck",
        productName="stribeck",
        productVersion=__version__,
        creationDateTime=_DATE,
    )
    header = ET.SubElement(project, "contentHeader", name=name)
    ET.SubElement(header, "Comment").text = "\n".join(harmless(line) for line in head(model))
    coordinates = ET.SubElement(header, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        ET.SubElement(ET.SubElement(coordinates, language), "scaling", x="1", y="1")
    types = ET.SubElement(project, "types")
    ET.SubElement(types, "dataTypes")
    pous = ET.SubElement(types, "pous")
    for unit in units:
        pous.append(_pou(unit))
    ET.SubElement(ET.SubElement(project, "instances"), "configurations")
    ET.indent(project)
    # A controller's text has its own line ends and blanks: it is put in after the indenting.
    for element, unit in zip(pous, units, strict=True):
        paragraph = element.find("body/ST/p")
        if paragraph is not None:
            paragraph.text = "\n".join(unit.body)
    written = ET.tostring(project, encoding="unicode")
    return {f"{name}.xml": f'<?xml version="1.0" encoding="utf-8"?>\n{written}\n'.encode()}


def _pou(unit: ProgramUnit) -> ET.Element:
    element = ET.Element("pou", name=unit.name, pouType=_POU[unit.kind])
    interface = ET.SubElement(element, "interface")
    if unit.kind == "FUNCTION":
        ET.SubElement(ET.SubElement(interface, "returnType"), unit.gives)
    for tag, section in _SECTIONS:
        variables: tuple[Variable, ...] = getattr(unit, section)
        if variables:
            listed = ET.SubElement(interface, tag)
            for variable in variables:
                listed.append(_variable(variable))
    if unit.says:
        interface.append(_documentation(unit.says))
    text = ET.SubElement(ET.SubElement(element, "body"), "ST")
    ET.SubElement(text, "p", xmlns=XHTML)
    return element


def _variable(variable: Variable) -> ET.Element:
    element = ET.Element("variable", name=variable.name)
    kind = ET.SubElement(element, "type")
    if variable.length is not None:
        kind = ET.SubElement(kind, "array")
        ET.SubElement(kind, "dimension", lower="0", upper=str(variable.length - 1))
        kind = ET.SubElement(kind, "baseType")
    if variable.type in _ELEMENTARY:
        ET.SubElement(kind, variable.type)
    else:
        ET.SubElement(kind, "derived", name=variable.type)
    if variable.initial is not None:
        ET.SubElement(ET.SubElement(element, "initialValue"), "simpleValue", value=variable.initial)
    if variable.says:
        element.append(_documentation(variable.says))
    return element


def _documentation(text: str) -> ET.Element:
    element = ET.Element("documentation")
    ET.SubElement(element, "p", xmlns=XHTML).text = _printable(ascii_text(text))
    return element


def _printable(text: str) -> str:
    """A text without what XML cannot say."""
    return re.sub(r"[^\t\n\x20-\x7e]", " ", text)
