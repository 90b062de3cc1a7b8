"""A robot of a person's own on the page, from its URDF alone: drawn in 3-D and in the images, its joints where they are
in truth, one that mimics another too. Its server is its own: once that is no more, the page says so."""

import numpy as np
import pytest
from browsing import open_page, press, wait
from serving import Server
from viewimit.app.scene.arms import link_name

from viewimit.simulation.robot import link_meshes
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

pytestmark = pytest.mark.browser

LIMIT = '<limit lower="-2" upper="2"/>'
MIMIC = f'{LIMIT}<mimic joint="elbow" multiplier="-1.5"/>'
FRAMES = """() => Object.fromEntries(Object.entries(window.__viserMutable.nodeRefFromName)
  .filter(([name, node]) => node).map(([name, node]) => [name, node.matrixWorld.elements]))"""
SAID = "getComputedStyle(document.querySelector('.vi-status'), '::before').content"
SILHOUETTES = '[aria-label="The four images"] path, [aria-label="The four images"] polygon'


def part(name, parent, xyz, axis, size, more=LIMIT):
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{more}</joint>'
        f'<link name="{name}_link"><visual><geometry><box size="{size}"/></geometry></visual></link>'
    )


@pytest.fixture(scope="module")
def urdf(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "my-arm.urdf"
    path.write_text(
        '<robot name="mine"><link name="base"><visual><geometry><box size="0.3 0.3 0.2"/></geometry></visual></link>'
        + part("yaw", "base", "0 0 0.2", "0 0 1", "0.1 0.2 0.2")
        + part("lift", "yaw_link", "0.1 0 0.2", "0 1 0", "0.1 0.1 0.5")
        + part("elbow", "lift_link", "0 0 0.5", "0 1 0", "0.1 0.08 0.4")
        + part("tilt", "elbow_link", "0 0 0.4", "0 1 0", "0.2 0.1 0.1", MIMIC)
        + "</robot>"
    )
    return path


def test_it_is_drawn_in_light_and_dark_with_its_joints_where_they_are_until_the_connection_is_lost(browser, urdf):
    served = Server("--robot", str(urdf), "--joints", "2,3")
    page = open_page(browser, served.url, "small", color_scheme="light")
    scene = load_scene(urdf, joints=(2, 3))
    world, links = World(scene), sorted(link_meshes(str(urdf)))
    assert links == [0, 1, 2, 3, 4] and scene.moving_joints == (2, 3)

    def agree(theta):
        """Rotations in the scene, three.js's world apart, against kinematics: of every link to its base."""
        frames = page.evaluate(FRAMES)
        names = [link_name(scene, "learner", link) for link in links]
        if not all(f"{name}/mesh" in frames for name in names):
            return False
        seen = [np.reshape(frames[name], (4, 4)).T[:3, :3] for name in names]
        true = world.link_frames(np.radians(theta), np.eye(4))[:, :3, :3]
        return all(np.allclose(seen[0].T @ one, two, atol=1e-4) for one, two in zip(seen, true))

    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        page.wait_for_function("scheme => document.documentElement.dataset.mantineColorScheme == scheme", arg=scheme)
        wait(page, lambda: agree(scene.start_deg))
        assert page.locator(SILHOUETTES).count() > 2 * len(links)
        press(page, "ArrowRight")
        wait(page, lambda: not agree(scene.start_deg))
        press(page, "r")
    assert page.problems == [] and page.evaluate(SAID) == "none"
    assert served.stop() == 0
    wait(page, lambda: page.evaluate(SAID) == '"Connection lost, reconnecting …"')
    page.close()
