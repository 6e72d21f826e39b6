"""MJCF: the joint gets the card's friction, and not another byte of the file changes."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from joint_models import STRIBECK, hinge, model_of, slide, sticking
from stribeck.errors import InputError
from stribeck.export.model import as_model
from stribeck.export.robot.joint_file import JointFile
from stribeck.export.robot.mjcf import creep, mjcf
from stribeck.export.robot.reduction import coulomb_viscous
from stribeck.export.robot.spring_pull import spring_pull
from stribeck.friction import LAWS
from stribeck.rig.slide_bed import SLIDE_BED

PLAIN = """<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="car">
      <joint name="x" type="slide" axis="1 0 0"/>
      <geom type="sphere" size="0.1" mass="10"/>
      <body pos="0.3 0 0">
        <joint name="turn" axis="0 0 1"/>
        <geom type="sphere" size="0.1" mass="1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
WRITTEN = {"frictionloss": "12.5", "damping": "40"}


def patched(text: str, joint: str = "x", model: Any = None, **options: bool) -> str:
    file, _ = mjcf(model or slide(), text.encode(), joint, **options)
    return file.decode()


def attributes(text: str, joint: str) -> dict[str, str]:
    """Attributes of the one joint of this name, by another parser."""
    (element,) = [e for e in ET.fromstring(text).iter("joint") if e.get("name") == joint]  # noqa: S314
    return dict(element.attrib)


def in_body(joint: str) -> str:
    return PLAIN.replace('<joint name="x" type="slide" axis="1 0 0"/>', joint)


# What is written.


def test_a_joint_gets_level_and_damping_and_keeps_the_rest() -> None:
    file = patched(PLAIN)
    assert attributes(file, "x") == attributes(PLAIN, "x") | WRITTEN
    assert file == PLAIN.replace(
        'axis="1 0 0"/>', 'axis="1 0 0" frictionloss="12.5" damping="40"/>'
    )


def test_a_hinge_takes_a_rotary_card() -> None:
    file = patched(PLAIN, "turn", hinge())
    assert attributes(file, "turn") == {
        "name": "turn", "axis": "0 0 1", "frictionloss": "0.5", "damping": "0.02",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("tag", "expected"),
    [
        (
            '<joint damping="1" name="x"  frictionloss = "3" type="slide" />',
            '<joint damping="40" name="x"  frictionloss = "12.5" type="slide" />',
        ),
        (
            "<joint type='slide' name='x'></joint>",
            "<joint type='slide' name='x' frictionloss='12.5' damping='40'></joint>",
        ),
        (
            '<joint\n  name="x"\n  type="slide"\n/>',
            '<joint\n  name="x"\n  type="slide"\n  frictionloss="12.5"\n  damping="40"\n/>',
        ),
        (
            '<joint name="x" type="slide"><!-- 7 --></joint>',
            '<joint name="x" type="slide" frictionloss="12.5" damping="40"><!-- 7 --></joint>',
        ),
        (
            "<joint name=\"x\" type='slide'\tdamping='0.1 0.2'/>",
            "<joint name=\"x\" type='slide'\tdamping='40' frictionloss='12.5'/>",
        ),
        ('<joint name="&#120;" type="slide"/>',
         '<joint name="&#120;" type="slide" frictionloss="12.5" damping="40"/>'),
    ],
    ids=["there", "single quotes", "lines", "content", "mixed", "reference"],
)  # fmt: skip
def test_its_own_style_is_kept(tag: str, expected: str) -> None:
    assert patched(in_body(tag)) == in_body(expected)


def test_a_greater_sign_in_a_value_does_not_end_the_tag() -> None:
    tag = '<joint info="a > b \'c\' /> d" name="x" type="slide"/>'
    assert patched(in_body(tag)) == in_body(
        tag.replace("/>", "/>", 1).removesuffix("/>") + ' frictionloss="12.5" damping="40"/>'
    )


