"""A scene as numbers for the engine in app/lab/engine, to the last digit."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.svg import joint_symbol
from viewimit.simulation.appearance import extreme_vertices
from viewimit.simulation.camera import Camera
from viewimit.simulation.robot import BodyPoints, Leader, link_meshes
from viewimit.simulation.scene import Scene
from viewimit.simulation.world import World

from ..model.choices import joint_name

MOVING_JOINTS = 2  # the map of E has as many axes
HULL_DIGITS = 4  # of m
MAX_RADIUS = 1e3  # focal lengths from the optical axis, instead of infinity


def require_scene(scene: Scene) -> None:
    """Raise ValueError for a scene that the engine cannot compute."""
    count = len(scene.moving_joints)
    if count != MOVING_JOINTS:
        raise ValueError(f"the lab needs {MOVING_JOINTS} moving joints, this scene has {count}: choose --joints")
    head = scene.stereo_head()
    if head.left.is_distorted or head.right.is_distorted:
        raise ValueError("the lab has pinhole cameras: this scene's lenses distort their images")


def can_compute(scene: Scene) -> bool:
    """Return whether the engine can compute runs in a scene."""
    try:
        require_scene(scene)
    except ValueError:
        return False
    return True


def engine_scene(scene: Scene) -> dict[str, Any]:
    """Return a scene as app/lab/engine/world.js documents it. Raises ValueError for a scene of other than two moving
    joints, or with lenses that distort."""
    require_scene(scene)
    bodies = {str(count): scene.body_points(count) for count in sorted(map(int, scene.points))}
    described = describe_world(World(scene, min(map(int, scene.points))), bodies)
    return {**described, "gaze": list(scene.head.gaze_demonstrator)}


def describe_world(world: World, bodies: Mapping[str, BodyPoints]) -> dict[str, Any]:
    """Return a world of any number of joints as app/lab/engine/world.js documents it. bodies: layouts by name."""
    scene = world.scene
    chain, links = world.robot.with_fixed_joints(np.radians(scene.posture_deg), scene.moving)
    free = [k for k, joint in enumerate(chain.joints) if joint.leader is None]
    joints = []
    for k, joint in enumerate(chain.joints):
        turns = joint.leader or Leader(k, 1.0, 0.0)
        axis = (joint.axis / np.linalg.norm(joint.axis)).tolist()
        led = {"joint": free.index(turns.joint), "multiplier": turns.multiplier, "offset": turns.offset}
        joints.append({"T": _rows(joint.T_parent_joint), "axis": axis, **led})
    placed = lambda body: [{"on": int(on), "at": at.tolist()} for on, at in zip(body.link, body.local)]
    layouts = {name: placed(links.points(layout)) for name, layout in bodies.items()}
    return {
        "title": scene.title,
        "joints": [joint_symbol(joint) for joint in scene.moving_joints],
        "names": [joint_name(scene, joint) for joint in scene.moving_joints],
        "lower": scene.lower.tolist(),
        "upper": scene.upper.tolist(),
        "demonstrator": np.radians(scene.posture_deg)[scene.moving].tolist(),
        "start": np.radians(scene.start_deg).tolist(),
        "chain": joints,
        "links": [{"on": int(on), "T": _rows(T)} for on, T in zip(links.link, links.T_chain_link)],
        "bases": {"demonstrator": _rows(world.T_world_demo), "learner": _rows(world.T_world_own)},
        "cameras": [_camera(camera) for camera in (*world.demo_cameras, *world.own_cameras)],
        "layouts": layouts,
    }


def describe_hulls(robot: str) -> dict[str, Sequence]:
    """Return the outermost vertices of each link, m, from which its outlines in the images are drawn."""
    meshes = link_meshes(robot)
    corners = {link: extreme_vertices(np.asarray(mesh.vertices, float)) for link, mesh in meshes.items()}
    return {str(link): found.round(HULL_DIGITS).tolist() for link, found in corners.items()}


def _camera(camera: Camera) -> dict[str, Any]:
    T, lens = camera.T_world_camera, camera.lens
    bends = {}
    if lens.is_distorted:
        by = ((each.k1, each.k2, min(each.max_radius, MAX_RADIUS)) for each in (lens.distortion, lens.correction))
        bends["distortion"] = [{"k1": k1, "k2": k2, "maxRadius": radius} for k1, k2, radius in by]
    return {
        "rotation": T[:3, :3].ravel().tolist(),
        "centre": T[:3, 3].tolist(),
        "focal": list(map(float, camera.lens.focal)),
        "principal": list(map(float, camera.lens.centre)),
        "width": camera.width,
        "height": camera.height,
        **bends,
    }


def _rows(T: NDArray[np.float64]) -> list[float]:
    """(4, 4) → its first three rows, one after the other."""
    return np.asarray(T, float)[:3].ravel().tolist()
