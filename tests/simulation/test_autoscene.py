"""A scene made for a URDF: within the limits, visible, and with enough spread points."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from urdfs import arm, gripper, joint, link, write

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.autoscene.surface import parts_of
from viewimit.simulation.robot import Robot, link_meshes
from viewimit.simulation.scene import load_robot, load_scene
from viewimit.simulation.world import World


def replaced(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


def hand():
    parts = [link("palm", "0.08 0.02 0.09")]
    for k, x in enumerate((-0.03, 0, 0.03)):
        parts += [
            joint(
                f"f{k}a", "palm", f"f{k}1", axis="1 0 0", xyz=f"{x} 0 0.05", more='<limit lower="-0.2" upper="1.6"/>'
            ),
            link(f"f{k}1", "0.015 0.015 0.04", at="0 0 0.02"),
            joint(f"f{k}b", f"f{k}1", f"f{k}2", axis="1 0 0", xyz="0 0 0.04", more='<limit lower="0" upper="1.6"/>'),
            link(f"f{k}2", "0.014 0.014 0.03", at="0 0 0.015"),
        ]
    return parts


def mobile():
    """A base on wheels, a torso that slides, an arm with a gripper."""
    slide = joint(
        "torso", "cart", "base", "prismatic", axis="0 0 1", xyz="0 0 0.3", more='<limit lower="0" upper="0.4"/>'
    )
    wheels = [
        part
        for k, y in enumerate((-0.25, 0.25))
        for part in (
            joint(f"wheel{k}", "cart", f"tyre{k}", "continuous", xyz=f"0 {y} -0.1", more=""),
            link(f"tyre{k}", "0.2 0.05 0.2"),
        )
    ]
    return [link("cart", "0.6 0.5 0.3"), *wheels, slide, *arm(*gripper("lower"))]


def humanoid():
    parts = [
        link("pelvis", "0.2 0.3 0.2"),
        joint("waist", "pelvis", "chest", axis="0 0 1", xyz="0 0 0.2"),
        link("chest", "0.2 0.35 0.4", at="0 0 0.2"),
    ]
    for side, y in (("left", 0.2), ("right", -0.2)):
        for above, names, drop, z in (
            ("chest", ("shoulder", "elbow", "wrist"), 0.28, 0.35),
            ("pelvis", ("hip", "knee"), 0.4, -0.1),
        ):
            parent, xyz = above, f"0 {y} {z}"
            for name in names:
                parts += [
                    joint(f"{side}_{name}", parent, f"{side}_{name}_link", xyz=xyz),
                    link(f"{side}_{name}_link", f"0.08 0.07 {drop}", at=f"0 0 {-drop / 2}"),
                ]
                parent, xyz = f"{side}_{name}_link", f"0 0 {-drop}"
    return parts


def bare():
    return [
        joint("a", "base", "one", axis="0 0 1"),
        joint("b", "one", "two", xyz="0 0 0.3"),
        joint("c", "two", "three", xyz="0.4 0 0"),
    ]


def endless():
    return [part.replace('type="revolute"', 'type="continuous"') for part in arm()]


def coupled():
    more = joint(
        "tilt",
        "lower",
        "end",
        xyz="0 0 0.3",
        more='<limit lower="-3" upper="3"/><mimic joint="elbow" multiplier="-1"/>',
    )
    return arm(more, link("end", "0.1 0.04 0.1"))


ROBOTS = {kind.__name__: kind for kind in (arm, hand, mobile, humanoid, bare, endless, coupled)}


@pytest.fixture(params=ROBOTS)
def urdf(request, tmp_path):
    return write(tmp_path, *ROBOTS[request.param](), name=f"{request.param}.urdf")


SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in ("hand", "endless", "coupled")]


@pytest.mark.parametrize("urdf", ["arm", "mobile", "humanoid", "bare", *SLOW], indirect=True)
def test_the_default_method_converges_and_claims_it(urdf):
    session = Session(
        Settings.paper(**{name: getattr(Settings(), name) for name in ("transfer", "servo")}, scene=str(urdf))
    )
    ended = session.run(100)
    last = ended.last
    if urdf.stem == "coupled":  # a joint that turns with another one is no screw
        assert not last.status.is_claim and "no chain of rigid links explains" in ended.message
        return
    assert last.status == "converged" and np.degrees(np.abs(last.theta - last.theta_demo).max()) < 0.5
    assert np.degrees(np.abs(session.history[0].theta - last.theta_demo).max()) > 10  # it had somewhere to go


def test_posture_and_ranges_are_within_the_limits(urdf):
    scene, found = load_scene(urdf), load_robot(urdf)
    angles = np.radians(scene.posture_deg)
    assert ((found.lower - 1e-9 <= angles) & (angles <= found.upper + 1e-9)).all()
    np.testing.assert_allclose(angles, found.with_mimics(angles), atol=1e-4)
    low, high = np.transpose(scene.range_deg)
    assert ((high - low) >= 20).all() and ((high - low) <= 90).all()
    assert (low < scene.start_deg).all() and (scene.start_deg < high).all()


def test_all_points_are_in_all_four_images_over_the_whole_range(urdf):
    scene = load_scene(urdf)
    for count in (10, 16, 20):
        world = World(scene, count)
        grid = np.meshgrid(*(np.linspace(low, high, 9) for low, high in zip(scene.lower, scene.upper)))
        (images, visible), (_, demo_visible) = world.own_images(grid), world.demo_images(grid)
        assert visible.all() and demo_visible.all()
        spread = np.ptp(images.reshape(-1, 2, 2), axis=(0, 1))
        assert spread.max() > 60  # px: not far away either


def test_points_are_on_the_surface_of_every_part_and_not_in_a_plane(urdf):
    scene, shapes = load_scene(urdf), link_meshes(str(urdf))
    for count in (10, 16, 20):
        body = scene.body_points(count)
        for index, local in zip(body.link, body.local):
            corners = shapes[int(index)].triangles
            assert distance_to(corners, local) < 2e-4  # they are written to a tenth of a millimetre
        part = parts_of(body.link, list(scene.moving_joints))
        known = np.unique(parts_of(np.array(list(shapes)), list(scene.moving_joints)))
        shares = np.bincount(part)[known]
        assert shares.min() >= count // 3 - 1 and 0 in known
        places = World(scene, count).points_world(np.radians(scene.posture_deg)[scene.moving], np.eye(4))
        sizes = np.linalg.svd(places - places.mean(0), compute_uv=False)
        assert sizes[2] > 0.05 * sizes[0]


def distance_to(corners, point):
    """To the nearest of triangles (f, 3, 3), m: by the closest of many points on each."""
    a, b, c = corners.swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    height = ((point - a) * normal).sum(1)
    foot = point - height[:, None] * normal
    sides = [(np.cross(q - p, foot - p) * normal).sum(1) for p, q in ((a, b), (b, c), (c, a))]
    inside = np.min(sides, axis=0) > -1e-7
    return np.abs(height[inside]).min() if inside.any() else np.inf


def test_everything_scales_with_the_robot(tmp_path):
    """Ten times as large: the same images, ten times the distances."""
    small = write(tmp_path, *bare(), name="small.urdf")
    large = write(tmp_path, *bare(), name="large.urdf")
    replaced(large, 'xyz="0 0 0.3"', 'xyz="0 0 3"')
    replaced(large, 'xyz="0.4 0 0"', 'xyz="4 0 0"')
    one, ten = load_scene(small), load_scene(large)
    np.testing.assert_allclose(np.array(ten.head.position), 10 * np.array(one.head.position), rtol=1e-3, atol=1e-3)
    assert ten.head.baseline == pytest.approx(10 * one.head.baseline, rel=1e-3) and ten.size == pytest.approx(
        10 * one.size, rel=1e-3
    )
    theta = np.radians(one.posture_deg)[one.moving]
    np.testing.assert_allclose(World(one).demo_images(theta)[0], World(ten).demo_images(theta)[0], atol=0.2)


STIFF = '<limit lower="0.5" upper="0.5"/>'


@pytest.mark.parametrize(
    "parts, joints, message",
    [
        ([joint("a", "base", "one")], None, "from base to one 1 joint can turn, and two are needed; another chain"),
        (
            [joint("a", "base", "one"), joint("b", "one", "two", more=STIFF)],
            None,
            "b turns only from 28.65° to 28.65°: widen",
        ),
        (
            [joint("a", "base", "one"), joint("b", "one", "two", more="")],
            None,
            "b has no <limit lower=… upper=…>: give it",
        ),
        (arm(joint("d", "lower", "end", more="")), (2, 4), "joints 2, 4 must ascend, within 1 … 3"),
        (coupled(), (2, 4), "joint 4, tilt, follows joint 3, elbow: move that one"),
        (
            arm(joint("d", "lower", "end", more=STIFF), joint("e", "end", "far")),
            (2, 4),
            "joint 4, d, is held by its limits at 28.65°",
        ),
    ],
)
def test_too_few_or_fixed_joints_are_named_with_the_remedy(tmp_path, parts, joints, message):
    with pytest.raises(ValueError, match=message):
        load_scene(write(tmp_path, *parts), joints=joints)


COLLECTION = {  # of pybullet_data: arms, legs and what has wheels, as they are
    "xarm/xarm6_robot.urdf": 6, "franka_panda/panda.urdf": 7, "kuka_iiwa/model.urdf": 7, "laikago/laikago.urdf": 3,
    "racecar/racecar.urdf": 2, "pendulum5.urdf": 5,
}  # fmt: skip


@pytest.mark.parametrize("name", COLLECTION)
def test_public_robots_are_imitated_from_their_urdf_alone(name):
    spec = importlib.util.find_spec("pybullet_data")
    if spec is None or spec.origin is None:
        pytest.skip("no pybullet_data")
    path = Path(spec.origin).parent / name
    assert len(Robot.from_urdf(path).joints) == COLLECTION[name]
    session = Session(Settings.paper(scene=str(path), transfer="projective", servo="likelihood"))
    last = session.run(100).last
    assert last.status == "converged" and np.degrees(np.abs(last.theta - last.theta_demo).max()) < 0.5
