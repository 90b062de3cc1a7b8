"""Scene files: the shipped ones hold together; a wrong one is refused with its file and field."""

from functools import partial

import msgspec
import numpy as np
import pytest

from viewimit.geometry.distortion import RadialDistortion
from viewimit.sensing.lens_files import read_lenses
from viewimit.simulation.camera import Lens
from viewimit.simulation.robot import load_markers, robot_names
from viewimit.simulation.scene import ROOT, load_robot, load_scene, scene_names
from viewimit.simulation.world import World


def test_files_that_an_older_msgspec_refuses_are_named(tmp_path, monkeypatch):
    """Before 0.21 its errors are no ValueError."""
    path, _ = tmp_path / "lens.json", load_scene("panda")
    path.write_text("{}")

    def refuse(*_, **__):
        raise msgspec.MsgspecError("Expected `int`")

    for place, name in ((msgspec, "convert"), (msgspec.toml, "decode"), (msgspec.json, "decode")):
        monkeypatch.setattr(place, name, refuse)
    for read in (partial(load_scene, "panda"), partial(load_markers, "panda"), partial(read_lenses, path)):
        with pytest.raises(ValueError, match=r"(panda\.toml|lens\.json): .*Expected"):
            read()


@pytest.fixture
def scene_file(tmp_path):
    """Writes a TOML file beside copies of the shipped ones."""
    for path in (ROOT / "scenes").glob("*.toml"):
        (tmp_path / path.name).write_text(path.read_text())

    def write(text, name="mine.toml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_load_and_show_their_demonstrator(name):
    world = World(load_scene(name))
    points, visible = world.demo_images(np.radians(world.scene.posture_deg)[world.scene.moving])
    assert visible.all() and np.isfinite(points).all()


def test_extends_takes_the_other_fields(scene_file):
    scene = load_scene(scene_file('extends = "panda"\ntitle = "Mine"\n[head]\nbaseline = 0.3\n'))
    parent = load_scene("panda")
    assert scene.title == "Mine" and scene.head.baseline == 0.3
    assert scene.head.focal == parent.head.focal and scene.points == parent.points


def test_each_camera_may_differ_from_the_head(scene_file):
    text = 'extends = "panda"\n[head]\ntoe_in_deg = 5\n[head.left]\nfocal = [250, 260]\ndistortion = [-0.1, 0.01]\n'
    head = load_scene(scene_file(text)).stereo_head()
    assert head.left == Lens((250, 260), (320, 120), RadialDistortion(-0.1, 0.01)) and head.right == Lens(
        (256, 256), (320, 120)
    )
    assert head.toe_in == np.radians(5)


FAULTY = [
    ('extends = "panda"\ncolour = 3\n', "unknown field `colour`"),
    ('extends = "panda"\n[head]\nzoom = 3\n', r"unknown field `zoom` - at `\$.head`"),
    ('extends = "panda"\n[head]\ntoe_in_deg = 50\n', "head.toe_in_deg must be between 0 and 45, got 50"),
    ('extends = "panda-verged"\n[head]\ntoe_in_deg = 5\n', "cameras that are verged look at the gaze point"),
    ('extends = "panda"\n[head.left]\nfocal = 3\n', r"got `int` - at `\$.head.left.focal`"),
    ('extends = "panda"\n[head.left]\nfocal = [3, -1]\n', "head.left: focal lengths must be more than 0"),
    ('extends = "panda"\n[head.right]\ndistortion = [-0.4, 0]\n', "head.right: distortion .* folds its image"),
    ('extends = "panda"\n[head]\nfocal = "long"\n', r"Expected `float`, got `str` - at `\$.head.focal`"),
    ('title = "Mine"\n', "missing required field `robot`"),
    ('extends = "panda"\nposture_deg = [0, 45]\n', "posture_deg has 2 angles, but panda has 7 joints"),
    ('extends = "panda"\nstart_deg = [25]\n', "moving_joints, range_deg and start_deg"),
    ('extends = "panda"\nmoving_joints = [2, 2]\n', "moving_joints, range_deg and start_deg"),
    ('extends = "panda"\nmoving_joints = [2, 9]\n', "no joint 9"),
    ('extends = "panda"\nrange_deg = [[90, 0], [-180, 0]]\n', "joint 2: range_deg 90 … 0 is empty"),
    ('extends = "panda"\nstart_deg = [25, 40]\n', "learner's start joint 4 at 40° is outside"),
    ('extends = "panda"\nrobot = "r2d2"\n', "no robot 'r2d2'; there are iiwa, panda"),
    ('extends = "panda"\n[points]\n3 = [[0, 0, 0, 0]]\n', "points.3 has 1 points"),
    ('extends = "panda"\n[points]\n0 = []\n', "points.0 has no points"),
    (
        f'extends = "panda"\n[points]\n5 = {[[1, 0, 0, 0]] * 2 + [[2, 0, 0, 0]] * 3}\n',
        "points.5: only 2 points differ, at",
    ),
    ('extends = "panda"\nposture_deg = [500, 45, 0, -90, 0, 90, 45]\n', "posture_deg: joint 1 at 500° is outside"),
    ('extends = "panda"\n[head]\ngaze_learner = [0.0, 0.0, 9.0]\nposition = [0, 0, 2]\n', "head.gaze_learner .*up"),
    ('extends = "panda"\n[head]\nposition = [0, 0, 2]\ngaze_demonstrator = [0, 0, 2]\n', "head.gaze_demonstr"),
    ('extends = "panda"\n[points]\n1 = [[8, 0, 0, 0]]\n', "points.1: links are 0 … 7"),
    ('extends = "panda"\nmoving_joints = [4, 2]\n', "moving_joints .* must ascend"),
    ('extends = "nowhere"\n', "extends 'nowhere', but there is no"),
    ("title = \n", "Invalid value"),
    ("[points\n", "Expected"),
]


def test_errors_name_the_file_and_the_field(scene_file):
    for text, message in FAULTY:
        with pytest.raises(ValueError, match=rf"mine\.toml: .*{message}"):
            load_scene(scene_file(text))


def test_unknown_scene_robot_and_layout_are_refused_with_a_list(tmp_path):
    with pytest.raises(ValueError, match="no scene 'kitchen'; there are .*panda"):
        load_scene("kitchen")
    with pytest.raises(ValueError, match="no robot 'r2d2'; there are iiwa, panda"):
        load_robot("r2d2")
    with pytest.raises(ValueError, match="no layout of 11 points in this scene; it has .*10, 16, 20"):
        load_scene("panda").body_points(11)
    assert robot_names() == ("iiwa", "panda")


def test_other_joints_may_move_within_the_robots_limits_from_rest():
    scene = load_scene("panda", joints=(2, 4, 6))
    assert scene.moving_joints == (2, 4, 6) and scene.range_deg[:2] == load_scene("panda").range_deg
    assert scene.range_deg[2] == pytest.approx((-5.0, 219.0), abs=0.1)  # -0.0873 … 3.8223 in the URDF
    assert scene.start_deg == (25, -25, 90)
    everything = load_scene("iiwa", joints=tuple(range(1, 8)))
    assert len(everything.range_deg) == 7
