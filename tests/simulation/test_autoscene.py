"""A scene made for a URDF: within the limits, visible, and with enough spread points."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
from urdfs import LIMIT, arm, gripper, joint, link, write

from viewimit.analysis.observability import MAX_PLACES, find_candidates
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.autoscene.placing import fit_to_view, image_jacobian, rest_posture, turning_range
from viewimit.simulation.autoscene.scene import make_scene
from viewimit.simulation.autoscene.surface import Surface, parts_of, visible_fraction
from viewimit.simulation.camera import Cameras
from viewimit.simulation.meshes import first_hit
from viewimit.simulation.robot import Robot, link_meshes
from viewimit.simulation.scene import load_robot, load_scene, scene_names
from viewimit.simulation.scene_writing import saved_scene
from viewimit.simulation.urdf.reference import Reference
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


def test_the_default_method_converges_and_claims_it(urdf):
    session = Session(
        Settings.paper(**{name: getattr(Settings(), name) for name in ("transfer", "servo")}, scene=str(urdf))
    )
    last = session.run(100).last
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


LOOSE = {  # what moves by itself, beside the arm or at its end
    "a wheel": (joint("spin", "base", "tyre", "continuous", xyz="0 0.3 0", more=""), link("tyre", "0.2 0.05 0.2")),
    "a head": (
        joint("nod", "base", "skull", xyz="0 -0.3 0.2"), joint("bolt", "skull", "face", "fixed"),
        link("face", "0.2 0.2 0.2"),
    ),
    "a lift": (joint("lift2", "base", "tray", "prismatic", xyz="0 0.4 0"), link("tray", "0.3 0.2 0.05")),
    "a ball": (joint("drift", "base", "ball", "floating", xyz="0 0.4 0", more=""), link("ball", "0.2 0.2 0.2")),
    "a finger": (joint("finger", "lower", "pad", "prismatic", xyz="0.1 0 0.3"), link("pad", "0.02 0.02 0.1")),
    "a cart below a lift": (joint("rise", "cart", "base", "prismatic", xyz="0 0 0.3"), link("cart", "0.5 0.5 0.2")),
    "a cover that follows": (
        joint("flap", "upper", "cover", xyz="0 0.2 0", more=f'{LIMIT}<mimic joint="elbow"/>'),
        link("cover", "0.1 0.1 0.3"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", LOOSE)
def test_no_point_is_on_what_moves_by_itself(tmp_path, what):
    """Points are on the boxes of the arm's own links, as `arm` has them."""
    given = {"base": "base", "tip": "lower"} if "cart" in what else {}
    made = make_scene(Reference(write(tmp_path, *arm(*LOOSE[what])), **given))
    centres = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.2], [0.03, 0, 0.15]])
    halves = np.array([[0.2, 0.2, 0.1], [0.1, 0.14, 0.1], [0.08, 0.06, 0.4], [0.06, 0.08, 0.3]]) / 2
    for layout in made.fields["points"].values():
        for number, *place in layout:
            off = np.abs(np.array(place) - centres[number]) - halves[number]
            assert off.max() == pytest.approx(0, abs=2e-4)
        assert {number for number, *_ in layout} >= {0, 3}
    assert any("does not hold" in line for line in made.choices)


def test_what_is_bolted_to_the_base_still_has_points(tmp_path):
    foot = joint("bolt", "base", "foot", "fixed", xyz="0 0 -0.3"), link("foot", "0.4 0.4 0.1")
    stiff = (
        joint("stop", "base", "post", xyz="0 0.3 0", more='<limit lower="0" upper="0"/>'),
        link("post", "0.1 0.1 0.1"),
    )
    for parts in (foot, stiff):
        made = make_scene(Reference(write(tmp_path, *arm(*parts))))
        places = np.array([place for number, *place in made.fields["points"]["20"] if number == 0])
        assert (np.abs(places) > [0.11, 0.11, 0.06]).any()
        assert not any("does not hold" in line for line in made.choices)


def test_a_base_of_wheels_alone_has_no_points_and_it_is_said(tmp_path):
    parts = [part for part in arm(*LOOSE["a wheel"]) if 'link name="base"' not in part]
    made = make_scene(Reference(write(tmp_path, *parts)))
    assert all(number for layout in made.fields["points"].values() for number, *_ in layout)
    assert any("no point on the base" in line for line in made.choices)


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


