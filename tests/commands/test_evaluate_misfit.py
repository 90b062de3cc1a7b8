"""`evaluate` says why a demonstrator is no body like the learner's, if it knows the learner's body."""

from dataclasses import replace

import numpy as np
import pytest

from viewimit.estimation.views import VIEWS
from viewimit.experiments.bench.demonstrators import stretched
from viewimit.simulation.camera import Cameras, StereoHead
from viewimit.simulation.robot import BodyPoints
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

POINTS, NOISE_PX = 16, 0.05
SCENE = load_scene("panda")
POSTURES_DEG = np.vstack(
    [[(30, -60), (45, -60), (45, -75)], np.random.default_rng(1).uniform((5, -150), (85, -30), (12, 2))]
)
SHOWN_DEG = np.array([55.0, -85.0])


@pytest.fixture
def said(tmp_path, ask_json):
    """What `evaluate` finds in the tracks of a demonstrator, and of a learner that reaches a share of each motion."""

    def evaluate(demonstrator=None, order=range(POINTS), scene=SCENE, short=0.0, look=None, shown_deg=(SHOWN_DEG,)):
        rng, world, demos = np.random.default_rng(4), World(scene, POINTS), []
        for theta in np.radians(shown_deg):
            demo = (demonstrator or world).demo_images(theta)[0] if look is None else look(world, theta)
            demos.append(demo[list(order)] + NOISE_PX * rng.standard_normal((POINTS, 4)))
        lines, there = ["frame,view,point,x,y"], np.radians(POSTURES_DEG[0])
        for frame, sent in enumerate(np.radians(POSTURES_DEG)):
            there = there + (1 - short) * (sent - there)
            own, demo = world.own_images(there)[0], demos[frame % len(demos)]
            own = own + NOISE_PX * rng.standard_normal((POINTS, 4))
            for view, image in zip(VIEWS, (demo[:, :2], demo[:, 2:], own[:, :2], own[:, 2:])):
                lines += [f"{frame},{view},p{k},{x!r},{y!r}" for k, (x, y) in enumerate(image.tolist())]
        (tmp_path / "tracks.csv").write_text("\n".join(lines) + "\n")
        angles = [f"{k},{low:g},{high:g}" for k, (low, high) in enumerate(POSTURES_DEG)]
        (tmp_path / "angles.csv").write_text("\n".join(["frame,theta2,theta4", *angles]) + "\n")
        status, found = ask_json("evaluate", tmp_path / "tracks.csv", "--postures", tmp_path / "angles.csv")
        assert status == 0
        return found["misfit"]

    return evaluate


def test_a_body_like_the_own_one_gets_no_word(said, tmp_path, ask_json, ask):
    assert said() is None
    _, found = ask_json("evaluate", tmp_path / "tracks.csv")
    assert "misfit" not in found  # Without joint angles nothing is known about the learner's body.


def test_another_length_of_a_link_is_said(said):
    robot = stretched(SCENE, World(SCENE, POINTS).robot, np.array([0.0, 0.08]))
    found = said(World(SCENE, POINTS, robot))
    assert found["kind"] == "another-body" and "longer" in found["text"]
    (link,) = found["links"]
    assert link["joints"] == [1, 2] and abs(link["change"] - 0.08) < 4 * link["std"] < 0.08


def test_one_point_and_the_points_of_one_link_are_named(said):
    body = World(SCENE, POINTS).body
    local = body.local.copy()
    local[3] += (0.015, -0.01, 0.01)
    found = said(World(SCENE, POINTS, body=BodyPoints(body.link, local)))
    assert found["kind"] == "point" and found["points"] == ["p3"] and "p3" in found["text"]
    local, hand = body.local.copy(), body.link >= SCENE.moving[1] + 1
    local[hand] += 0.02 * np.random.default_rng(0).normal(size=(hand.sum(), 3))
    found = said(World(SCENE, POINTS, body=BodyPoints(body.link, local)))
    assert found["kind"] == "link-points" and found["points"] == [f"p{k}" for k in np.flatnonzero(hand)]


def test_another_head_is_named(said):
    def look(world, theta):
        head = SCENE.stereo_head()
        zoomed = [replace(lens, focal=tuple(1.12 * f for f in lens.focal)) for lens in (head.left, head.right)]
        other = StereoHead(head.position, 1.15 * head.baseline_m, head.width, head.height, *zoomed)
        points = world.points_world(theta, world.T_world_demo)
        images, _ = Cameras(other.gaze(SCENE.head.gaze_demonstrator)).project(points)
        return np.concatenate(list(images), 1)

    assert said(look=look)["kind"] == "two-heads"


def test_a_mirror_image_is_named(said):
    def look(world, theta):
        T = world.T_world_demo
        points = (world.points_world(theta, T) - T[:3, 3]) @ T[:3, :3] * (1, -1, 1) @ T[:3, :3].T + T[:3, 3]
        images, _ = world.demo_pair.project(points)
        return np.concatenate(list(images), 1)

    assert said(look=look)["kind"] == "mirrored"


def test_an_arm_that_stops_short_is_named(said):
    found = said(short=0.2)
    assert found["kind"] == "arm" and found["amount"] == pytest.approx(0.2, abs=0.01)
