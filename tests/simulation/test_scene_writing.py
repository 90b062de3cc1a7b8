"""A scene that is written as text or as a file is the same scene when it is read."""

import msgspec
import pytest

from viewimit.sensing.files import is_text
from viewimit.simulation.scene import Scene, load_scene, scene_names
from viewimit.simulation.scene_writing import scene_text

OTHERS = {  # what is other than in a shipped scene
    "points": {"points": {"5": [[k, 0.1 / (k + 3), -1 / (k + 7), 1e-5 * k] for k in range(5)]}},
    "eyes": {"head": {"left": {"focal": [241.7, 239.3], "distortion": [-0.01, 0.002]}, "undistort": [-0.011, 0.0]}},
    "joints": {"moving_joints": [4], "range_deg": [[-119.5, -14 / 3]], "start_deg": [-40.1]},
    "bases": {"learner": {"position": [0.1, 0.2, -0.3], "yaw_deg": 1e-9}, "size": 1.25, "title": 'quoted "ü" \\ #'},
    "straight": {"head": {"toe_in_deg": 0.0}},
}


def told(name: str, other: dict) -> Scene:
    """A shipped scene with some of it replaced."""
    fields = msgspec.to_builtins(load_scene(name))
    for key, value in other.items():
        fields[key] = {**fields[key], **value} if key == "head" else value
    return msgspec.convert(fields, Scene)


@pytest.mark.parametrize("other", OTHERS)
def test_the_text_of_a_scene_is_the_same_scene(other):
    for name in scene_names():
        scene = told(name, OTHERS[other])
        text = scene_text(scene)
        assert is_text(text) and load_scene(text) == scene, name
        if other == "bases":
            assert f'extends = "{name}"' in text and len(text) < 250  # of what is the same nothing is said


def test_fields_of_a_shipped_scene_are_not_inherited_by_mistake():
    """Of scenes with unlike cameras or more layouts nothing can be taken back."""
    plain = msgspec.to_builtins(load_scene("panda-toed"))
    plain["head"] = {**plain["head"], "left": {}, "right": {}}
    assert 'extends = "panda-toed"' not in scene_text(msgspec.convert(plain, Scene))
    fewer = msgspec.to_builtins(load_scene("panda"))
    fewer["points"] = {"10": fewer["points"]["10"]}
    scene = msgspec.convert(fewer, Scene)
    assert load_scene(scene_text(scene)).points == scene.points


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('extends = "mine"\n', "no shipped scene"),
        ('extends = "../scenes/panda"\n', "no shipped scene"),
        ('extends = ["panda"]\n', "no shipped scene"),
        ('extends = "panda"\nrobot = "arm.urdf"\n', "none of"),
        ('extends = "panda"\nrobot = "../robots/panda"\n', "none of"),
        ('title = "no robot"\n', "none of"),
        ('extends = "panda"\n[head]\nfocal = nan\n', "not a finite number"),
        ('extends = "panda"\nsize = 1e300\n', "within"),
        ('extends = "panda"\n[head]\nimage = [20000, 10]\n', "image must be"),
        ('extends = "panda"\nmore = 1\n', "more"),
        ('extends = "panda"\ntitle = 1\n', "title"),
        (f'extends = "panda"\ntitle = "{"x" * 20_000}"\n', "characters"),
        (f"x = {'[' * 5_000}\n", "the scene"),
        (f"{'.'.join('a' * 3_000)} = 1\n", "parts"),
        ("arm.urdf\n", "the scene"),
        ("\n", "none of"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_a_text_that_is_no_scene_is_refused(text, says, tmp_path, monkeypatch):
    (tmp_path / "mine.toml").write_text('extends = "panda"\n')
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match="the scene") as refused:
        load_scene(text)
    assert says in str(refused.value)
