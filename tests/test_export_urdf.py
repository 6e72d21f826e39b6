"""URDF: the joint's <dynamics> gets the card's friction, and not another byte changes."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from joint_models import hinge, slide, sticking
from stribeck.errors import InputError
from stribeck.export.robot.urdf import urdf

LINK = '<inertial><mass value="10"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
ROBOT = f"""<?xml version="1.0"?>
<robot name="rail">
  <link name="base"/>
  <link name="car">{LINK}</inertial></link>
  <link name="arm">{LINK}</inertial></link>
  <joint name="x" type="prismatic">
    <parent link="base"/>
    <child link="car"/>
    <axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="100" velocity="1"/>
  </joint>
  <joint name="turn" type="continuous">
    <parent link="car"/><child link="arm"/>
    <dynamics friction="9" damping='8'/>
  </joint>
  <transmission name="t"><joint name="x"><dynamics damping="1"/></joint></transmission>
</robot>
"""


def patched(text: str, joint: str = "x", model: Any = None) -> str:
    return urdf(model or slide(), text.encode(), joint)[0].decode()


def dynamics(text: str, joint: str) -> list[dict[str, str]]:
    """The dynamics of the robot's joint of this name, by another parser."""
    robot = ET.fromstring(text)  # noqa: S314
    (element,) = [e for e in robot.findall("joint") if e.get("name") == joint]
    return [dict(e.attrib) for e in element.findall("dynamics")]


# What is written.


def test_a_joint_without_dynamics_gets_them_on_a_line_of_their_own() -> None:
    file = patched(ROBOT)
    before = '<joint name="x" type="prismatic">\n'
    assert file == ROBOT.replace(
        before, f'{before}    <dynamics damping="40" friction="12.5"/>\n', 1
    )
    assert dynamics(file, "x") == [{"damping": "40", "friction": "12.5"}]
    assert dynamics(file, "turn") == dynamics(ROBOT, "turn")


def test_dynamics_that_are_there_get_other_values() -> None:
    file = patched(ROBOT, "turn", hinge())
    assert file == ROBOT.replace(
        "<dynamics friction=\"9\" damping='8'/>", "<dynamics friction=\"0.5\" damping='0.02'/>"
    )


#: The patched element, and the tags of the joint around it.
WRITTEN = '<dynamics damping="40" friction="12.5"/>'


def around(inside: str, tag: str = '<joint name="x" type="prismatic">') -> str:
    return f"<robot>{tag}{inside}</joint></robot>"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<robot><joint name='x' type='prismatic'/></robot>",
         around(WRITTEN, "<joint name='x' type='prismatic'>")),
        (around("", "<joint name='x' type='prismatic' >"),
         around(WRITTEN, "<joint name='x' type='prismatic' >")),
        (around("<dynamics></dynamics>"), around(WRITTEN.replace("/>", "></dynamics>"))),
        (around('<dynamics\n  friction="1"/>'),
         around('<dynamics\n  friction="12.5"\n  damping="40"/>')),
        (around("\r\n\t<!-- <dynamics/> --><axis/>"),
         around(f"\r\n\t{WRITTEN}\r\n\t<!-- <dynamics/> --><axis/>")),
    ],
    ids=["closes itself", "empty", "no attributes", "lines", "comment"],
)  # fmt: skip
def test_any_form_of_joint(text: str, expected: str) -> None:
    assert patched(text) == expected


NOISE = st.sampled_from(
    [
        "<!-- <joint name='x' type='prismatic'><dynamics/></joint> -->",
        "<![CDATA[<joint name='x'/>]]>",
        '<link name="a > b"/>',
        '<joint name="y" type="fixed"><dynamics damping="1"/></joint>',
        '<gazebo><joint name="x"><dynamics damping="3"/></joint></gazebo>',
        "\r\n\t",
        "é√",
    ]
)
INNER = st.sampled_from(
    ["<!-- <dynamics damping='1'/> -->", '<axis xyz="1 0 0"/>', "\r\n  ", "<mimic joint='y'/>",
     "<safety_controller k_velocity='1'><dynamics damping='5'/></safety_controller>"]
)  # fmt: skip
DYNAMICS = st.sampled_from(
    ["", "<dynamics/>", "<dynamics damping = '1' />", '<dynamics friction="2"\n></dynamics>',
     "<dynamics  friction='>' damping='0'/>"]
)  # fmt: skip


