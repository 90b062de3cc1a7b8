"""Meshes of a URDF's arm, and their cache."""

import re
import sys

import numpy as np
import pytest
import trimesh
from urdfs import arm, joint, link, write

from viewimit.simulation.urdf.mesh_files import NotFound, mesh_path
from viewimit.simulation.urdf.reference import Reference
from viewimit.simulation.urdf.shapes import shapes_of

BALL = trimesh.creation.icosphere(3, 0.1)


def mesh_of(name, scale=""):
    return f'<visual><geometry><mesh filename="{name}" {scale}/></geometry></visual>'


def export(mesh, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    mesh.export(path)
    return path


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "glb", "off", "dae"])
def test_meshes_of_all_kinds_are_read_and_scaled(tmp_path, kind):
    if kind == "dae":
        pytest.importorskip("collada")
    export(BALL, tmp_path / f"ball.{kind}")
    urdf = write(
        tmp_path, *arm(joint("last", "lower", "hand"), link("hand", visual=mesh_of(f"ball.{kind}", 'scale="1 2 -3"')))
    )
    shapes = shapes_of(Reference(urdf))
    assert shapes.faults == ()
    np.testing.assert_allclose(np.ptp(shapes.meshes[4].vertices, axis=0), [0.2, 0.4, 0.6], atol=2e-3)
    mesh = trimesh.Trimesh(shapes.meshes[4].vertices, shapes.meshes[4].faces, process=False)
    assert mesh.volume > 0  # a mirrored mesh is not inside out


def test_the_unit_of_a_dae_is_heeded(tmp_path):
    pytest.importorskip("collada")
    path = export(BALL, tmp_path / "ball.dae")
    path.write_text(path.read_text().replace("</asset>", '<unit name="mm" meter="0.001"/></asset>'))
    urdf = write(tmp_path, *arm(joint("last", "lower", "hand"), link("hand", visual=mesh_of("ball.dae"))))
    np.testing.assert_allclose(np.ptp(shapes_of(Reference(urdf)).meshes[4].vertices, axis=0), 0.0002, rtol=0.02)


def test_boxes_cylinders_and_spheres_are_as_large_as_said_and_stand_where_their_joint_carries_them(tmp_path):
    lying = '<origin xyz="1 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius="0.1" length="0.5"/></geometry>'
    urdf = write(
        tmp_path,
        joint("a", "base", "one"),
        link("base", "0.2 0.4 0.6", at="0 0 1"),
        link("one", visual=f"<visual>{lying}</visual>"),
        joint("bolt", "one", "two", "fixed", xyz="0 0 2"),
        link("two", visual='<visual><geometry><sphere radius="0.3"/></geometry></visual>'),
    )
    meshes = shapes_of(Reference(urdf)).meshes
    np.testing.assert_allclose(meshes[0].bounds, [[-0.1, -0.2, 0.7], [0.1, 0.2, 1.3]])
    np.testing.assert_allclose(meshes[1].bounds, [[-0.3, -0.3, -0.1], [1.25, 0.3, 2.3]], atol=2e-3)


def test_a_missing_mesh_is_a_rod_and_a_message(tmp_path):
    seen = write(
        tmp_path, *arm(joint("last", "lower", "hand", xyz="0 0 0.3"), link("hand", visual=mesh_of("lost.stl")))
    )
    shapes = shapes_of(Reference(seen))
    assert set(shapes.meshes) == {0, 1, 2, 3, 4} and len(shapes.faults) == 1
    assert str(seen) in shapes.faults[0] and "lost.stl is not there" in shapes.faults[0]


@pytest.fixture
def package(tmp_path):
    """…/ws/my_arm/{urdf,meshes}, and a secret beside the workspace."""
    export(BALL, tmp_path / "secret/ball.stl")
    for folder in ("my_arm/meshes", "my_arm/urdf", "other/meshes"):
        export(BALL, tmp_path / "ws" / folder / "ball.stl")
    return tmp_path / "ws/my_arm/urdf/arm.urdf"


