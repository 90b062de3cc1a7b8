"""Other descriptions of robots are refused with what converts them; robot_descriptions is asked without a network."""

import socket
import subprocess
import sys

import pytest
from urdfs import arm, write

from viewimit.simulation.scene import load_robot, load_scene
from viewimit.simulation.urdf.reference import description_path, require_urdf


@pytest.mark.parametrize("load", [load_robot, load_scene])
@pytest.mark.parametrize(
    "name, content, message",
    [
        ("arm.urdf.xacro", "", r"arm\.urdf\.xacro is xacro, not URDF; .*xacrodoc \S*arm\.urdf\.xacro -o \S*arm\.urdf$"),
        ("arm.xacro", "", r"-o \S*arm\.urdf$"),
        (
            "arm.xml",
            "<!-- <robot> --><mujoco model='a'/>",
            r"arm\.xml is MJCF.*convert\('\S*arm\.xml', '\S*arm\.urdf'\)",
        ),
        ("arm.mjcf", "", r"arm\.mjcf is MJCF"),
        ("lost.xml", None, r"lost\.xml is MJCF"),
        ("arm.sdf", "", r"arm\.sdf is SDF.*loadSDF\('\S*arm\.sdf'\).*saveUrdf\('\S*arm\.urdf'\)"),
        ("arm.xml", "<sdf version='1.6'/>", r"arm\.xml is SDF"),
        ("arm.xml", "<robot name='a'/>", r"arm\.xml is a URDF by another name: cp \S*arm\.xml \S*arm\.urdf"),
    ],
)
def test_other_formats_are_refused_in_one_line_with_the_command(tmp_path, load, name, content, message):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(ValueError, match=message) as refused:
        load(tmp_path / name)
    assert "\n" not in str(refused.value)


def test_the_command_for_sdf_converts_it(tmp_path):
    pytest.importorskip("pybullet")
    data = pytest.importorskip("pybullet_data")
    sdf = f"{data.getDataPath()}/kuka_iiwa/kuka_with_gripper.sdf"
    (tmp_path / "arm.sdf").symlink_to(sdf)
    with pytest.raises(ValueError) as refused:
        require_urdf(tmp_path / "arm.sdf")
    command = str(refused.value).partition("convert it: ")[2].replace("python", sys.executable, 1)
    command = command.replace(str(tmp_path / "arm.sdf"), sdf)
    subprocess.run(["bash", "-c", command], check=True, capture_output=True, timeout=60)
    assert len(load_robot(tmp_path / "arm.urdf").joints) == 7


@pytest.fixture
def descriptions(tmp_path, monkeypatch):
    """A package as robot_descriptions is, whose modules clone when they are imported; nobody has a network."""
    package = tmp_path / "site/robot_descriptions"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "_cache.py").write_text("import git_that_is_not_installed\n")
    (package / "_repositories.py").write_text(
        "class R:\n    cache_path = 'my-robots'\n\nREPOSITORIES = {'my-robots': R}\n"
    )
    start = (
        "from os import path\nfrom ._cache import clone_to_cache\n"
        "REPOSITORY_PATH = clone_to_cache('my-robots', commit=None)\n"
    )
    (package / "small_description.py").write_text(
        f"{start}URDF_PATH = path.join(REPOSITORY_PATH, 'arm', 'small.urdf')\n"
    )
    (package / "macro_description.py").write_text(f"{start}XACRO_PATH = path.join(REPOSITORY_PATH, 'a.urdf.xacro')\n")
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(socket, "socket", lambda *args, **options: pytest.fail("it asked the network"))
    yield tmp_path / "cache/my-robots"
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        del sys.modules[name]


def test_a_description_is_found_where_its_files_are(descriptions):
    with pytest.raises(ValueError, match="small_description: its files are not in .*my-robots; fetch them: python -c"):
        description_path("small_description")
    descriptions.mkdir(parents=True)
    with pytest.raises(ValueError, match=r"small_description: there is no .*small\.urdf; fetch it"):
        description_path("small_description")
    path = write(descriptions / "arm", *arm())
    assert description_path("small_description") == path
    assert "robot_descriptions.small_description" not in sys.modules  # the package's own import would find its own
