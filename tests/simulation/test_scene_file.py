"""A scene that a page saves for a robot of a person's own: it names the URDF, and nothing of the server's folders."""

import pytest
from page_fakes import Hands, quiet_model
from urdfs import arm, joint, link, write
from viewimit.app.control.commands.points import PlacePoint

from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene


def test_the_saved_scene_of_an_own_urdf_names_no_folder_and_runs_wherever_that_is(tmp_path, ask, ask_json):
    files = []
    hand = joint("twist", "lower", "hand", xyz="0 0 0.3"), link("hand", "0.05 0.1 0.1")
    urdf = write(tmp_path / "secret", *arm(*hand), name="my arm.urdf")
    model, queue = quiet_model(Settings.paper(scene=f"{urdf}#tip=lower"), send=lambda *file: files.append(file))
    visitor = Hands(model, queue)
    visitor.act("edit points")
    PlacePoint(2, (0.04, 0.0, 0.1)).apply(model, 0.0)
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
