"""Make one mesh for the base and for each joint of an arm, of all shapes that it moves.

Links without shapes are drawn as rods between joints.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import cast

import numpy as np
import trimesh

from ...geometry.arrays import Floats
from ...wording import first_of
from ..meshes import Mesh
from .chain import Chain, carrier_frames, find_arm, held_links
from .mesh_files import MAX_LINK_FACES, NotFound, creased, load_mesh, mesh_path, simplified
from .reference import Reference
from .tree import Shape, Tree, read_tree

CYLINDER_SIDES = 24
MAX_SIZE_RATIO = 50  # of meshes and of the distances between joints; those in mm are a thousand times as large
MAX_LISTED = 3  # names of what is not drawn for one reason
ROD_RADIUS = 0.035  # of the arm's length, as the next two
MIN_ROD = 0.05  # nearer joints have no rod between them
STUB = 0.12  # length of a rod that leads nowhere

Meshes = dict[int, Mesh]  # by link number


@dataclass(frozen=True, eq=False)
class Shapes:
    """The meshes of an arm."""

    meshes: Meshes  # 0 = base, each in its link's frame [m]
    n_held: Mapping[int, int]  # first faces of each mesh that the arm holds: the others move by themselves
    faults: tuple[str, ...]  # messages about what is not drawn, not understood, or looks wrong

    def split(self) -> tuple[Meshes, Meshes]:
        """Return what the arm holds of each mesh, and what moves by itself."""
        held, loose = Meshes(), Meshes()
        for k, mesh in self.meshes.items():
            held[k], loose[k] = (Mesh(mesh.vertices, faces) for faces in np.split(mesh.faces, [self.n_held[k]]))
        return held, loose


def shapes_of(reference: Reference) -> Shapes:
    """Return the meshes of an arm. An unreadable mesh becomes a fault and a rod.

    Raises ValueError as `read_tree` and `find_arm`.
    """
    return load_shapes(read_tree(reference.path), reference)


@lru_cache(8)
def load_shapes(tree: Tree, reference: Reference) -> Shapes:
    """Return the meshes of an arm in a URDF that has been read."""
    arm = find_arm(tree, reference.base, reference.tip)
    meshes, n_held, missing = _make_meshes(tree, arm, reference.meshes)
    lines = [f"{tree.path}: not drawn: {fault}" for fault in missing]
    return Shapes(meshes, n_held, (*tree.faults, *lines, *_implausible_size(tree, arm, meshes)))


def _implausible_size(tree: Tree, arm: Chain, meshes: Meshes) -> list[str]:
    """A message about meshes that are far larger or smaller than the distances between the joints."""
    if not any(shape.kind == "mesh" for shapes in tree.shapes.values() for shape in shapes):
        return []
    length = sum(float(np.linalg.norm(joint.T_parent_joint[:3, 3])) for joint in arm.joints)
    extent = max((float(np.ptp(mesh.vertices, axis=0).max()) for mesh in meshes.values()), default=0.0)
    if not length > 0 or 1 / MAX_SIZE_RATIO < extent / length < MAX_SIZE_RATIO:
        return []
    return [
        f"{tree.path}: its meshes are {extent:.3g} m large and its joints {length:.3g} m apart in all: if the meshes "
        'are in mm, add scale="0.001 0.001 0.001" to each <mesh>'
    ]


def _make_meshes(tree: Tree, arm: Chain, folder: Path | None) -> tuple[Meshes, dict[int, int], list[str]]:
    """Meshes by link number, how many of their faces the arm holds, and a message for each reason to draw no more."""
    frames, held = carrier_frames(tree, arm), held_links(tree, arm)
    parts: dict[tuple[int, bool], list[trimesh.Trimesh]] = {}  # by carrier, and whether they move by themselves
    missing: dict[str, dict[str, None]] = {}  # names by the reason
    bare: set[int] = set()  # links with a shape that is not drawn
    files: dict[str, trimesh.Trimesh] = {}
    for link, shapes in tree.shapes.items():
        if link not in frames:
            if shapes:
                why = "hangs on nothing that the arm hangs on: add a joint, or take it out"
                missing.setdefault(why, {})[f"link {link!r}"] = None
            continue
        carrier, T_carrier_link = frames[link]
        for shape in shapes:
            try:
                mesh = _shape_mesh(tree, shape, files, folder)
            except NotFound as error:
                missing.setdefault(error.why, {})[error.name] = None
                bare.add(carrier)
                continue
            if mesh is not None:
                mesh.apply_transform(T_carrier_link @ shape.T_link_shape)
                parts.setdefault((carrier, link not in held), []).append(mesh)
    drawn = {carrier for carrier, loose in parts if not loose}
    undrawn = not any(drawn)  # no moving link has a shape; the base is 0
    for number, mesh in _rods(arm, frames):
        if number not in drawn and (number in bare or undrawn or (number == 0 and (0, True) not in parts)):
            parts[number, False] = [mesh]
    meshes, n_held = {}, {}
    for number in sorted({carrier for carrier, _ in parts}):
        each = [_joined(parts[number, loose]) for loose in (False, True) if (number, loose) in parts]
        whole = cast(trimesh.Trimesh, trimesh.util.concatenate(each))
        meshes[number] = Mesh(np.array(whole.vertices, float), np.array(whole.faces))
        n_held[number] = len(each[0].faces) if (number, False) in parts else 0
    return (
        meshes,
        n_held,
        [f"{first_of(list(names), MAX_LISTED)}{': each' * (len(names) > 1)} {why}" for why, names in missing.items()],
    )


def _joined(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    return creased(simplified(cast(trimesh.Trimesh, trimesh.util.concatenate(parts)), MAX_LINK_FACES))


def _shape_mesh(
    tree: Tree, shape: Shape, files: dict[str, trimesh.Trimesh], folder: Path | None
) -> trimesh.Trimesh | None:
    """Mesh in the shape's frame; None if it has no extent. files: simplified meshes that have been read."""
    if shape.kind == "mesh":
        if shape.file not in files:
            files[shape.file] = simplified(load_mesh(mesh_path(tree.path, shape.file, folder)))
        mesh = files[shape.file].copy()
        mesh.apply_scale(shape.size)
        return mesh
    if min(shape.size) <= 0:
        return None
    if shape.kind == "box":
        return trimesh.creation.box(shape.size)
    if shape.kind == "capsule":
        mesh = trimesh.creation.capsule(height=shape.size[1], radius=shape.size[0], count=[CYLINDER_SIDES, 12])
        mesh.apply_translation(-mesh.bounds.mean(0))
        return mesh
    if shape.kind == "cylinder":
        return trimesh.creation.cylinder(shape.size[0], shape.size[1], sections=CYLINDER_SIDES)
    return trimesh.creation.icosphere(2, shape.size[0])