@settings(max_examples=200)
@given(
    st.lists(NOISE, max_size=4).map("".join),
    st.lists(INNER, max_size=3).map("".join),
    DYNAMICS,
    st.lists(INNER, max_size=3).map("".join),
    st.lists(NOISE, max_size=4).map("".join),
    st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
)
def test_all_bytes_outside_the_dynamics_stay_whatever_the_file(
    head: str, before: str, dynamics_tag: str, after: str, tail: str, encoding: str
) -> None:
    opens, closes = f"<robot>{head}<joint name='x' type='prismatic'>", f"</joint>{tail}</robot>"
    text = f"{opens}{before}{dynamics_tag}{after}{closes}"
    file = urdf(slide(), text.encode(encoding), "x")[0].decode(encoding)
    assert dynamics(file, "x") == [{"damping": "40", "friction": "12.5"}]
    if dynamics_tag:
        assert file.startswith(opens + before)
        assert file.endswith(after + closes)
    else:  # put in behind the blanks at the joint's beginning, which it repeats
        blank = re.match(r"\s*", before + after + "<").group()  # type: ignore[union-attr]
        assert file == f"{opens}{blank}{WRITTEN}{before}{after}{closes}"
    assert file.encode(encoding) == urdf(slide(), file.encode(encoding), "x")[0]


# Which joint.

XACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="axis" params="side">
    <joint name="${side}_x" type="prismatic"/>
    <joint name="y" type="${kind}"/>
    <joint name="z" type="prismatic"/>
  </xacro:macro>
</robot>"""


@pytest.mark.parametrize(
    ("text", "joint", "says"),
    [
        (ROBOT, "X", "has no joint 'X': there are x, turn"),
        (ROBOT, "turm", "did you mean 'turn'"),
        (ROBOT.replace('"turn"', '"x"'), "x", "has 2 joints named 'x', at line 6, line 12"),
        (ROBOT, "turn", "line 12: joint 'turn' is continuous, and the card is in N: it fits a pri"),
        (ROBOT.replace("prismatic", "fixed"), "x", "line 6: joint 'x' is of type fixed"),
        (ROBOT.replace("prismatic", "floating"), "x", "is of type floating"),
        (ROBOT.replace(' type="prismatic"', ""), "x", "is of type none"),
        (ROBOT.replace("<axis", "<dynamics/><dynamics/><axis"), "x", "2 <dynamics>, on lines 9, 9"),
        (XACRO, "left_x", "macros of xacro may make it: run `xacro FILE > robot.urdf`"),
        (XACRO, "y", "line 4: joint 'y': xacro has still to say its type"),
        ("<mujoco><joint name='x'/></mujoco>", "x", "is MJCF"),
        ("<sdf><joint name='x'/></sdf>", "x", "its root is <sdf>"),
        ('<robot xmlns:u="u"><u:joint name="x" type="prismatic"/></robot>', "x",
         "there are none; elements named <u:joint> are no joints"),
        ("<!DOCTYPE r [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]><robot>&b;</robot>", "x",
         "has a document type"),
        ("", "x", "is empty"),
        ("{}", "x", "not XML"),
    ],
)  # fmt: skip
def test_refusals(text: str, joint: str, says: str) -> None:
    with pytest.raises(InputError, match=re.escape(says)) as refused:
        patched(text, joint)
    assert "\n" not in str(refused.value)


def test_a_prismatic_joint_is_no_place_for_a_rotary_card() -> None:
    with pytest.raises(InputError, match="is prismatic, and the card is in N m: it fits a rev"):
        patched(ROBOT, "x", hinge())


def test_a_joint_of_a_macro_is_patched_with_a_word() -> None:
    file, notes = urdf(slide(), XACRO.encode(), "z")
    assert '<joint name="z" type="prismatic"><dynamics damping="40" friction="12.5"/>' in str(file)
    assert any("macro of xacro: each use of it" in line for line in notes)
    assert not any("macro" in line for line in urdf(slide(), ROBOT.encode(), "x")[1])


def test_a_joint_that_mimics_is_said_to() -> None:
    text = ROBOT.replace('<axis xyz="1 0 0"/>', '<mimic joint="turn"/>')
    assert any("mimics" in line for line in urdf(slide(), text.encode(), "x")[1])
    assert not any("mimics" in line for line in urdf(slide(), ROBOT.encode(), "x")[1])


def test_what_is_lost_is_said_as_for_mujoco() -> None:
    notes = "\n".join(urdf(sticking(), ROBOT.encode(), "x")[1])
    assert "static friction of 20 N is not held" in notes
    assert "creeps" not in notes  # that is MuJoCo's own


def test_mujoco_reads_what_was_written() -> None:
    mujoco = pytest.importorskip(
        "mujoco", reason="mujoco is not installed: pip install 'stribeck[export]'"
    )
    text = patched(patched(ROBOT), "turn", hinge())
    model = mujoco.MjModel.from_xml_string(text)
    for joint, level, damping in (("x", 12.5, 40.0), ("turn", 0.5, 0.02)):
        assert model.joint(joint).frictionloss[0] == level
        assert model.joint(joint).damping[0] == damping
