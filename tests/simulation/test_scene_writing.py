"""A scene that is written as text or as a file is the same scene when it is read."""

import msgspec
import pytest
from page_fakes import Hands, call, quiet_model
from urdfs import arm, joint, link, write

from viewimit.loop.settings import Settings
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


def test_a_saved_scene_names_no_folder_and_runs_beside_its_urdf(tmp_path, ask, ask_json):
    files = []
    hand = joint("twist", "lower", "hand", xyz="0 0 0.3"), link("hand", "0.05 0.1 0.1")
    urdf = write(tmp_path / "secret", *arm(*hand), name="my arm.urdf")
    model, queue = quiet_model(Settings.paper(scene=f"{urdf}#tip=lower"), send=lambda *file: files.append(file))
    visitor = Hands(model, queue)
    visitor.act("edit points")
    call("place_point", 2, (0.04, 0.0, 0.1)).apply(model, 0.0)
    visitor.act("save scene")
    ((name, data),) = files
    assert b"secret" not in data and str(tmp_path).encode() not in data and len(model.session.world.robot.joints) == 3
    path = tmp_path / "elsewhere" / name
    path.parent.mkdir()
    path.write_bytes(data)
    status, _, told = ask("imitate", "--scene", path)
    assert status == 2 and told.count("\n") == 1 and "my arm.urdf, is not there: put it there, or name it by" in told
    status, told = ask_json("imitate", "--scene", path, "--robot", urdf)
    assert status == 0 and told["settings"]["points"] == 11
    beside = urdf.rename(path.parent / urdf.name)
    assert load_scene(path).robot == f"{beside}#tip=lower" == load_scene(path, beside).robot
    assert ask_json("imitate", "--scene", path)[1]["final_deg"] == told["final_deg"]
    with pytest.raises(ValueError, match="posture_deg has 3 angles, but other has 4 joints"):
        load_scene(path, beside.rename(path.parent / "other.urdf"))
