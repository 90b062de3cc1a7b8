"""Shapes that are kept are those that would be made, to the last bit; whatever changes makes others."""

import os

import numpy as np
import pytest
import trimesh
from urdfs import arm, joint, link, write

from viewimit.simulation.urdf import shapes
from viewimit.simulation.urdf.reference import Reference

BALL = trimesh.creation.icosphere(4, 0.1)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where they are kept, empty."""
    monkeypatch.setenv(shapes.FOLDER, str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.fixture
def read(monkeypatch):
    """Files that are read as meshes, in order."""
    found, plain = [], shapes.load_mesh
    monkeypatch.setattr(shapes, "load_mesh", lambda path: (found.append(path.name), plain(path))[1])
    return found


def urdf_of(folder, *names, more=""):
    hand = "".join(f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in names)
    return Reference(write(folder, *arm(joint("last", "lower", "hand"), link("hand", visual=hand)), more))


def anew(reference):
    """As the next process has it."""
    shapes.load_shapes.cache_clear()
    return shapes.shapes_of(reference)


def assert_same(one, other):
    assert one.faults == other.faults and list(one.meshes) == list(other.meshes)
    for link_number, mesh in one.meshes.items():
        np.testing.assert_array_equal(mesh.vertices, other.meshes[link_number].vertices)
        np.testing.assert_array_equal(mesh.faces, other.meshes[link_number].faces)


def test_the_next_process_reads_no_mesh_and_has_the_same(tmp_path, folder, read):
    BALL.export(tmp_path / "ball.stl")
    reference = urdf_of(tmp_path, "ball.stl", "lost.stl")
    made = anew(reference)
    assert read == ["ball.stl"] and len(made.faults) == 1 and "lost.stl is not there" in made.faults[0]
    assert_same(anew(reference), made)
    assert read == ["ball.stl"]
    assert folder.stat().st_mode & 0o777 == 0o700


def test_whatever_changes_makes_others(tmp_path, folder, read):
    BALL.export(tmp_path / "ball.stl")
    reference = urdf_of(tmp_path, "ball.stl", "late.stl")
    first = anew(reference)
    before = (tmp_path / "ball.stl").stat()
    BALL.copy().apply_scale([1, 1, 2]).export(tmp_path / "ball.stl")  # as large, and as old
    os.utime(tmp_path / "ball.stl", ns=(before.st_atime_ns, before.st_mtime_ns))
    second = anew(reference)
    assert np.ptp(second.meshes[4].vertices[:, 2]) == pytest.approx(
        2 * np.ptp(first.meshes[4].vertices[:, 2]), rel=0.01
    )
    BALL.export(tmp_path / "late.stl")
    third = anew(reference)
    assert third.faults == () and read == ["ball.stl", "ball.stl", "ball.stl", "late.stl"]
    urdf_of(tmp_path, "ball.stl", "late.stl", more="<link name='alone'/>")
    anew(reference)
    anew(Reference(reference.path, tip="lower"))
    assert read[4:] == ["ball.stl", "late.stl"] * 2


def test_what_is_damaged_is_made_again(tmp_path, folder, read):
    BALL.export(tmp_path / "ball.stl")
    reference = urdf_of(tmp_path, "ball.stl")
    made = anew(reference)
    (kept,) = folder.iterdir()
    whole = kept.read_bytes()
    wrong = {"links": np.array([4]), "missing": np.array([], str), "v4": np.zeros((3, 3)), "f4": np.array([[0, 1, 9]])}
    for k, content in enumerate((b"", whole[:-100], b"no archive", wrong, {**wrong, "v4": np.array([None])}), 2):
        if isinstance(content, dict):
            np.savez(kept, **content)
        else:
            kept.write_bytes(content)
        assert_same(anew(reference), made)
        assert len(read) == k
    assert_same(anew(reference), made)
    assert len(read) == k


def test_there_is_an_end_to_what_is_kept_and_the_oldest_goes(tmp_path, folder, monkeypatch, read):
    BALL.export(tmp_path / "ball.stl")
    monkeypatch.setattr(shapes, "MAX_CACHED", 2)
    references = [Reference(urdf_of(tmp_path, "ball.stl").path, tip=tip) for tip in ("lower", "hand", None)]
    for k, reference in enumerate(references):
        anew(reference)
        for path in folder.iterdir():
            os.utime(path, ns=(path.stat().st_atime_ns, path.stat().st_mtime_ns - 10**9))
        assert len(list(folder.iterdir())) == min(k + 1, 2)
    anew(references[2])
    assert len(read) == 3
    anew(references[0])
    assert len(read) == 4


@pytest.mark.parametrize("where", ["", "a file"])
def test_a_folder_that_cannot_be_is_done_without(tmp_path, monkeypatch, where):
    (tmp_path / "a file").write_text("")
    monkeypatch.setenv(shapes.FOLDER, where and str(tmp_path / where / "below"))
    BALL.export(tmp_path / "ball.stl")
    assert anew(urdf_of(tmp_path, "ball.stl")).faults == ()
