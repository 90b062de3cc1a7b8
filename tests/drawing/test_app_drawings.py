"""The page's drawings say what the arrays say, in both themes, and stay small."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from drawn import (
    CHOSEN_POINT,
    E_CURVE,
    EPIPOLAR_LINE,
    FROM_LEFT,
    FROM_PARTNER,
    FROM_RIGHT,
    LEARNERS_PATH,
    OWN_POINTS,
    RECOVERED_POINTS,
    RESIDUALS,
    VIEW_NAME,
    classes,
    marked,
    numbers,
    only,
    parsed,
    path,
)
from viewimit.assets import ROOT

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.analysis.self_assessment import assess
from viewimit.drawing import curves, equations, status, svg
from viewimit.drawing import landscape as landscape_drawing
from viewimit.drawing.images import panel
from viewimit.drawing.images.planes import image_windows
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.estimation.equations import MISSING
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.transfers.transfer import conflict
from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import ServoStatus
from viewimit.simulation.appearance import Silhouettes, points_in_images

MATHML = "{http://www.w3.org/1998/Math/MathML}"


def meshes(robot):
    loaded = trimesh.load(ROOT / "robots" / robot / f"{robot}.glb", process=False)
    return {int(name.removeprefix("link")): mesh.vertices for name, mesh in loaded.geometry.items()}


def stepped(motions, **settings):
    session = Session(Settings.paper(**{"start_deg": (25, -25), **settings}))
    for _ in range(motions):
        session.step()
    return session


def seen_as(snapshot, views):
    """The snapshot, had the learner seen these views."""
    seen = replace(snapshot, views=views)
    return seen.with_fields(E=float(conflict(seen.e[seen.usable])))


@pytest.fixture(scope="module")
def session():
    return stepped(4)


@pytest.fixture(scope="module")
def picture(session):
    return landscape_drawing.LandscapePicture(surface(session), session.scene, session.snapshot)


def surface(session):
    views, fit = session.snapshot.views, TRANSFERS[session.settings.transfer]
    return landscape_over(session.world, fit, views.demo, views.visible[:, :2], grid_axes(session.world))


@pytest.fixture(scope="module")
def silhouettes(session):
    return Silhouettes(meshes("panda"), session.world)


def postures(snapshot):
    return snapshot.theta_demo, snapshot.theta, snapshot.transfer


def drawn(session, chosen=None, silhouettes=None, snapshot=None, **options):
    silhouettes = silhouettes or Silhouettes({}, session.world)
    snapshot = snapshot or session.snapshot
    return panel.draw_images(
        snapshot, silhouettes.bodies(*postures(snapshot)), windows_of(session, silhouettes), chosen, **options
    )


def windows_of(session, silhouettes=None):
    bodies = (silhouettes or Silhouettes({}, session.world)).bodies(*postures(session.snapshot))
    return image_windows(points_in_images(bodies), session.scene.head.image)


def planes(html):
    """The four boxes by the name written in them."""
    boxes = {}
    for box in parsed(html).iter("svg"):
        name = next((t.text for t in box.findall("text") if VIEW_NAME in classes(t)), None)
        if name:
            boxes[name] = box
    return boxes


def starts(d):
    """Where each subpath of a drawing begins."""
    return np.array([numbers(part)[:2] for part in d.split("M")[1:]])


def affine_snapshot(session):
    """Both bodies alike, four exact affine cameras."""
    rng = np.random.default_rng(3)
    points = rng.standard_normal((10, 3))
    centres = ((360, 120), (290, 125), (365, 115), (265, 122))
    views = [points @ (12 * rng.standard_normal((3, 2))) + centre for centre in centres]
    return seen_as(session.snapshot, FourViews.from_images(*views))


class TestImages:
    @pytest.mark.parametrize("chosen", [0, 4, 9])
    @pytest.mark.parametrize("whole", [False, True])
    def test_epipolar_lines_of_affine_views_meet_in_the_matched_point(self, session, chosen, whole):
        html = drawn(session, chosen, snapshot=affine_snapshot(session), whole_frames=whole)
        for name, box in planes(html).items():
            (ring,) = only(box, "circle", CHOSEN_POINT)
            centre = np.array([float(ring.get("cx")), float(ring.get("cy"))])
            lines = marked(box, "path", EPIPOLAR_LINE)
            assert {line.get("class") for line in lines} == {FROM_LEFT, FROM_RIGHT, FROM_PARTNER}, name
            for line in lines:
                a, b = numbers(line.get("d")).reshape(2, 2)
                off = np.cross([*(b - a), 0], [*(centre - a), 0])[2] / np.linalg.norm(b - a)
                assert abs(off) < 0.2

    @pytest.mark.parametrize("steps, gain", [(0, 1), (4, 5)])  # the longest residual has 27 and 2.7 px
    def test_arrows_run_from_the_recovered_points_towards_the_own(self, steps, gain):
        session = stepped(steps)
        for box in (planes(drawn(session))[name] for name in "LR"):
            arrows = numbers(path(box, RESIDUALS)).reshape(-1, 4)
            own, recovered = starts(path(box, OWN_POINTS)), starts(path(box, RECOVERED_POINTS))
            assert arrows[:, :2] == pytest.approx(recovered, abs=0.11)
            assert arrows[:, 2:] - arrows[:, :2] == pytest.approx(gain * (own - recovered), abs=0.11 * (1 + gain))

    def test_too_few_points_leave_frames_points_and_dashes(self):
        session = stepped(0, missing=0.5)
        assert session.snapshot.transfer is None
        html = drawn(session, 1)
        text = " ".join(parsed(html).itertext())
        assert text.count(MISSING) >= 4 and "nan" not in html and f"{session.snapshot.usable.sum()}" in text
        assert not only(planes(html)["L"], "path", RESIDUALS)


class TestSilhouettes:
    def test_a_hull_reaches_as_far_as_its_mesh(self, session, silhouettes):
        """In every direction the polygon's support is that of all vertices, to 2.5 px."""
        world = session.world
        frames = world.link_frames(session.snapshot.theta, world.T_world_own)
        hulls, origins = silhouettes.seen(frames, world.own_pair)
        for camera, pixels in zip(world.own_cameras, origins):
            assert pixels == pytest.approx(camera.project(frames[:, :3, 3].T)[0].T)
        angles = np.linspace(0, 2 * np.pi, 50)
        directions = np.stack([np.cos(angles), np.sin(angles)])
        for link, vertices in meshes("panda").items():
            placed = vertices @ frames[link, :3, :3].T + frames[link, :3, 3]
            for side, camera in enumerate(world.own_cameras):
                image = camera.project(placed.T)[0].T
                short = (image @ directions).max(0) - (hulls[side, link] @ directions).max(0)
                assert -1e-9 < short.min() and short.max() < 2.5