DECOYS = """<!-- <joint name="x" type="slide"/> -->
<?note <joint name="x"/> ?>
<default><joint damping="5"/></default>
<custom><text name="t" data="&lt;joint name='x'/&gt;"/></custom>
<equality><joint name="x" joint1="x" joint2="turn"/></equality>
<tendon><fixed name="f"><joint joint="x" coef="1"/></fixed></tendon>
<worldbody><![CDATA[<joint name="x" type="slide"/>]]>"""


def test_what_only_looks_like_the_joint_is_left_alone() -> None:
    text = PLAIN.replace("<worldbody>", DECOYS)
    assert patched(text) == patched(PLAIN).replace("<worldbody>", DECOYS)


def test_armature_is_the_rotor_s_and_nothing_else() -> None:
    values = {"F_C": 0.02, "F_V": 0.01, "k_t": 0.5, "R": 3.0, "armature": 3e-3, "q_offset": 0.0}
    servo = model_of("servo-pendulum", "coulomb-viscous", values)
    assert attributes(patched(PLAIN, "turn", servo, armature=True), "turn")["armature"] == "0.003"
    assert "armature" not in attributes(patched(PLAIN, "turn", servo), "turn")
    with pytest.raises(InputError, match="forced-rotary identifies no armature"):
        patched(PLAIN, "turn", hinge(), armature=True)


def test_firm_is_written_when_asked_for() -> None:
    written = attributes(patched(PLAIN, firm=True), "x")
    assert written["solimpfriction"] == "0.9999 0.9999 0.001 0.5 2"
    assert "solimpfriction" not in attributes(patched(PLAIN), "x")


# Not another byte.


def encoded(text: str, encoding: str) -> bytes:
    if encoding == "utf-8-sig":
        return text.encode("utf-8-sig")
    if encoding == "utf-16-be":
        return b"\xfe\xff" + text.encode("utf-16-be")
    if encoding == "utf-8":
        return text.encode()
    return f'<?xml version="1.0" encoding="{encoding}"?>\n{text}'.encode(encoding)


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be", "iso-8859-1", "cp1252"]
)
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends_stay(encoding: str, ends: str) -> None:
    text = PLAIN.replace('name="car"', 'name="Gerät"').removesuffix("\n")
    tag = '<joint\n  name="x" type="slide"/>'
    source = encoded(in_body(tag).replace("car", "Gerät").replace("\n", ends), encoding)
    expected = '<joint\n  name="x" type="slide" frictionloss="12.5" damping="40"/>'
    target = encoded(in_body(expected).replace("car", "Gerät").replace("\n", ends), encoding)
    assert mjcf(slide(), source, "x")[0] == target
    assert text in in_body('<joint name="x" type="slide" axis="1 0 0"/>').replace("car", "Gerät")


BLANK = st.text(" \t\n", min_size=1, max_size=3)
LOOSE = st.text(" \t\n", max_size=2)
WORDS = st.text("abcxyz <>'é√&0129./-", max_size=12)
NOISE = st.one_of(
    WORDS.map(lambda w: f"<!--{w.replace('-', '')}<joint name='x'/>-->"),
    WORDS.map(lambda w: w.replace("<", "").replace("&", "").replace(">", "")),
    WORDS.map(lambda w: f"<![CDATA[{w}<joint name='x' type='slide'/>]]>"),
    st.just('<geom size="1"/>'),
    st.just("<body><joint name='y'/></body>"),
    st.just("<?p <joint name='x'/>?>"),
)


@st.composite
def attribute(draw: st.DrawFn, name: str, value: str | None = None) -> str:
    quote = draw(st.sampled_from("'\""))
    value = draw(WORDS) if value is None else value
    value = value.replace("&", "&amp;").replace("<", "&lt;").replace(quote, "")
    return f"{draw(BLANK)}{name}{draw(LOOSE)}={draw(LOOSE)}{quote}{value}{quote}"


