"""Pictures of panels stand alone, in colours of print, and say what they show and what repeats them."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from drawn import IMAGE_L, OWN_POINTS
from page_fakes import call
from quiet_page import QuietPage
from viewimit.app.model.pictures import PICTURES

import viewimit
from viewimit.drawing.curves import draw_curves
from viewimit.drawing.export import figures
from viewimit.drawing.export.citation import cite
from viewimit.drawing.export.figures import can_typeset, four_images, overlay, stack, svg_elements
from viewimit.drawing.export.panels import Appearance, make_landscape
from viewimit.drawing.export.perspective import Viewpoint, default_viewpoint, draw_space
from viewimit.drawing.images.panel import draw_images
from viewimit.drawing.theme import ROLES
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene_geometry import bases_of

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def session():
    session = Session(Settings())
    session.run(3)
    return session


def text_of(picture):
    return " ".join("".join(each.itertext()) for each in ET.fromstring(picture).iter(f"{SVG}text"))


def test_a_picture_stands_alone_and_says_what_it_is_and_what_repeats_it(session):
    moment, citation = session.history[3], cite(session)
    images = draw_images(moment, *Appearance(session.world).of(moment), 7, print_size=True)
    made = make_landscape(session.world, moment)
    figures = (
        four_images(images, "The four images"),
        overlay([made.picture.html, made.picture.draw_path(session.history, 3)], "E over the postures"),
        stack([draw_curves(session.history, 3, made.E_true, session.scene.moving_joints)], "Both curves"),
        draw_space(session.world, session.snapshot),
    )
    for figure in figures:
        picture = figure.captioned(citation)
        root, said = ET.fromstring(picture), text_of(picture)
        assert "var(--" not in picture and "http" not in picture.replace("http://www.w3.org/2000/svg", "")
        assert figure.title in said and "seed 7" in said and f"viewimit {viewimit.__version__}" in said
        assert "".join(citation.command.split()) in "".join(said.split())
        assert ROLES["paper"][0] in picture and ROLES["paper"][1] not in picture
        assert float(root.get("height")) > figure.height
    own = [one for one in svg_elements(images) if IMAGE_L in one.classes][0]
    points = re.search(rf'<path class="{OWN_POINTS}" d="[^"]*"/>', own.inside)[0]
    assert points in figures[0].captioned(citation)  # the page's very drawing


def test_the_scene_is_seen_as_a_pinhole_camera_at_the_eye_would(session):
    world, moment = session.world, session.snapshot
    eye = default_viewpoint(world, moment)
    points = world.points_world(moment.theta, bases_of(world)["learner"])
    places, depth = eye.see(points)
    # by a projection matrix of its own making: x = f X / Z about the middle, y down
    forward = (eye.target - eye.position) / np.linalg.norm(eye.target - eye.position)
    assert np.allclose(depth, (points - eye.position) @ forward)
    width, height = 424, 424 / eye.aspect
    assert ((places > 0) & (places < (width, height))).all()
    focal = height / 2 / np.tan(eye.fov / 2)
    middle, _ = eye.see(eye.target)
    assert np.allclose(middle, (width / 2, height / 2))
    above, far = eye.see(eye.target + [0, 0, 0.1])
    across = np.sqrt(1 - forward[2] ** 2)
    assert middle[1] - above[1] == pytest.approx(focal * 0.1 * across / far)
    drawn = draw_space(world, moment, eye).inside
    assert drawn.count(f'fill="{ROLES["learner"][0]}"') >= len(points)
    behind = draw_space(
        world, moment, Viewpoint(eye.target, eye.position)
    ).inside  # nothing is drawn of what lies behind
    assert behind.count("<path") < 0.7 * drawn.count("<path")


def test_the_page_hands_out_a_replay_and_every_picture():
    page, got = QuietPage(Settings()), {}
    page.client.send_file_download = lambda name, data, **_: got.update({name: data})
    page.page.queue.call("step")
    page.tick(1.0)

    def save(command, name):
        page.page.queue.put(command)
        page.tick_until(lambda: name in got)
        return got[name]

    replay = save(call("save_replay"), "viewimit-replay.html").decode()
    assert "1 motions" not in replay and 'id="data"' in replay
    for what, why in (("Duel", "there is no duel"), ("Experiments", "the experiment is not done yet")):
        page.page.queue.call("picture", what)
        page.page.queue.call("save_picture")
        page.tick_until(lambda why=why: why in page.shown)
        assert not any(what.lower() in name for name in got)
    page.page.queue.call("duel")
    page.page.queue.call("step")
    page.tick(1.0)
    pictures = {}
    pictured = [what for what in PICTURES if what != "Experiments" and (can_typeset() or what != "Equations")]
    for what in pictured:
        page.page.queue.call("picture", what)
        name = f"viewimit-{what.split()[0].lower()}.svg"
        pictures[what] = text_of(save(call("save_picture"), name).decode())
        assert "seed 7" in pictures[what]
    duel = "".join(pictures["Duel"].split())
    for session in (page.page.model.session, page.page.model.duel.opponent):
        assert "".join(cite(session, session.snapshot.motion).command.split()) in duel
    assert "Aduelafter1step" in duel and "Largestjointerror" in duel
    if figures.can_render():
        page.page.queue.call("picture", "Curves")
        page.page.queue.call("picture_format", "PNG")
        png = save(call("save_picture"), "viewimit-curves.png")
        assert png[:4] == b"\x89PNG" and int.from_bytes(png[16:20], "big") == 4 * 440  # px: 15 cm at 300 an inch
