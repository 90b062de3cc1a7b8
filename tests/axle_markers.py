"""Markers that are symmetric about the plane of a stretched arm."""

import numpy as np

from viewimit.simulation.robot import BodyPoints, load_robot

SIDE_M = 0.07


def stretched(scene):
    """(n + 1, 4, 4): the frames of all links where every joint that moves is at 0."""
    straight = np.radians(scene.posture_deg)
    straight[scene.moving] = 0.0
    return load_robot(scene.robot).link_frames(straight)


def body_at(scene, links, places):
    """Points on links, at places (N, 3) m of the stretched arm."""
    frames = stretched(scene)[links]
    return BodyPoints(links, np.einsum("nji,nj->ni", frames[:, :3, :3], places - frames[:, :3, 3]))


def axle_markers(scene):
    """A pair at each axle, 7 cm to the left and to the right."""
    frames = stretched(scene)
    links = np.repeat(np.arange(1, len(frames)), 2)
    places = frames[links, :3, 3] + np.outer(np.tile([SIDE_M, -SIDE_M], len(frames) - 1), (0, 1, 0))
    return body_at(scene, links, places)


def one_pair(scene):
    """Points in the arm's plane, at the axles and beside them, and a pair of markers at the last axle."""
    frames = stretched(scene)
    along = np.tile([0.03, -0.03], len(frames))
    links = np.repeat(np.arange(len(frames)), 2)
    in_plane = frames[links, :3, 3] + np.stack([along, 0 * along, 0 * along], 1)
    last = frames[-1, :3, 3] + np.array([[0, SIDE_M, 0], [0, -SIDE_M, 0]])
    return body_at(scene, np.append(links, [len(frames) - 1] * 2), np.concatenate([in_plane, last]))


def in_plane(scene):
    """Two points beside each axle, all in the plane, as along the front of the arm."""
    frames = stretched(scene)
    links = np.repeat(np.arange(len(frames)), 2)
    return body_at(scene, links, frames[links, :3, 3] + np.outer(np.tile([0.05, -0.03], len(frames)), (1, 0, 0)))