@st.composite
def files(draw: st.DrawFn) -> tuple[str, str, str]:
    """The text before the joint's tag, the tag, and the text after it."""
    chosen = [draw(attribute("name", "x")), draw(attribute("type", "slide"))]
    names = st.lists(
        st.sampled_from(["damping", "frictionloss", "info", "pos", "mydamping"]), unique=True
    )
    chosen += [draw(attribute(name)) for name in draw(names)]
    tag = f"<joint{''.join(draw(st.permutations(chosen)))}{draw(LOOSE)}"
    tag += draw(st.sampled_from(["/>", "></joint>"]))
    noise = st.lists(NOISE, max_size=4).map("".join)
    head = f"{draw(st.sampled_from(['', '﻿']))}<mujoco>{draw(noise)}<worldbody><body>{draw(noise)}"
    return head, tag, f"{draw(noise)}</body></worldbody>{draw(noise)}</mujoco>{draw(LOOSE)}"


@settings(max_examples=300)
@given(files(), st.booleans())
def test_all_bytes_outside_the_tag_stay_whatever_the_file(
    parts: tuple[str, str, str], wide: bool
) -> None:
    head, tag, tail = parts
    codec = "utf-16-le" if wide else "utf-8"
    if wide:
        head = "﻿" + head.removeprefix("﻿")
    file = mjcf(slide(), f"{head}{tag}{tail}".encode(codec), "x")[0]
    assert file.startswith(head.encode(codec))
    assert file.endswith(tail.encode(codec))
    patched_tag = file[len(head.encode(codec)) : len(file) - len(tail.encode(codec))].decode(codec)
    before, after = (dict(ET.fromstring(t).attrib) for t in (tag, patched_tag))  # noqa: S314
    assert after == before | WRITTEN
    # Within the tag too nothing goes but the two values: what is left is in the same order.
    remainder = re.sub(r"\s+(damping|frictionloss)\s*=\s*(\"[^\"]*\"|'[^']*')", "", patched_tag)
    assert remainder == re.sub(r"\s+(damping|frictionloss)\s*=\s*(\"[^\"]*\"|'[^']*')", "", tag)


def test_a_patched_file_is_patched_again_to_the_same() -> None:
    once = patched(PLAIN)
    assert patched(once) == once


# Which joint.