def test_the_two_joints_that_are_taken_sweep_the_largest_area_of_images(tmp_path):
    """Of all pairs, by turning each joint through its range and looking: a wrist far out loses, two that do the same
    lose."""
    path = write(
        tmp_path, *arm(joint("wrist", "lower", "hand", axis="0 0 1", xyz="0 0 0.3"), link("hand", "0.05 0.02 0.04"))
    )
    scene = load_scene(path)
    assert 4 not in scene.moving_joints
    world, rest = World(scene, 20), np.radians(scene.posture_deg)

    def swept(pair):
        columns = []
        for number in pair:
            low, high = np.radians(turning_range(load_robot(path), number, rest_posture(load_robot(path))))
            moved = [
                world.robot.link_frames(rest + shift * np.eye(4)[number - 1], world.T_world_own)
                for shift in (-1e-4, 1e-4)
            ]
            images = [
                world.own_pair.images(
                    np.array([(T[link] @ [*local, 1])[:3] for link, local in zip(world.body.link, world.body.local)])
                )[0]
                for T in moved
            ]
            columns.append((images[1] - images[0]).ravel() * (high - low))
        return np.sqrt(np.linalg.det(np.array(columns) @ np.array(columns).T))

    taken = swept(scene.moving_joints)
    assert all(taken > 2 * swept(pair) for pair in ((1, 4), (2, 4), (3, 4)))


def test_the_image_jacobian_is_that_of_geometry(tmp_path):
    """dp/dθ = a × (p - o), seen by the camera."""
    path = write(tmp_path, *arm())
    found = load_robot(path)
    surface = Surface(np.array([3, 2, 0]), np.array([[0.1, 0.0, 0.2], [0.0, 0.05, 0.3], [0.1, 0.1, 0.0]]), np.eye(3))
    places = surface.at(found.link_frames([0.2, 0.3, 0.4]))[0]
    placing = fit_to_view(places, 0.0, 0.5)
    camera, T = placing.cameras(1)[0], placing.base(1)
    J = image_jacobian(found, np.array([0.2, 0.3, 0.4]), surface, Cameras([camera]), T).reshape(3, 2, 3)
    frames = found.link_frames([0.2, 0.3, 0.4], T)
    for k, number in enumerate(surface.link):
        world = (frames[number] @ [*surface.local[k], 1])[:3]
        x, y, z = camera.T_world_camera[:3, :3].T @ (world - camera.T_world_camera[:3, 3])
        projection = 256 * np.array([[1 / z, 0, -x / z**2], [0, 1 / z, -y / z**2]]) @ camera.T_world_camera[:3, :3].T
        for i, one in enumerate(found.joints):
            axis, origin = frames[i + 1][:3, :3] @ one.axis, frames[i + 1][:3, 3]
            expected = projection @ np.cross(axis, world - origin) if number > i else np.zeros(2)
            np.testing.assert_allclose(J[k, :, i], expected, atol=0.1)


def test_a_place_behind_another_or_turned_away_is_not_seen():
    places = np.array([[0.0, 0, 0], [0.5, 0, 0], [0.0, 0.3, 0]])
    normals = np.array([[-1.0, 0, 0], [-1, 0, 0], [1, 0, 0]])
    placing = fit_to_view(np.array([[0.0, -0.4, -0.4], [1.0, 0.4, 0.4]]), -1.0, 0.0)
    eye = np.linalg.inv(placing.base(1)) @ np.append(placing.cameras(1)[0].T_world_camera[:3, 3], 1)
    behind = places[0] + 0.5 * (places[0] - eye[:3])  # on the same ray
    seen = visible_fraction([placing.cameras(1)[0]], placing.base(1), np.array([places[0], behind, places[2]]), normals)
    np.testing.assert_array_equal(seen, [1, 0, 0])


def test_only_the_part_of_a_large_base_near_the_arm_has_points(tmp_path):
    """A rail of ten metres does not move the head away."""
    small, rail = (
        load_scene(write(tmp_path, *arm())),
        arm(joint("bolt", "base", "rail", "fixed"), link("rail", "10 0.1 0.1")),
    )
    scene = load_scene(write(tmp_path, *rail, name="rail.urdf"))
    body = scene.body_points(20)
    assert np.abs(body.local[body.link == 0]).max() < 0.7
    assert scene.size < 1.5 * small.size


@pytest.mark.parametrize("radius", [0.1, 0.8])
def test_two_robots_do_not_stand_in_each_other(tmp_path, radius):
    disc = f'<visual><geometry><cylinder radius="{radius}" length="0.1"/></geometry></visual>'
    scene = load_scene(write(tmp_path, link("base", visual=disc), *arm()[1:]))
    apart = np.linalg.norm(np.subtract(scene.demonstrator.position, scene.learner.position))
    assert apart > 2 * radius and apart < max(2 * radius, 1.2) * 1.2


def test_given_joints_move_and_all_else_is_chosen_for_them(tmp_path):
    path = write(tmp_path, *arm())
    scene, chosen = load_scene(path, joints=(1, 3)), load_scene(path)
    assert scene.moving_joints == (1, 3) != chosen.moving_joints and scene.points != chosen.points
    everything = load_scene(path, joints=(1, 2, 3))
    assert everything.range_deg[0] == pytest.approx((-114.6, 114.6), abs=0.1)
    assert load_scene(f"{path}#tip=upper").moving_joints == (1, 2)


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