class TestLandscape:
    def test_path_runs_through_the_postures(self, session, picture):
        plane = PosturePlane(session.scene)
        over = parsed(picture.draw_path(session.history, session.cursor))
        line = path(over, LEARNERS_PATH)
        expected = plane.place(np.degrees([snapshot.theta for snapshot in session.history]))
        assert numbers(line).reshape(-1, 2) == pytest.approx(expected, abs=0.06)


class TestCurves:
    def test_points_stand_at_E_on_a_log_axis(self, session):
        root = parsed(curves.draw_curves(session.history, session.cursor, 1.59, (2, 4)))
        line = path(root, E_CURVE)
        y = numbers(line).reshape(-1, 2)[:, 1]
        E = np.log([snapshot.E for snapshot in session.history])
        slope = (y[-1] - y[0]) / (E[-1] - E[0])
        assert slope < 0 and y == pytest.approx(y[0] + slope * (E - E[0]), abs=0.2)

    def test_unknown_E_interrupts_the_line(self, session):
        history = [*session.history[:2], replace(session.history[2], E=np.nan), *session.history[3:]]
        root = parsed(curves.draw_curves(history, 4, None, (2, 4)))
        line = path(root, E_CURVE)
        assert line.count("M") == 2 and "nan" not in line


def conflict_of(session):
    """Eq. (6), before the servo's law."""
    return next(
        card for card in parsed(equations.draw_equations(session.snapshot)).iter("div") if card[0].text == "(6)"
    )