@pytest.mark.parametrize(
    ("text", "joint", "says"),
    [
        (PLAIN, "trun", "has no joint 'trun': there are x, turn; did you mean 'turn'?"),
        (PLAIN.replace('name="turn"', ""), "y", "has no joint 'y': there are x, and 1 without a n"),
        (PLAIN.replace('"turn"', '"x"'), "x", "has 2 joints named 'x', at line 5, line 8"),
        (PLAIN.replace('<option gravity="0 0 0"/>', '<include file="arm.xml"/>'), "elbow",
         "included files are not followed .arm.xml.: patch the one"),
        (PLAIN, "turn", "line 8: joint 'turn' is a hinge, and the card is in N: it fits a slide"),
        (PLAIN.replace("slide", "ball"), "x", "line 5: joint 'x' is of type ball"),
        (in_body('<freejoint name="x"/>'), "x", "line 5: joint 'x' is of type free"),
        (in_body('<joint name="x" type="slide" springdamper="0.1 1"/>'), "x", "has springdamper"),
        ('<robot name="r"><joint name="x" type="prismatic"/></robot>', "x", "is URDF"),
        ("<html><joint name='x'/></html>", "x", "its root is <html>"),
        ("", "x", "is empty"),
        (" \n", "x", "is empty"),
        ("joints: [x]", "x", "line 1: not XML"),
        ("<mujoco><joint name='x'></mujoco>", "x", "line 1: not XML: mismatched tag"),
        (PLAIN + PLAIN, "x", "line 14: not XML: junk after document element"),
        ("<!DOCTYPE m [<!ENTITY a 'b'>]>" + PLAIN, "x", "line 1: has a document type"),
        ("\n<!DOCTYPE mujoco SYSTEM 'file:///etc/passwd'>" + PLAIN, "x", "line 2: has a document"),
        ("<mujoco>&a;</mujoco>", "x", "line 1: not XML: undefined entity"),
        ("<a>" * 5000, "x", "nested too deeply"),
        ('<?xml version="1.0" encoding="klingon"?>' + PLAIN, "x", r"not XML|encoding cann"),
        ('<?xml version="1.0" encoding="shift_jis"?>' + PLAIN, "x", r"not XML|encoding cann"),
    ],
)  # fmt: skip
def test_refusals(text: str, joint: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        patched(text, joint)
    assert "\n" not in str(refused.value)


def test_a_slide_is_no_place_for_a_rotary_card() -> None:
    with pytest.raises(InputError, match="joint 'x' is a slide, and the card is in N m: it fits a"):
        patched(PLAIN, "x", hinge())


@pytest.mark.parametrize(
    "source",
    [b"\x00\x01\x02\xff" * 50, b"\x89PNG\r\n\x1a\n", b"PK\x03\x04", b"\xff\xfe\x00\x00",
     b"<mujoco>\xff</mujoco>", b"<mujoco", b"\xef\xbb\xbf", PLAIN.encode("utf-32")],
)  # fmt: skip
def test_binary_is_refused_in_one_line(source: bytes) -> None:
    with pytest.raises(InputError, match=r"not XML|is empty"):
        mjcf(slide(), source, "x")


def test_a_file_without_end_is_not_read() -> None:
    with pytest.raises(InputError, match="is larger than 4 MiB"):
        mjcf(slide(), b" " * (4 << 20) + PLAIN.encode(), "x")


def test_hostile_names_stay_on_the_line() -> None:
    text = PLAIN.replace('name="turn"', 'name="a&#10;b&#x9b;31m"').replace('name="x"', 'name="u"')
    with pytest.raises(InputError, match=r"there are u, a b 31m$"):
        patched(text)


CLASSES = """<default>
    <default class="rail"><joint type="slide"/><default class="fine"><joint damping="2"/></default>
    </default><default class="soft"><joint springdamper="0.1 1"/></default>
  </default>
  <worldbody>"""


@pytest.mark.parametrize(
    ("tag", "says"),
    [
        ('<joint name="x" class="rail"/>', None),
        ('<joint name="x" class="fine"/>', None),
        ('<joint name="x" class="fine" type="hinge"/>', "is a hinge"),
        ('<joint name="x"/>', "is a hinge"),
        ('<joint name="x" class="soft" type="slide"/>', "has springdamper"),
        ('<frame childclass="fine"><joint name="x"/></frame>', None),
        ('<joint name="x" class="elsewhere"/>', "class 'elsewhere', which this file does not def"),
        ('<joint name="x" class="elsewhere" type="slide"/>', None),
        ('<frame childclass="rail"><joint name="x" class="soft"/></frame>', "is a hinge"),
    ],
)
def test_the_type_may_come_from_a_class(tag: str, says: str | None) -> None:
    text = in_body(tag).replace("<worldbody>", CLASSES)
    if says is None:
        assert attributes(patched(text), "x").items() >= WRITTEN.items()
    else:
        with pytest.raises(InputError, match=says):
            patched(text)


def test_defaults_without_a_class_hold_for_all() -> None:
    main = '<default class="main"><joint type="slide"/></default><default/><worldbody>'
    file = patched(in_body('<joint name="x"/>').replace("<worldbody>", main))
    assert attributes(file, "x") == {"name": "x", **WRITTEN}


# What is lost.


def notes(model: Any, text: str = PLAIN, joint: str = "x", **options: bool) -> str:
    return "\n".join(mjcf(model, text.encode(), joint, **options)[1])


def test_a_law_of_two_numbers_loses_nothing() -> None:
    text = notes(slide())
    assert "sliding friction is the card's own, at speeds from 0 mm/s to 500 mm/s" in text
    assert "is not held" not in text
    assert "pulled" not in text


def test_a_stribeck_axis_loses_its_peak_and_its_jumps() -> None:
    text = notes(sticking())
    # The best two numbers by hand: the normal equations of a dense, even grid.
    v = np.linspace(0, 0.2, 200_001)[1:]
    F = 12 + 8 * np.exp(-v / 0.01) + 40 * v
    (level, damping), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(v), v]), F)
    error = level + damping * v - F
    rms = float(np.sqrt(np.mean(error**2)))
    assert f"off by {rms:.3g} N RMS" in text
    assert f"static friction of 20 N is not held: the axis breaks away at {level:.4g} N" in text
    assert re.search(r"the card's axis breaks away at 20\.0?\d* N and then jumps by", text)
    assert re.search(r"the file's breaks away at 13\.\d+ N and then slides evenly", text)