def test_packages_are_found_above_the_file_and_along_ros_package_path(package, monkeypatch):
    ws = package.parents[2]
    assert mesh_path(package, "package://my_arm/meshes/ball.stl") == ws / "my_arm/meshes/ball.stl"
    assert mesh_path(package, "package://other/meshes/ball.stl") == ws / "other/meshes/ball.stl"
    assert mesh_path(package, "../meshes/ball.stl") == ws / "my_arm/meshes/ball.stl"
    assert (
        mesh_path(package, "ball.stl")
        == mesh_path(package, f"file://{package.parent}/ball.stl")
        == package.parent / "ball.stl"
    )
    with pytest.raises(NotFound, match="no folder far above .* nor in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"):
        mesh_path(package, "package://far/ball.stl")
    far = package.parents[3] / "elsewhere"
    export(BALL, far / "far/ball.stl")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{ws}:{far}")
    assert mesh_path(package, "package://far/ball.stl") == far / "far/ball.stl"


@pytest.mark.parametrize("folder", ["secret", "."])
@pytest.mark.parametrize(
    "name", ["../../../secret/ball.stl", "file://{root}/secret/ball.stl", "package://far/secret/ball.stl", "x/ball.stl"]
)
def test_a_further_folder_is_read_if_the_user_names_it(package, name, folder):
    root = package.parents[3]
    if folder == "." and name == "x/ball.stl":
        name = "x/secret/ball.stl"
    assert mesh_path(package, name.format(root=root), root / folder) == root / "secret/ball.stl"
    with pytest.raises(NotFound):
        mesh_path(package, "../../../secret/ball.stl", root / "ws")
    (root / "ws/link.stl").symlink_to(root / "secret/ball.stl")
    with pytest.raises(NotFound):
        mesh_path(package, "link.stl", root / "ws")


@pytest.mark.parametrize(
    "name, message",
    [
        ("../../../secret/ball.stl", "lies outside .* and is not read"),
        ("{root}/secret/ball.stl", "lies outside .* and is not read"),
        ("file://{root}/secret/ball.stl", "lies outside .* and is not read"),
        ("package://my_arm/../../secret/ball.stl", "leads out of .* and is not read"),
        ("package://my_arm/%2e%2e/%2e%2e/secret/ball.stl", "leads out of .* and is not read"),
        ("package://../secret/ball.stl", "names no package"),
        ("package:///my_arm/ball.stl", "names no package"),
        ("http://example.org/ball.stl", "is not fetched"),
        ("https://example.org/ball.stl", "is not fetched"),
        ("link.stl", "lies outside .* and is not read"),
        ("meshes/lost.stl", "is not there"),
    ],
)
def test_files_outside_the_package_are_not_read(package, name, message):
    (package.parent / "link.stl").symlink_to(package.parents[3] / "secret/ball.stl")
    with pytest.raises(NotFound, match=message):
        mesh_path(package, name.format(root=package.parents[3]))


@pytest.mark.parametrize(
    "name, content, message",
    [
        ("bomb.dae", '<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;</COLLADA>', "defines entities"),
        ("zip.dae", "PK\x03\x04", "is an archive"),
        ("broken.stl", "solid nothing", "no triangles|does not load"),
        ("broken.obj", "v 1 nan 2\nv 0 0 0\nv 1 1 1\nf 1 2 3", "no triangles|does not load"),
        ("broken.dae", "<COLLADA", "does not load"),
        ("passwords.txt", "root", "convert it to one of stl"),
    ],
)
def test_a_file_that_is_no_mesh_is_a_fault(tmp_path, name, content, message):
    (tmp_path / name).write_text(content)
    urdf = write(tmp_path, *arm(joint("last", "lower", "hand"), link("hand", visual=mesh_of(name))))
    (fault,) = shapes_of(Reference(urdf)).faults
    assert re.search(message, fault), fault


def test_an_obj_reads_no_other_file(tmp_path, monkeypatch):
    """Neither the materials that it names nor their pictures."""
    export(BALL, tmp_path / "ball.obj")
    (tmp_path / "ball.obj").write_text("mtllib /etc/hostname\n" + (tmp_path / "ball.obj").read_text())
    urdf = write(tmp_path, *arm(joint("last", "lower", "hand"), link("hand", visual=mesh_of("ball.obj"))))
    opened = []
    sys.addaudithook(lambda event, what: opened.append(str(what[0])) if event == "open" else None)
    shapes = shapes_of(Reference(urdf))
    assert shapes.faults == () and str(tmp_path / "ball.obj") in opened
    assert not [path for path in opened if "hostname" in path or path.endswith(".mtl")]