class TestEquations:
    def test_the_sums_over_L_and_R_make_E(self, session):
        words = " ".join(conflict_of(session).itertext())
        left, right, count, E = (float(word) for word in re.findall(r"\d+\.?\d*", words)[-4:])
        assert (left + right) / count == pytest.approx(session.snapshot.E, abs=0.02) == pytest.approx(E, abs=0.02)

    def test_the_constraint_holds_for_affine_views(self, session):
        seen = affine_snapshot(session)
        first = next(parsed(equations.draw_equations(seen, 3)).iter(f"{MATHML}math"))
        assert list(first.iter(f"{MATHML}mn"))[-1].text == "0.0"
        pairs = seen.fundamental
        assert abs(pairs.f[0] @ [*seen.views.demo[3, :2], *seen.views.own[3, :2]] + pairs.f33[0]) < 0.005


class TestStatus:
    def test_what_the_learner_says_knows_no_posture(self, session):
        hidden = replace(session.snapshot, theta=np.full(2, np.nan), theta_demo=np.full(2, np.nan))
        assert status.describe(hidden, session.history[:-1]) == status.describe(session.snapshot, session.history[:-1])

    @pytest.mark.parametrize("noise_px, said", [(0.0, "within 0.1°"), (0.5, "within 0.")])
    def test_a_claim_says_how_exact_it_is(self, noise_px, said):
        session = Session(Settings(noise_px=noise_px))
        session.run()
        claim = status.describe(session.snapshot, assessment=assess(session), joints=(2, 4))
        assert claim.state == "converged" and said in claim.sentence


@pytest.fixture(scope="module")
def drawings(session, silhouettes, picture):
    few = stepped(0, missing=0.5)
    return [
        drawn(session, 4, silhouettes),
        drawn(session, None, silhouettes, whole_frames=True),
        drawn(few, 1),
        picture.html,
        picture.draw_path(session.history, session.cursor),
        picture.draw_path(session.history, 1, np.array([0.5, -0.6])),
        curves.draw_curves(session.history, 2, 1.6, (2, 4), 980),
        curves.draw_curves(few.history, 0, None, (2, 4)),
        equations.draw_equations(session.snapshot),
        equations.draw_equations(few.snapshot),
        *(status.draw_status(status.StatusMessage(state, "x", "y"), "w") for state in (*status.TITLES, *ServoStatus)),
    ]


class TestEverything:
    def test_is_valid_xml(self, drawings):
        for drawing in drawings:
            parsed(drawing)

    def test_writes_a_real_minus(self, drawings):
        for drawing in drawings:
            assert not re.search(r"-\d", "".join(parsed(drawing).itertext()))

    def test_escapes_what_people_write(self):
        hostile = '<img src=x onerror="1">&'
        strip = status.draw_status(status.StatusMessage("message", hostile, hostile), hostile)
        assert "<img" not in strip and "<img" not in svg.text(0, 0, hostile)
        assert parsed(strip)


@pytest.mark.parametrize("seed", range(2))
def test_equations_and_status_survive_the_loss_of_points(seed):
    session = Session(Settings.paper(points=16, missing=0.25, transfer="linear", seed=seed))
    for _ in range(15):
        session.step()
        ElementTree.fromstring(equations.draw_equations(session.snapshot).replace("&nbsp;", " "))
        said = status.describe(session.snapshot)
        assert (said.state == "too-few-points") == (session.snapshot.transfer is None)