def test_the_two_numbers_are_the_best_two() -> None:
    law, p = LAWS["stribeck"], np.array([20.0, 12.0, 40.0, 0.01, 1.0])
    best = coulomb_viscous(law, p, (0.0, 0.2), rotary=False)
    v = 0.2 * (np.arange(1000) + 0.5) / 1000

    def rms(level: float, damping: float) -> float:
        return float(np.sqrt(np.mean((level + damping * v - law.friction(v, p)) ** 2)))

    assert best.rms == pytest.approx(rms(best["F_C"], best["F_V"]), rel=1e-3)
    for d_level, d_damping in [(0.05, 0), (-0.05, 0), (0, 0.5), (0, -0.5), (0.05, -0.5)]:
        assert rms(best["F_C"] + d_level, best["F_V"] + d_damping) > best.rms
    # Where the fall outweighs the viscous term, damping ends at zero, not below.
    falling = coulomb_viscous(law, np.array([20.0, 12.0, 1.0, 0.1, 1.0]), (0, 0.2), rotary=False)
    assert falling["F_V"] == 0.0


def test_the_largest_error_is_looked_for_beside_rest() -> None:
    """A peak narrower than the spacing of even speeds is lost, and a note tells so."""
    law, p = LAWS["stribeck"], np.array([20.0, 12.0, 40.0, 2e-4, 1.0])
    line = coulomb_viscous(law, p, (0.0, 0.2), rotary=False)
    v = np.geomspace(2e-5, 0.2, 100_001)
    friction = 12.0 + 8.0 * np.exp(-v / 2e-4) + 40.0 * v
    error = np.abs(line["F_C"] + line["F_V"] * v - friction)
    assert line.worst == pytest.approx(error.max(), rel=1e-3)
    assert abs(line.worst_at) < 3e-5


@pytest.mark.parametrize(
    ("law", "values", "says"),
    [
        ("coulomb-viscous-directional", {"F_C+": 10, "F_V+": 5, "F_C-": 14, "F_V-": 5},
         "friction of the two directions differs by up to 4 N"),
        ("coulomb-load", {"F_C": 10, "F_V": 5, "mu": 0.1}, "goes with the load .normal. is not"),
        ("lugre", {"sigma_0": 1e5, "sigma_1": 1e2, "F_S": 20, "F_C": 12, "v_s": 0.01, "F_V": 5},
         "presliding is not held"),
        ("stribeck+temperature", {**STRIBECK, "temp_slope": 0.01, "temp_ref": 298.15},
         "the numbers are those of 25 degC"),
        ("stribeck+position", {**STRIBECK, "pos_cos": 0.1, "pos_sin": 0, "pos_period": 0.01},
         "goes with position is not held"),
        ("stribeck-smooth", {"F_S": 20, "F_C": 12, "F_V": 5, "v_brk": 0.01}, "never sticks"),
    ],
)  # fmt: skip
def test_what_no_symmetric_curve_has_is_named(
    law: str, values: dict[str, float], says: str
) -> None:
    rig = "cylinder" if law == "coulomb-load" else "forced"
    model = model_of(rig, law, {"M": 10.0, "offset": 0.0, "b": 0.0, **values})
    assert re.search(says, notes(model))
    assert not re.search(says, notes(slide()))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (PLAIN.replace("<option gravity=", '<option><flag frictionloss="disable"/></option><a b='),
         "switches frictionloss off for all joints .line 2"),
        (PLAIN.replace('<body name="car">', '<replicate count="2"><body name="car">')
         .replace("</body>\n  </w", "</body></replicate>\n  </w"), "each of its copies"),
        (PLAIN.replace("</mujoco>", '<actuator><motor joint="x" damping="3"/></actuator></mujoco>'),
         "<motor> on line 13 adds its own damping"),
    ],
)  # fmt: skip
def test_what_else_has_a_say_is_named(text: str, says: str) -> None:
    assert re.search(says, notes(slide(), text))
    assert not re.search(says, notes(slide()))