def test_prismatic_and_mimic_joints_are_reported(tmp_path):
    said = "\n".join(make_scene(Reference(write(tmp_path, *mobile()))).choices)
    assert "torso slides, and is held at 0.08 m" in said and "1 yaw, 2 lift, 3 elbow" in said
    assert "tilt follows elbow" in "\n".join(make_scene(Reference(write(tmp_path, *coupled()))).choices)


@pytest.mark.parametrize(
    "more, says",
    [
        ({"kind": "floating"}, "perch is floating, and is held"),
        ({"kind": "planar"}, "perch is planar, and is held"),
        ({"kind": "Revolute"}, "held, as type 'Revolute' is none of revolute, continuous, .*, fixed: perch"),
        ({"more": LIMIT + '<mimic joint="nobody"/>'}, "perch follows nobody, which does not turn in this arm, and is"),
        ({"more": LIMIT + '<mimic joint="perch"/>'}, "perch follows perch, which does not turn in this arm"),
    ],
)
def test_fixed_joints_that_could_move_are_reported(tmp_path, more, says):
    arm_on = [link("floor"), joint("perch", "floor", "base", **more), *arm()]
    said = "\n".join(make_scene(Reference(write(tmp_path, *arm_on))).choices)
    assert re.search(says, said) and "1 yaw, 2 lift, 3 elbow" in said


def test_a_wrist_of_no_type_does_not_vanish_without_a_word(tmp_path):
    wrist = joint("roll", "lower", "hand", kind="", axis="0 0 1", xyz="0 0 0.3"), link("hand", "0.1 0.1 0.1")
    said = "\n".join(make_scene(Reference(write(tmp_path, *arm(*wrist)))).choices)
    assert "held, as type '' is none of" in said and "roll" in said
    assert "held" not in "\n".join(make_scene(Reference(write(tmp_path, *arm()))).choices)


def test_an_edited_file_is_read_again(tmp_path):
    path = write(tmp_path, *arm())
    before = load_scene(path)
    replaced(path, 'xyz="0 0 0.4"', 'xyz="0 0 0.6"')
    after = load_scene(path)
    assert after.head != before.head and load_scene(path) == after


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
    session = Session(Settings.paper(scene=str(path), transfer="projective", servo="trust-region"))
    last = session.run(100).last
    assert last.status == "converged" and np.degrees(np.abs(last.theta - last.theta_demo).max()) < 0.5


@pytest.mark.parametrize("name, joints", [("panda", None), ("iiwa", None), ("panda", (1, 2, 3, 4, 5, 6, 7))])
def test_they_are_on_the_arm_and_every_camera_sees_them(name, joints):
    scene = load_scene(name, joints=joints)
    world, meshes = World(scene), link_meshes(name)
    theta = np.radians(scene.start_deg)
    found = find_candidates(world, theta)
    assert 20 < len(found) <= MAX_PLACES
    seen = World(scene, body=found)
    assert seen.demo_images(theta)[1].all() and seen.own_images(theta)[1].all()
    for k in range(len(found)):  # no vertex of its link is nearer than its faces are large
        assert np.linalg.norm(meshes[found.link[k]].vertices - found.local[k], axis=1).min() < 0.12
    for cameras, T in ((world.demo_cameras, world.T_world_demo), (world.own_cameras, world.T_world_own)):
        frames, places = world.link_frames(theta, T), seen.points_world(theta, T)
        for camera in cameras:
            eye = camera.T_world_camera[:3, 3]
            for place in places:
                hit = first_hit(meshes, frames, eye, place - eye)
                assert hit is None or np.linalg.norm(eye - place) - hit.distance < 3e-3


def test_fixed_links_and_the_last_link_have_candidates():
    scene = load_scene("panda")
    link = find_candidates(World(scene), np.radians(scene.start_deg)).link
    parts = np.bincount(np.searchsorted(scene.moving_joints, link, side="right"))
    assert len(parts) == 3 and parts.min() >= 6


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_with_points_by_hand_is_the_same_after_its_file(name, tmp_path):
    points = tuple((k % 8, 0.0123 * k, -1e-5 / (k + 1), 0.1) for k in range(11))
    scene = load_scene(name, body_points=points)
    assert scene.points == {"11": points}
    path = tmp_path / "mine.toml"
    path.write_text(saved_scene(scene, "by hand"))
    assert load_scene(path) == scene


def test_points_by_hand_are_checked_as_those_of_a_file():
    for wrong, why in (((8, 0.0, 0.0, 0.0), "links are 0 … 7"), ((1, 0.0, np.nan, 0.0), "not all numbers are finite")):
        with pytest.raises(ValueError, match=why):
            load_scene("panda", body_points=[wrong] * 5)
