"""Make robots/panda and robots/iiwa from an installed pybullet_data.

    pip install "pybullet==3.2.7" "fast-simplification==0.2.0" "trimesh==5.2.0" scipy numpy
    python assets/build_robots.py [output folder]

For each robot two files are written:

- `<name>.urdf`: links with their masses, and joints. Names, origins, axes, limits and mimics
  are copied from the source; visuals and collisions are left out.
- `<name>.glb`: the visual meshes, decimated. Geometry `link0` is the base,
  `link<i>` is everything that revolute joint i carries rigidly, in the frame of
  that joint's child link, in metres. Prismatic joints (the Panda's fingers)
  are frozen at `FINGER_OPENING_M`.

The same versions give the same bytes. Sources and licences: SOURCES.md.
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import fast_simplification
import numpy as np
import pybullet_data
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

SOURCES = {"panda": "franka_panda/panda.urdf", "iiwa": "kuka_iiwa/model.urdf"}
KINEMATIC_TAGS = ("parent", "child", "origin", "axis", "limit", "mimic")

FINGER_OPENING_M = 0.02  # each finger; they close at 0 and stop at 0.04
MAX_FACES = {"hand.obj": 1400, "finger.obj": 320}  # else DEFAULT_MAX_FACES
DEFAULT_MAX_FACES = 1380
AGGRESSIVENESS = 4  # 0 to 10: lower fits better, but at 2 the Panda's link 6 keeps 2,400 faces
SKIRT_M = 0.0015  # wider than the cracks, thinner than the shells
WELD_DIGITS = 5  # vertices closer than 10 µm are one
CREASE_DEG = 38.0  # sharper edges are shaded as edges


def kinematic_urdf(robot: ET.Element, source: str) -> str:
    """Links with their inertials, and joints of `robot`, without shapes and dynamics."""
    slim = ET.Element("robot", name=robot.get("name"))
    for element in robot:
        if element.tag not in ("link", "joint"):
            continue
        copy = ET.SubElement(slim, element.tag, element.attrib)
        kept = KINEMATIC_TAGS if element.tag == "joint" else ("inertial",)
        copy.extend(child for child in element if child.tag in kept)
    for element in slim.iter():
        element.text = element.tail = None
    ET.indent(slim)
    notice = f"<!-- Links, masses and joints of pybullet_data/{source}. Licence: LICENSE.txt -->"
    return f'<?xml version="1.0"?>\n{notice}\n{ET.tostring(slim, encoding="unicode")}\n'


def transform(origin: ET.Element | None) -> np.ndarray:
    """(4, 4) matrix of a URDF <origin>: fixed-axis roll, pitch, yaw and metres."""
    if origin is None:
        return np.eye(4)
    roll, pitch, yaw = map(float, origin.get("rpy", "0 0 0").split())
    T = trimesh.transformations.euler_matrix(roll, pitch, yaw, "sxyz")
    T[:3, 3] = [float(x) for x in origin.get("xyz", "0 0 0").split()]
    return T


def carrier_frames(robot: ET.Element) -> dict[str, tuple[int, np.ndarray]]:
    """For each link: i of the revolute joint that carries it, and T_carrier_link."""
    joint_of = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}
    root = next(link.get("name") for link in robot.iter("link") if link.get("name") not in joint_of)
    frames = {root: (0, np.eye(4))}
    revolute = 0
    # Both sources list their joints from the base to the tip.
    for child, joint in joint_of.items():
        index, T_carrier_parent = frames[joint.find("parent").get("link")]
        if joint.get("type") == "revolute":
            revolute += 1
            frames[child] = (revolute, np.eye(4))
            continue
        T_parent_child = transform(joint.find("origin"))
        if joint.get("type") == "prismatic":
            axis = np.array([float(x) for x in joint.find("axis").get("xyz").split()])
            T_parent_child[:3, 3] += FINGER_OPENING_M * T_parent_child[:3, :3] @ axis
        frames[child] = (index, T_carrier_parent @ T_parent_child)
    return frames


def skirted(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """`mesh` with a strip of width SKIRT_M hung inwards from every open border.

    The sources are shells with open borders, and the simplifier lets a flat shell
    shrink away from its border. A strip at an angle turns the border into a crease,
    which is kept; it also closes the view through the cracks between shells.
    """
    _, edge, count = np.unique(mesh.edges_sorted, axis=0, return_inverse=True, return_counts=True)
    start, end = mesh.edges[count[edge.ravel()] == 1].T
    below = len(mesh.vertices)  # offset from a vertex to its copy at the strip's foot
    strips = np.vstack(
        [
            np.column_stack([end, start, start + below]),
            np.column_stack([end, start + below, end + below]),
        ]
    )
    foot = mesh.vertices - SKIRT_M * mesh.vertex_normals
    return trimesh.Trimesh(np.vstack([mesh.vertices, foot]), np.vstack([mesh.faces, strips]), process=False)


def decimated(mesh: trimesh.Trimesh, max_faces: int) -> trimesh.Trimesh:
    """`mesh` welded and simplified by quadric error to at most about `max_faces`."""
    mesh = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)  # drops normals and colours
    mesh.merge_vertices(digits_vertex=WELD_DIGITS)
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    if len(mesh.faces) > max_faces:
        mesh = skirted(mesh)
        mesh.remove_unreferenced_vertices()
        vertices, faces = fast_simplification.simplify(
            mesh.vertices, mesh.faces, target_count=max_faces, agg=AGGRESSIVENESS
        )
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        mesh.update_faces(mesh.nondegenerate_faces())
    mesh.remove_unreferenced_vertices()
    return mesh


def split_at_creases(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy in which faces share a vertex only across edges flatter than CREASE_DEG.

    Two corners (face, vertex) become one vertex if a fan of smooth edges around
    the vertex joins them, so viewers may average normals at every vertex.
    """
    smooth = mesh.face_adjacency_angles < np.radians(CREASE_DEG)
    pairs = mesh.face_adjacency[smooth]  # (E, 2) faces
    ends = mesh.face_adjacency_edges[smooth]  # (E, 2) vertices

    def corner(faces: np.ndarray, vertices: np.ndarray) -> np.ndarray:
        return 3 * faces + np.argmax(mesh.faces[faces] == vertices[:, None], axis=1)

    rows = np.concatenate([corner(pairs[:, 0], ends[:, k]) for k in (0, 1)])
    columns = np.concatenate([corner(pairs[:, 1], ends[:, k]) for k in (0, 1)])
    corners = mesh.faces.size
    joined = coo_array((np.ones(len(rows)), (rows, columns)), shape=(corners, corners))
    count, vertex_of_corner = connected_components(joined, directed=False)
    vertices = np.empty((count, 3))
    vertices[vertex_of_corner] = mesh.vertices[mesh.faces.ravel()]
    return trimesh.Trimesh(vertices, vertex_of_corner.reshape(-1, 3), process=False)