def test_a_parameter_that_the_card_doubts_is_named() -> None:
    card = slide().card
    parameters = card.parameters | {
        n: card.parameters[n].model_copy(update={"verdict": "not identifiable"})
        for n in ("F_V", "offset")
    }
    doubted = as_model(card.model_copy(update={"parameters": parameters}))
    assert "the card calls F_V not identifiable" in notes(doubted)  # the offset is no friction
    assert "not identifiable" not in notes(slide())


def test_speeds_that_nobody_said_are_said_to_be_assumed() -> None:
    assert "(assumed: the card does not say its speeds)" in notes(slide(speeds=None))
    assert "assumed" not in notes(slide())


def test_what_a_pull_tells_is_the_closed_form() -> None:
    # Friction that falls from F_S to F_C at once: a jump of 2 (F_S - F_C) / k, inertia or not.
    law, p = LAWS["karnopp"], np.array([20.0, 12.0, 0.0, 1e-4])
    pull = spring_pull(law, p, mass=1.0, stiffness=1e3, speed=1e-3, span=60.0)
    assert pull.breakaway == pytest.approx(20.0, rel=2e-3)
    assert pull.jump == pytest.approx(2 * 8.0 / 1e3, rel=0.02)
    even = spring_pull(LAWS["coulomb-viscous"], np.array([12.0, 3.0]), 1.0, 1e3, 1e-3, 60.0)
    assert even.breakaway == pytest.approx(12.0, rel=1e-2)
    assert even.jump < 1e-4


def test_a_rest_of_the_slide_bed_s_own_is_not_touched() -> None:
    # A pull leaves the shipped rig as it was.
    before = {c.name: c.value for c in SLIDE_BED.constants}
    spring_pull(LAWS["coulomb-viscous"], np.array([12.0, 3.0]), 1.0, 1e3, 1e-3, 1.0)
    assert {c.name: c.value for c in SLIDE_BED.constants} == before


# In MuJoCo.

MUJOCO = "mujoco is not installed: pip install 'stribeck[export]'"


def loaded(text: str) -> tuple[Any, Any, Any]:
    mujoco = pytest.importorskip("mujoco", reason=MUJOCO)
    model = mujoco.MjModel.from_xml_string(text)
    return mujoco, model, mujoco.MjData(model)


def test_mujoco_reads_what_was_written() -> None:
    classes = CLASSES.replace('<joint damping="2"/>', '<joint damping="2" frictionloss="9"/>')
    text = in_body('<joint name="x" class="fine"/>').replace("<worldbody>", classes)
    text = text.replace("name='x'", "name='car'")
    _, model, _ = loaded(patched(text))
    assert model.joint("x").frictionloss[0] == 12.5
    assert model.joint("x").damping[0] == 40.0
    assert model.joint("turn").frictionloss[0] == 0.0


def test_mujoco_slides_at_the_card_s_steady_speed() -> None:
    mujoco, model, data = loaded(patched(PLAIN))
    data.qfrc_applied[0] = 20.0
    mujoco.mj_step(model, data, 5000)
    assert data.qvel[0] == pytest.approx((20.0 - 12.5) / 40.0, rel=1e-6)


