"""What richer or careless URDFs say: it is read, or reported with its remedy, never skipped in silence."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from urdfs import arm, joint, link, robot, write

from viewimit.geometry.rigid import rotation_from_rpy
from viewimit.simulation.urdf.chain import carrier_frames, find_arm
from viewimit.simulation.urdf.mesh_files import NotFound, load_mesh, mesh_path
from viewimit.simulation.urdf.reference import Reference
from viewimit.simulation.urdf.shapes import shapes_of
from viewimit.simulation.urdf.tree import read_tree


def origins(folder: Path, origin: str):
    """T_base_link of all links of an arm whose second joint has this origin."""
    turned = joint("lift", "shoulder", "upper").replace('<origin xyz="0 0 0"/>', origin)
    tree = read_tree(write(folder, joint("yaw", "base", "shoulder", axis="0 0 1"), turned, joint("c", "upper", "hand")))
    frames = carrier_frames(tree, find_arm(tree))
    second = next(one for one in tree.joints if one.name == "lift")
    return second.T_parent_joint, frames


@pytest.mark.parametrize("seed", range(5))
def test_a_quaternion_turns_as_the_same_rpy_does(tmp_path, seed):
    rpy = np.random.default_rng(seed).uniform(-1.5, 1.5, 3)
    half = rpy / 2
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    quaternion = (  # of intrinsic turns about z, y, x
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
    words = lambda values: " ".join(f"{3 * value:.17g}" for value in values)  # of any length
    found, _ = origins(tmp_path, f'<origin xyz="1 2 3" quat_xyzw="{words(quaternion)}"/>')
    np.testing.assert_allclose(found[:3, :3], rotation_from_rpy(rpy), atol=1e-12)
    np.testing.assert_array_equal(found[:3, 3], [1, 2, 3])


UNKNOWN = {
    "an attribute of an origin": ('<origin rpy_deg="0 0 90"/>', "<origin rpy_deg=…> is not understood"),
    "of a joint": ('<limit lower="-2" upper="2" soft="1"/>', "<limit soft=…> is not understood"),
    "of an axis": ('<axis xyz="0 0 1" frame="base"/>', "<axis frame=…> is not understood"),
    "a limit in degrees": ('<limit lower="-120" upper="120"/>', "if these are degrees, write radians"),
}


@pytest.mark.parametrize("what", UNKNOWN)
def test_what_could_change_the_arm_is_reported(tmp_path, what):
    more, says = UNKNOWN[what]
    odd = joint("elbow", "upper", "lower", more="").replace("<origin", f"{more}<origin", 1)
    path = write(tmp_path, joint("yaw", "base", "shoulder"), joint("lift", "shoulder", "upper"), odd)
    assert any(says in fault and "joint 'elbow'" in fault for fault in shapes_of(Reference(path)).faults)


def visual(geometry: str) -> str:
    return f"<visual><geometry>{geometry}</geometry></visual>"


def test_a_capsule_is_a_cylinder_with_half_spheres(tmp_path):
    capsule = link("hand", visual=visual('<capsule radius="0.1" length="0.4"/>'))
    path = write(tmp_path, *arm(joint("wrist", "lower", "hand", xyz="0 0 0.3"), capsule))
    found = shapes_of(Reference(path))
    assert not found.faults
    np.testing.assert_allclose(found.meshes[4].vertices.min(0), [-0.1, -0.1, -0.3], atol=2e-3)
    np.testing.assert_allclose(found.meshes[4].vertices.max(0), [0.1, 0.1, 0.3], atol=2e-3)


def test_prefixes_that_are_not_declared_are_read_and_reported(tmp_path):
    path = write(tmp_path, *arm())
    old = '<gazebo><sensor:camera name="c" xacro:x="1"><a:b/></sensor:camera></gazebo></robot>'
    path.write_text(robot(*arm()).replace("</robot>", old))
    tree = read_tree(path)
    assert len(tree.joints) == 3
    (fault,) = tree.faults
    assert "the prefixes a, sensor, xacro are not declared" in fault


# Mesh files


@pytest.fixture
def box(tmp_path):
    """A binary STL of a box."""
    content = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="stl")
    path = tmp_path / "box.stl"
    path.write_bytes(content)
    return path


def test_an_stl_that_is_cut_off_says_so(box):
    box.write_bytes(box.read_bytes()[:-120])
    with pytest.raises(NotFound, match="cut off: it has 9 of 12 triangles"):
        load_mesh(box)


def test_an_stl_whose_head_says_solid_and_is_binary_is_read(box):
    content = box.read_bytes()
    box.write_bytes(b"solid exported".ljust(80) + content[80:])
    assert len(load_mesh(box).faces) == struct.unpack("<I", content[80:84])[0]


def test_meshes_in_millimetres_are_reported_with_the_remedy(tmp_path):
    trimesh.creation.box((300, 100, 100)).export(tmp_path / "arm.stl")
    for scale, reported in (("1 1 1", True), ("0.001 0.001 0.001", False)):
        mesh = visual(f'<mesh filename="arm.stl" scale="{scale}"/>')
        path = write(tmp_path, *arm(joint("wrist", "lower", "hand", xyz="0 0 0.3"), link("hand", visual=mesh)))
        assert any('scale="0.001 0.001 0.001"' in fault for fault in shapes_of(Reference(path)).faults) == reported


@pytest.mark.parametrize(
    "name", ["file:{}", "file://{}", "file://localhost{}", "model://robot/a%20box.stl", "a%20box.stl"]
)
def test_addresses_of_files_lead_to_them(tmp_path, name):
    folder = tmp_path / "robot"
    folder.mkdir()
    path = folder / "a box.stl"
    trimesh.creation.box((1, 1, 1)).export(path)
    assert mesh_path(folder / "arm.urdf", name.format(path.as_posix())) == path.resolve()


def test_packages_are_looked_for_where_ros_2_installs_them(tmp_path, monkeypatch):
    share = tmp_path / "install" / "share" / "robot"
    share.mkdir(parents=True)
    trimesh.creation.box((1, 1, 1)).export(share / "box.stl")
    urdf = tmp_path / "elsewhere" / "arm.urdf"
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert mesh_path(urdf, "package://robot/box.stl") == (share / "box.stl").resolve()
