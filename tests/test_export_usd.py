"""USD: a layer gives a joint of a stage the card's friction, as OpenUSD composes it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from joint_models import STRIBECK, hinge, model_of, slide, sticking
from stribeck.errors import InputError
from stribeck.export import Model, export

pxr = pytest.importorskip("pxr", reason="usd-core, of the extra `usd`, is not installed")
Usd = pytest.importorskip("pxr.Usd")
Sdf = pytest.importorskip("pxr.Sdf")

RAIL = """#usda 1.0
(
    defaultPrim = "rail"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)
def Xform "rail" (prepend apiSchemas = ["PhysicsArticulationRootAPI"])
{
    def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        float physics:mass = 1
        float3 physics:diagonalInertia = (1, 1, 1)
    }
    def Xform "car" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        float physics:mass = 10
        float3 physics:diagonalInertia = (1, 1, 1)
    }
    def Xform "arm" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        float physics:mass = 1
        float3 physics:diagonalInertia = (0.1, 0.1, 0.1)
    }
    def PhysicsFixedJoint "ground"
    {
        rel physics:body1 = </rail/base>
    }
    def Scope "joints"
    {
        def PhysicsPrismaticJoint "x"
        {
            uniform token physics:axis = "X"
            rel physics:body0 = </rail/base>
            rel physics:body1 = </rail/car>
            float newton:friction = 99
        }
        def PhysicsRevoluteJoint "turn" (prepend apiSchemas = ["PhysicsDriveAPI:angular"])
        {
            uniform token physics:axis = "Z"
            rel physics:body0 = </rail/car>
            rel physics:body1 = </rail/arm>
            float drive:angular:physics:damping = 0.25
        }
    }
}
"""


@pytest.fixture
def rail(tmp_path: Path) -> Path:
    file = tmp_path / "rail.usda"
    file.write_text(RAIL, encoding="utf-8")
    return file


def laid_over(stage: Path, model: Model, joint: str) -> tuple[dict[str, float], list[str]]:
    """Attributes of the joint on the stage that opens with the layer, and the notes."""
    exported = export(model, "usd", joint=joint, into=stage)
    (layer,) = exported.write(stage.with_name("friction"))
    stage_over = Usd.Stage.Open(str(layer))  # its prims live as long as it does
    prim = stage_over.GetPrimAtPath(f"/rail/joints/{joint}")
    assert prim.IsDefined()
    attributes = {
        a.GetName(): a.Get()
        for a in prim.GetAttributes()
        if a.GetName().startswith(("physxJointAxis:", "newton:"))
    }
    return attributes, list(exported.notes)


def physx_effort(attributes: dict[str, float], axis: str, speed: np.ndarray) -> np.ndarray:
    """Friction of a moving joint, by the documentation of the schema's attributes; speed of an
    angular joint in degrees a second.
    """
    dynamic = attributes[f"physxJointAxis:{axis}:dynamicFrictionEffort"]
    viscous = attributes[f"physxJointAxis:{axis}:viscousFrictionCoefficient"]
    return np.asarray(np.sign(speed) * (dynamic + viscous * np.abs(speed)))


# What simulators read.


def test_physx_slides_as_the_card_does(rail: Path) -> None:
    v = np.array([-0.3, -0.01, 0.02, 0.4])
    attributes, _ = laid_over(rail, slide(), "x")
    assert physx_effort(attributes, "linear", v) == pytest.approx(np.sign(v) * 12.5 + 40 * v)
    assert attributes["newton:friction"] == pytest.approx(12.5)
    assert attributes["newton:damping"] == pytest.approx(40)


def test_physx_turns_as_the_card_does_at_degrees_a_second(rail: Path) -> None:
    w = np.array([-4.0, -0.1, 0.2, 3.0])
    attributes, notes = laid_over(rail, hinge(), "turn")
    effort = physx_effort(attributes, "angular", np.degrees(w))
    assert effort == pytest.approx(np.sign(w) * 0.5 + 0.02 * w)
    assert attributes["newton:damping"] * np.degrees(3.0) == pytest.approx(0.06)
    assert any("damping = 0.25" in note for note in notes)


def test_physx_holds_the_static_level_and_newton_does_not(rail: Path) -> None:
    attributes, notes = laid_over(rail, sticking(), "x")
    static = attributes["physxJointAxis:linear:staticFrictionEffort"]
    dynamic = attributes["physxJointAxis:linear:dynamicFrictionEffort"]
    assert static == pytest.approx(STRIBECK["F_S"])
    assert STRIBECK["F_C"] < dynamic < static
    assert attributes["newton:friction"] == pytest.approx(dynamic)
    not_held = [note for note in notes if "static friction of 20 N is not held" in note]
    assert [note.split(":")[0] for note in not_held] == ["Newton"]


def test_static_friction_is_never_below_the_dynamic(rail: Path) -> None:
    values = {"F_S": 14.0, "F_C": 12.0, "F_V": 40.0, "v_brk": 0.001, "M": 10.0, "offset": 0.0}
    attributes, notes = laid_over(
        rail, model_of("forced", "stribeck-smooth", values, (-0.2, 0.2)), "x"
    )
    static = attributes["physxJointAxis:linear:staticFrictionEffort"]
    assert static == attributes["physxJointAxis:linear:dynamicFrictionEffort"] > 11
    assert any("never sticks" in note for note in notes)


@pytest.mark.parametrize(("metres", "kilograms"), [(0.01, 1.0), (0.001, 0.001)])
def test_efforts_are_in_units_of_the_stage(rail: Path, metres: float, kilograms: float) -> None:
    for name, value in (("metersPerUnit", metres), ("kilogramsPerUnit", kilograms)):
        rail.write_text(
            rail.read_text("utf-8").replace(f"{name} = 1", f"{name} = {value}"), encoding="utf-8"
        )
    attributes, _ = laid_over(rail, slide(), "x")
    # In SI, by dimensions: 1 N = 1 kg m/s^2, and a speed of 0.2 m/s is 0.2 / metres of distance.
    newtons = kilograms * metres
    assert physx_effort(attributes, "linear", np.array([0.2 / metres])) * newtons == pytest.approx(
        12.5 + 40 * 0.2, rel=1e-5
    )
    attributes, _ = laid_over(rail, hinge(), "turn")
    torque = physx_effort(attributes, "angular", np.array([np.degrees(3.0)]))
    assert torque * newtons * metres == pytest.approx(0.5 + 0.02 * 3.0, rel=1e-5)


def test_a_layer_without_its_stage_is_the_same(rail: Path, tmp_path: Path) -> None:
    exported = export(
        hinge(), "usd", joint="/rail/joints/turn", settings={"metres": 0.01, "kilograms": 2.0}
    )
    (layer,) = exported.write(tmp_path / "alone.usda")
    rail.write_text(
        rail.read_text("utf-8")
        .replace("metersPerUnit = 1", "metersPerUnit = 0.01")
        .replace("kilogramsPerUnit = 1", "kilogramsPerUnit = 2")
    )
    alone = Sdf.Layer.FindOrOpen(str(layer))
    opinions = alone.GetPrimAtPath("/rail/joints/turn").properties
    written = {a.name: a.default for a in opinions}
    assert laid_over(rail, hinge(), "turn")[0] == written
    assert any("where it has no revolute joint /rail/joints/turn" in n for n in exported.notes)


def test_the_layer_opens_as_the_stage_does(rail: Path) -> None:
    laid_over(rail, slide(), "x")
    stage = Usd.Stage.Open(str(rail.with_name("friction.usda")))
    before = Usd.Stage.Open(str(rail))
    assert not stage.GetCompositionErrors()
    assert [p.GetPath() for p in stage.Traverse()] == [p.GetPath() for p in before.Traverse()]
    for name in ("metersPerUnit", "kilogramsPerUnit", "upAxis", "defaultPrim"):
        assert stage.GetMetadata(name) == before.GetMetadata(name)
    applied = stage.GetPrimAtPath("/rail/joints/x").GetPrimTypeInfo().GetAppliedAPISchemas()
    assert applied == ["PhysxJointAxisAPI:linear", "NewtonJointAPI"]
    assert stage.GetPrimAtPath("/rail/joints/turn").GetAttribute("newton:friction").Get() is None


def test_newtons_importer_reads_the_friction_in_si(rail: Path) -> None:
    newton = pytest.importorskip("newton", reason="Newton is not installed")
    export(hinge(), "usd", joint="turn", into=rail).write(rail.with_name("friction"))
    builder = newton.ModelBuilder()
    builder.add_usd(str(rail.with_name("friction.usda")))
    assert builder.joint_friction[-1] == pytest.approx(0.5)
    assert builder.joint_damping[-1] == pytest.approx(0.02)


# What is refused.


@pytest.mark.parametrize(
    ("joint", "model", "words"),
    [
        ("turn", slide(), ["/rail/joints/turn", "PhysicsRevoluteJoint", "in N:"]),
        ("x", hinge(), ["/rail/joints/x", "PhysicsPrismaticJoint", "in N m:"]),
        ("ground", slide(), ["PhysicsFixedJoint"]),
        ("tern", hinge(), ["no joint 'tern'", "x, turn", "did you mean 'turn'"]),
        ("/rail/turn", hinge(), ["no joint '/rail/turn'", "/rail/joints/turn"]),
    ],
)
def test_a_joint_that_does_not_fit(rail: Path, joint: str, model: Model, words: list[str]) -> None:
    with pytest.raises(InputError) as refused:
        export(model, "usd", joint=joint, into=rail)
    assert str(refused.value).startswith(f"{rail}: ")
    assert all(word in str(refused.value) for word in words)


def test_a_joint_of_an_instance_is_refused(tmp_path: Path, rail: Path) -> None:
    scene = tmp_path / "scene.usda"
    scene.write_text(
        '#usda 1.0\ndef "one" (\n    instanceable = true\n    references = @./rail.usda@\n)\n{\n}\n'
    )
    assert rail.exists()
    with pytest.raises(InputError, match="part of an instance"):
        export(slide(), "usd", joint="x", into=scene)


@pytest.mark.parametrize("data", [b"", b"PXR-USDC" + bytes(200), b"#usda 1.0\ndef {", b"\xff" * 9])
def test_no_stage_is_one_line(
    tmp_path: Path, data: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "stage.usda"
    file.write_bytes(data)
    with pytest.raises(InputError, match="OpenUSD reads no stage"):
        export(slide(), "usd", joint="x", into=file)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("path", ["x", "/", "/a//b", "/a b", "/1a", "/a.b", '/a"\n'])
def test_no_path_of_a_prim(path: str) -> None:
    with pytest.raises(InputError, match="is no path of a prim"):
        export(slide(), "usd", joint=path)


@pytest.mark.parametrize("settings", [{"metres": 0.0}, {"kilograms": float("nan")}, {"lugre": 1.0}])
def test_no_unit(settings: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(settings))):
        export(slide(), "usd", joint="/x", settings=settings)


def test_units_that_a_stage_says_itself(rail: Path) -> None:
    with pytest.raises(InputError, match="says its units itself"):
        export(slide(), "usd", joint="x", into=rail, settings={"metres": 0.01})