@pytest.mark.parametrize("firm", [False, True])
def test_creep_at_rest_is_what_is_said(firm: bool) -> None:
    alone = re.sub(r"<body pos=.*?</body>", "", PLAIN, flags=re.DOTALL)
    mujoco, model, data = loaded(patched(alone, firm=firm))
    data.qfrc_applied[0] = 6.25
    mujoco.mj_step(model, data, 3000)
    # What the joint's damping takes of the force is not there to creep.
    assert data.qvel[0] == pytest.approx(creep(6.25, 10.0, 40.0, firm=firm), rel=1e-3)
    assert f"creeps at {1e3 * data.qvel[0]:.3g} mm/s" in notes(slide(), firm=firm)


def test_a_joint_file_knows_where_its_elements_end() -> None:
    file = JointFile(PLAIN.encode(), ("body",))
    outer, inner = file.named("body")
    assert inner.parent is outer
    assert PLAIN.encode()[outer.end :].startswith(b"</body>\n  </worldbody>")
    assert replace(file.attributed(inner, {"pos": "0"}), start=0, stop=0).text == '<body pos="0">'


# Bristles.


def bristled(text: str = PLAIN, model: Any = None) -> str:
    return patched(text, "x", model or sticking(), lugre=True)


def motor(text: str) -> dict[str, str]:
    (element,) = ET.fromstring(text).iter("dcmotor")  # noqa: S314
    return dict(element.attrib)


@pytest.mark.parametrize(
    ("actuators", "before"),
    [
        ("", "<actuator>"),
        ("<actuator/>", "<actuator>"),
        ('<actuator>\n  <motor joint="turn"/>\n</actuator>', '<motor joint="turn"/>\n'),
    ],
)
def test_the_motor_stands_last_among_the_actuators(actuators: str, before: str) -> None:
    text = PLAIN.replace("</mujoco>", f"{actuators}</mujoco>")
    file = bristled(text)
    element = re.search(r"<dcmotor[^>]*/>", file)
    assert element is not None
    assert file[: element.start()].endswith(before)
    remainder = file.replace(element[0], "").replace("<actuator></actuator>", actuators)
    assert remainder.replace(' frictionloss="0" damping="35.2527"', "") == text
    assert motor(file)["joint"] == "x"


def test_a_lugre_card_is_written_as_it_is() -> None:
    p = {"sigma_0": 1e5, "sigma_1": 300.0, "F_S": 20.0, "F_C": 12.0, "v_s": 0.01, "F_V": 40.0}
    model = model_of("forced", "lugre", {**p, "M": 10.0, "offset": 0.0}, (-0.2, 0.2))
    file = bristled(model=model)
    assert attributes(file, "x")["damping"] == "40"
    assert [float(v) for v in motor(file)["lugre"].split()] == pytest.approx(
        [1e5, 300.0, 12.0, 20.0, 0.01], rel=1e-5
    )
    # Bristles too stiff for the time step are made softer, and that is no secret.
    stiff = model_of("forced", "lugre", {**p, "sigma_0": 1e7, "M": 10.0, "offset": 0.0})
    assert motor(bristled(model=stiff))["lugre"].split()[0] == "100000"
    assert "its bristles (1e+05 N/m)" in notes(stiff, lugre=True)
    small_step = PLAIN.replace("<option ", '<option timestep="0.0002" ')
    assert motor(bristled(small_step, stiff))["lugre"].split()[0] == "1e+07"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ('<keyframe><key act="1"/></keyframe></mujoco>', "line 13: a keyframe with act="),
        ('<default><dcmotor gear="2"/></default></mujoco>', "line 13: a class of <dcmotor>"),
        ('<actuator><dcmotor joint="x" lugre="1 1 1 1 1"/></actuator></mujoco>', "of its own"),
        ('<option timestep="fast"/></mujoco>', "timestep 'fast' of <option> is no time"),
    ],
)
def test_bristles_are_refused_where_they_would_break(change: str, says: str) -> None:
    with pytest.raises(InputError, match=re.escape(says)):
        bristled(PLAIN.replace("</mujoco>", f"\n{change}").replace("\n\n", "\n"))