def _rods(arm: Chain, frames: dict[str, tuple[int, Floats]]) -> Iterator[tuple[int, trimesh.Trimesh]]:
    """Rods for the base and each joint of the arm, by link number."""
    numbers = [frames[joint.child][0] for joint in arm.joints]
    turned = [(k, joint) for k, joint in enumerate(arm.joints) if not k or numbers[k] != numbers[k - 1]]
    turned = [(k, joint) for k, joint in turned if numbers[k]]
    ends: dict[int, Floats] = {}
    for joint in arm.joints:
        carrier, T_carrier_parent = frames[joint.parent]
        ends[carrier] = (T_carrier_parent @ joint.T_parent_joint)[:3, 3]
    last = numbers[-1]
    if arm.tip in frames and frames[arm.tip][0] == last:
        ends[last] = frames[arm.tip][1][:3, 3]
    length = max(sum(float(np.linalg.norm(end)) for number, end in ends.items() if number), 1e-3)
    yield 0, foot(ends.get(0, np.zeros(3)), length)
    for k, joint in turned:
        mesh = rod(ends.get(numbers[k], np.zeros(3)), length)
        if mesh is None and numbers[k] == last:
            mesh = stub(joint.axis, length)
        if mesh is not None:
            yield numbers[k], mesh


def rod(end: Floats, length: float) -> trimesh.Trimesh | None:
    """Return a rod from the origin to `end`, (3,) m, for an arm of that length; None if it is too short to see."""
    distance = float(np.linalg.norm(end))
    if distance < MIN_ROD * length:
        return None
    mesh = trimesh.creation.cylinder(ROD_RADIUS * length, distance, sections=12)
    mesh.apply_translation([0, 0, distance / 2])
    mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], end / distance))
    return mesh


def stub(axis: Floats, length: float) -> trimesh.Trimesh:
    """Return a bar across the axis of the last joint, so that its rotation is visible."""
    axis = axis / np.linalg.norm(axis)
    across = np.cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0])
    mesh = trimesh.creation.box((STUB * length, ROD_RADIUS * length, 2 * ROD_RADIUS * length))
    mesh.apply_translation([STUB * length / 2, 0, 0])
    turn = np.eye(4)
    turn[:3, 0] = across / np.linalg.norm(across)
    turn[:3, 2] = axis
    turn[:3, 1] = np.cross(turn[:3, 2], turn[:3, 0])
    mesh.apply_transform(turn)
    return mesh


def foot(top: Floats, length: float) -> trimesh.Trimesh:
    """Return a block with its top at (3,) m, where an arm of that length starts."""
    mesh = trimesh.creation.box((0.25 * length, 0.18 * length, 0.12 * length))
    mesh.apply_translation(top - [0, 0, 0.06 * length])
    return mesh
