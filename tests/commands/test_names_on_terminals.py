"""Names that files give reach a terminal, JSON and scene files without what those would obey."""

import json

import numpy as np
import pytest

from viewimit.commands.cli import main
from viewimit.sensing.files import parse_toml
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

OBEYED = "\x1b]0;mine\x07", "\x9b31m", "\u202egnp", "\x7f", "a\nb"
WRITTEN = OBEYED[1] + OBEYED[2] + "&#10;robot = 1 " + OBEYED[3]  # in XML, which has no \x1b
BOX = '<visual><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry></visual>'


def harmless(text):
    return all(one.isprintable() or one == "\n" for one in text)


@pytest.fixture
def urdf(tmp_path):
    """An arm all of whose names are hostile; a mesh that is not there, and a joint that is held."""
    names = [f"{k}{WRITTEN}" for k in range(5)]
    mesh = f'<visual><geometry><mesh filename="{WRITTEN}.stl"/></geometry></visual>'
    links = "".join(f'<link name="{name}">{mesh if k == 3 else BOX}</link>' for k, name in enumerate(names))
    joints = "".join(
        f'<joint name="j{names[k]}" type="{kind}"><parent link="{names[k]}"/><child link="{names[k + 1]}"/>'
        f'<origin xyz="0 0 0.4"/><axis xyz="0 1 {k % 2}"/><limit lower="-1" upper="1"/></joint>'
        for k, kind in enumerate(("revolute", "planar", "revolute", "revolute"))
    )
    path = tmp_path / "arm.urdf"
    path.write_text(f"<robot name='r'>{links}{joints}</robot>", encoding="utf-8")
    return path


@pytest.mark.parametrize("words", [("scene",), ("scene", "--json"), ("imitate", "--max-motions", "1", "--robot")])
def test_of_a_robots_links_and_joints(urdf, capsys, words):
    main([*words, str(urdf)])
    out, err = capsys.readouterr()
    assert harmless(out) and harmless(err) and r"\u202egnp" in out + err
    if words == ("scene",):
        assert parse_toml(out.encode())["robot"] != 1


def test_of_tracked_points(tmp_path, capsys):
    lines = ["frame,view,point,x,y"]
    world = World(load_scene("panda"), 16)
    for frame, theta in enumerate(np.radians([(45, -90), (20, -40), (70, -140)])):
        seen = world.look(theta, theta).permuted(((2, 9),))
        for view, image in zip("lrLR", (seen.demo_left, seen.demo_right, seen.own_left, seen.own_right)):
            lines += [f'{frame},{view},"{k}{OBEYED[k % 5]}",{x!r},{y!r}' for k, (x, y) in enumerate(image.tolist())]
    path = tmp_path / "points.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    main(["evaluate", str(path)])
    told = capsys.readouterr().out
    assert harmless(told) and "swapped" in told and r"2\u202egnp" in told
    main(["evaluate", str(path), "--json"])
    told = capsys.readouterr().out
    assert harmless(told) and f"2{OBEYED[2]}" in json.loads(told)["points"]