def test_bristles_need_a_law_that_sticks() -> None:
    values = {"F_S": 20.0, "F_C": 12.0, "F_V": 5.0, "v_brk": 0.01, "M": 10.0, "offset": 0.0}
    with pytest.raises(InputError, match="stribeck-smooth never sticks"):
        bristled(model=model_of("forced", "stribeck-smooth", values))


def test_any_name_is_written_so_that_it_is_read_again() -> None:
    tag = "<joint name='é\"&lt;&amp;' type='slide'/>"
    file, _ = mjcf(sticking(), in_body(tag).encode("utf-16"), 'é"<&', lugre=True)
    assert motor(file.decode("utf-16"))["joint"] == 'é"<&'


def test_mujoco_has_the_drop_with_bristles() -> None:
    mujoco, _, _ = loaded(PLAIN)
    if int(mujoco.__version__.split(".")[0]) < 4:
        pytest.skip("this MuJoCo has no <dcmotor> without a current: 4.0 and later have")
    gauss = model_of("forced", "stribeck-gauss", STRIBECK, (-0.2, 0.2))
    _, model, data = loaded(bristled(model=gauss))
    for speed in (0.001, 0.01, -0.01, 0.1):
        mujoco.mj_resetData(model, data)
        for _ in range(2000):  # held at the speed, until the bristles have bent
            data.qvel[:] = speed, 0.0
            mujoco.mj_step(model, data)
        data.qvel[:] = speed, 0.0
        mujoco.mj_forward(model, data)
        force = -(data.qfrc_passive[0] + data.qfrc_actuator[0])
        expected = 12.0 + 8.0 * np.exp(-((speed / 0.01) ** 2)) + 40.0 * abs(speed)
        assert force == pytest.approx(np.copysign(expected, speed), rel=1e-3)


def test_bristles_rest_in_mujoco_and_break_away_where_the_card_does() -> None:
    mujoco, _, _ = loaded(PLAIN)
    if int(mujoco.__version__.split(".")[0]) < 4:
        pytest.skip("this MuJoCo has no <dcmotor> without a current: 4.0 and later have")
    # Down to a quarter of the card's inertia, as the note states.
    for mass in ("10", "2.5"):
        text = re.sub(r"<body pos=.*?</body>", "", PLAIN, flags=re.DOTALL)
        _, model, data = loaded(bristled(text.replace('mass="10"', f'mass="{mass}"')))
        # At once, bristles would swing beyond it; nearer to 20 N, they creep too fast to hold.
        for force in np.linspace(0.0, 18.0, 2000):
            data.qfrc_applied[0] = force
            mujoco.mj_step(model, data)
        mujoco.mj_step(model, data, 1000)
        position = float(data.qpos[0])
        mujoco.mj_step(model, data, 3000)
        assert abs(data.qpos[0] - position) < 1e-6
        data.qfrc_applied[0] = 20.5
        mujoco.mj_step(model, data, 3000)
        assert data.qvel[0] > 0.1


def test_mujoco_coasts_as_far_as_the_closed_form() -> None:
    # v = (v_0 + c) e^{-bt} - c with b = F_V / M, c = F_C / F_V, until it stops.
    mujoco, model, data = loaded(
        patched(re.sub(r"<body pos=.*?</body>", "", PLAIN, flags=re.DOTALL), firm=True)
    )
    data.qvel[0] = 0.5
    mujoco.mj_step(model, data, 1000)
    b, c = 40.0 / 10.0, 12.5 / 40.0
    stop = np.log((0.5 + c) / c) / b
    distance = (0.5 + c) * (1 - np.exp(-b * stop)) / b - c * stop
    # A step of 2 ms at 0.5 m/s is 1 mm; MuJoCo's Euler is off by about half a step of the speed.
    assert data.qpos[0] == pytest.approx(distance, abs=0.5e-3)