def link_meshes(robot: ET.Element, folder: Path) -> dict[str, trimesh.Trimesh]:
    """Decimated visual meshes by name `link<i>`, each in the frame of link i."""
    frames = carrier_frames(robot)
    parts: dict[str, list[trimesh.Trimesh]] = {}
    for link in robot.iter("link"):
        index, T_carrier_link = frames[link.get("name")]
        for visual in link.findall("visual"):
            path = folder / visual.find("geometry/mesh").get("filename").removeprefix("package://")
            mesh = trimesh.load(path, force="mesh", process=False)
            mesh = decimated(mesh, MAX_FACES.get(path.name, DEFAULT_MAX_FACES))
            mesh.apply_transform(T_carrier_link @ transform(visual.find("origin")))
            parts.setdefault(f"link{index}", []).append(split_at_creases(mesh))
    return {name: trimesh.util.concatenate(meshes) for name, meshes in parts.items()}


def glb(meshes: dict[str, trimesh.Trimesh]) -> bytes:
    """A GLB with one node and one geometry a mesh, positions and indices only."""
    scene = trimesh.Scene()
    for name, mesh in sorted(meshes.items()):
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    return trimesh.exchange.gltf.export_glb(scene, include_normals=False)


def build(name: str, folder: Path) -> None:
    """Write `<name>.urdf` and `<name>.glb` into `folder`."""
    path = Path(pybullet_data.getDataPath()) / SOURCES[name]
    robot = ET.parse(path).getroot()
    meshes = link_meshes(robot, path.parent)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.urdf").write_text(kinematic_urdf(robot, SOURCES[name]), encoding="utf-8")
    (folder / f"{name}.glb").write_bytes(glb(meshes))
    for link, mesh in sorted(meshes.items()):
        print(f"{name} {link}: {len(mesh.faces)} faces, {len(mesh.vertices)} vertices")


if __name__ == "__main__":
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "robots"
    for name in SOURCES:
        build(name, root / name)
