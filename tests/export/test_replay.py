"""A replay is one file that asks nobody for anything, and shows at each moment what the page showed."""

import base64
import io
import re
import zlib

import msgspec
import numpy as np
import pytest
from drawn import CHOSEN_POINT, HULL, IMAGE_R, OWN_POINTS, RECOVERED_POINTS, RESIDUALS
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from waiting import wait_until

import viewimit
from viewimit.analysis.construction import construct
from viewimit.drawing.export import panels as panels_module
from viewimit.drawing.export.citation import cite
from viewimit.drawing.export.panels import (
    MAX_SNAPSHOTS,
    Appearance,
    DedupedHTML,
    dedupe,
    kept_motions,
    largest_residual,
)
from viewimit.drawing.images.panel import draw_images
from viewimit.loop.script import MoveDemonstrator
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

replace = msgspec.structs.replace
MB = 1_000_000
ARM = """<robot name="r"><link name="base"/>
<link name="upper"><visual><geometry><cylinder length="0.4" radius="0.05"/></geometry></visual></link>
<link name="fore"><visual><geometry><box size="0.3 0.06 0.08"/></geometry></visual></link>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 0.4" rpy="0.3 0 0"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"""


def told(replay):
    """What the file has packed."""
    packed = re.search(r'id="run">([^<]*)<', replay.html)[1]
    return msgspec.json.decode(zlib.decompress(base64.b64decode(packed)))


def images(replay, k, point):
    """The four images at a moment, as the file has them for a chosen point."""
    panels = told(replay)["panels"]
    return DedupedHTML(**panels["images"][k])[panels["points"].index(point)]


@pytest.fixture(scope="module")
def session():
    """A run in toed-in cameras, whose demonstrator moves in the end."""
    session = Session(Settings(scene="panda-toed", start_deg=(25, -45), frames=1))
    session.run(20)
    session.pose(np.radians((50, -80)))
    session.step()
    return session


@pytest.fixture(scope="module")
def replay(session):
    return viewimit.replay(session)


def test_at_every_moment_it_shows_what_the_page_would(session, replay):
    run = told(replay)
    assert run["motions"] == list(range(len(session.history)))
    appearance, chosen = Appearance(session.world, session.history[0]), largest_residual(session.history[0])
    for k in (0, 3, len(session.history) - 1):
        moment = session.history[k]
        bodies, windows = appearance.of(moment)
        outline = draw_images(moment, bodies, windows, chosen)
        shown = images(replay, k, chosen)
        for kind in (OWN_POINTS, RECOVERED_POINTS, RESIDUALS, HULL):
            drawn = re.findall(rf'<path class="{kind}" d="[^"]*"', outline)
            assert drawn and all(path in shown for path in drawn)
        off = np.degrees(np.abs(moment.theta - moment.theta_demo).max())
        assert f"{off:.1f}° off" in run["panels"]["claims"][k] or off < 0.05
        assert "Viewer only" in run["panels"]["claims"][k] and "press space" not in run["panels"]["claims"][k]
    grounds = run["panels"]["ground"]
    assert grounds[0] == 0 and grounds[-1] == 1  # of the demonstrator's other posture


def test_every_point_can_be_chosen_and_costs_little(session, replay):
    appearance, panels = Appearance(session.world, session.history[0]), told(replay)["panels"]
    for moment in session.history:
        appearance.of(moment)
    assert panels["points"] == list(range(len(session.world.body)))
    for k, point in ((0, 0), (5, 9), (len(session.history) - 1, 4)):
        moment = session.history[k]
        drawn = draw_images(moment, *appearance.of(moment), point, construction=construct(moment, point))
        assert images(replay, k, point) == drawn
        ring = re.search(rf'{IMAGE_R}.*?<circle class="{CHOSEN_POINT}" cx="([-\d.]+)" cy="([-\d.]+)"', drawn)
        assert panels["places"][k][3][point] == [float(ring[1]), float(ring[2])]
    assert len(panels["images"]) * len(panels["points"]) * len(drawn) > 4 * len(msgspec.json.encode(panels["images"]))


@given(st.lists(st.text("ab<>", max_size=12), max_size=5))
def test_what_is_deduped_comes_out_as_it_was(drawings):
    deduped = dedupe(drawings)
    assert [deduped[k] for k in range(len(drawings))] == drawings and len(set(deduped.pieces)) == len(deduped.pieces)


def test_where_all_points_would_be_too_many_the_chosen_one_is_there(session, monkeypatch):
    monkeypatch.setattr(panels_module, "MAX_IMAGES", 10)
    small = viewimit.replay(session, chosen=6)
    panels = told(small)["panels"]
    assert panels["points"] == [6] and images(small, 0, 6) and all(len(one["indices"]) == 1 for one in panels["images"])


def test_it_says_what_repeats_it_and_tells_no_folder(tmp_path, ask_json):
    path = tmp_path / "someones-folder" / "my-arm.urdf"
    path.parent.mkdir()
    path.write_text(ARM)
    session = Session(Settings(scene=str(path), start_deg=(20, 30), demonstrator_deg=(40, 40), points=10))
    session.run(4)
    replay = viewimit.replay(session)
    cited = cite(session)
    assert "someones-folder" not in replay.html and "--scene=my-arm.urdf" in cited.command
    words = cited.command.replace("my-arm.urdf", str(path)).split()
    _, result = ask_json(*words[1:-1])
    assert result["final_deg"] == pytest.approx(np.degrees(session.snapshot.theta), abs=1e-6)
    assert f"viewimit {viewimit.__version__}" in replay.html and "seed 7" in replay.html
    assert len(told(replay)["space"]["links"]) >= 2 and len(replay.html) < 0.5 * MB


@pytest.mark.parametrize(
    "settings, motions, status",
    [
        (Settings.paper(servo="gradient-retuned", start_deg=(25, -45)), 100, "no-progress"),
        (Settings.paper(points=16, missing=0.75, transfer="linear"), 3, "too-few-points"),
        (
            Settings(joints=(1, 2, 3, 4, 5, 6, 7), points=16, demonstrator_deg=(10, 40, -10, -80, 15, 100, 30)),
            3,
            "",
        ),
    ],
)
def test_long_failed_and_many_jointed_runs_are_small(settings, motions, status):
    session = Session(settings)
    session.run(motions, patience=3)
    replay = viewimit.replay(session)
    assert session.snapshot.status == (status or session.snapshot.status)
    assert len(replay.html) < 0.8 * MB and len(told(replay)["motions"]) == len(session.history)


def test_a_run_of_a_hundred_motions_with_many_points_stays_small():
    session = Session(Settings.paper(points=16, servo="gradient-retuned", start_deg=(25, -45)))
    session.run(100, patience=3)
    replay = viewimit.replay(session)
    assert len(session.history) == 101 and len(told(replay)["panels"]["points"]) == 16
    assert len(replay.html) < 3 * MB


def test_of_a_long_run_moments_are_spread_and_both_ends_kept(session):
    long = [session.history[0].with_fields(motion=k) for k in range(1000)]
    kept = kept_motions(long)
    assert len(kept) <= MAX_SNAPSHOTS and kept[0] == 0 and kept[-1] == 999 and np.ptp(np.diff(kept)[:-1]) == 0
    assert kept_motions([long[k - k % 8] for k in range(1000)])[1] % 8 == 0  # what stands for others, once


def test_what_it_cannot_show_it_says(session):
    with pytest.raises(ValueError, match="no point 10; there are 10"):
        viewimit.replay(session, chosen=10)
    assert any(isinstance(action, MoveDemonstrator) for actions in session.log.actions.values() for action in actions)
    assert cite(session).command is None and "session.pose(" in cite(session).python


def test_the_command_writes_it_and_says_its_size(tmp_path, ask):
    path = tmp_path / "run.html"
    status, _, said = ask("imitate", "--max-motions", 2, "--out", path)
    assert status == 1 and f"written to {path}, {path.stat().st_size / MB:.2f} MB" in said
    status, _, said = ask("imitate", "--out", tmp_path / "run.docx")
    assert status == 2 and "there are .csv, .npz, .html" in said


def colours(page):
    picture = Image.open(io.BytesIO(page.locator("#space").screenshot())).convert("RGB")
    return len(picture.getcolors(picture.width * picture.height))


@pytest.mark.browser
def test_it_opens_from_a_file_slides_and_plays_and_asks_nobody(browser, session, replay, tmp_path):
    path = tmp_path / "run.html"
    assert replay.save(path) == path.stat().st_size < 0.5 * MB
    page = browser.new_page(viewport={"width": 1280, "height": 720}, color_scheme="light")
    faults, requests = [], []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    last, time = len(session.history) - 1, page.locator("#time")
    wait_until(
        lambda: page.evaluate(
            "document.querySelector('#path svg') && document.querySelector('#labels span').style.transform"
        )
    )
    assert colours(page) > 200
    assert page.evaluate("document.documentElement.scrollHeight") == 720  # all is seen together
    asks = page.locator(".vi-ask:visible").evaluate_all("all => all.map(one => [one.offsetWidth, one.offsetHeight])")
    assert len(asks) > 5 and all(size == [14, 14] for size in asks)  # none covers the number beside it

    start = page.locator("#claims").inner_text()
    time.fill("3")
    assert page.locator("#where").inner_text() == f"3 of {last}" and page.locator("#claims").inner_text() != start
    page.keyboard.press("End")
    assert page.locator("#where").inner_text() == f"{last} of {last}"
    page.keyboard.press("ArrowLeft")
    assert page.locator("#where").inner_text() == f"{last - 1} of {last}"
    page.locator("#speed").select_option("25")
    page.locator("#play").click()  # on from there, to the end
    wait_until(lambda: page.evaluate(f"document.querySelector('#where').value == '{last} of {last}'"))
    wait_until(lambda: page.locator("body.playing").count() == 0)
    box = page.locator("#conflict").bounding_box()
    page.mouse.click(box["x"] + 0.1 * box["width"], box["y"] + 0.5 * box["height"])  # the curve's left end
    assert page.locator("#where").inner_text() == f"0 of {last}"

    ring = """[...document.querySelectorAll("#images .vi-at-L .vi-ring")].map(
        one => [one.cx, one.cy].map(place => place.baseVal.value))"""
    places = told(replay)["panels"]["places"]
    for digit in (0, 9, 4):
        page.keyboard.press(str(digit))
        assert page.evaluate(ring) == [pytest.approx(places[0][2][digit])]
    page.keyboard.press("n")
    assert page.evaluate(ring) == [pytest.approx(places[0][2][5])]
    box = page.locator("#images .vi-at-R").bounding_box()
    scale, (x, y) = (
        box["width"] / page.evaluate("document.querySelector('#images .vi-at-R').viewBox.baseVal.width"),
        places[0][3][8],
    )
    page.mouse.click(box["x"] + scale * x, box["y"] + scale * y)
    assert page.evaluate(ring) == [pytest.approx(places[0][2][8])]
    page.keyboard.press("ArrowRight")  # it stays chosen
    assert page.evaluate(ring) == [pytest.approx(places[1][2][8])]
    page.keyboard.press("Home")

    run = told(replay)["space"]
    rows = page.evaluate(
        "() => replay.framesOf('learner', replay.moments.at(-1).learner).map(frame => Array.from(frame))"
    )
    frames = np.array(rows).reshape(-1, 3, 4)
    world, points = session.world, np.array(run["points"]["local"])
    placed = np.einsum("nij,nj->ni", frames[run["points"]["link"]], np.column_stack([points, np.ones(len(points))]))
    truth = world.points_world(session.history[-1].theta, world.T_world_own)
    assert np.allclose(placed, truth, atol=2e-4)  # m; coordinates are kept to a tenth of a mm

    page.keyboard.press("d")
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(240, 242, 245)"
    page.set_viewport_size({"width": 390, "height": 844})
    wait_until(lambda: page.evaluate("document.querySelector('#space').width < 800"))
    assert page.evaluate("document.documentElement.scrollWidth") == 390 and colours(page) > 200
    assert page.locator("#play").is_visible()
    assert [url for url in requests if not url.startswith(("file:", "data:"))] == [] and len(requests) <= 3
    assert faults == []

    page.set_content(f"<body>{replay._repr_html_()}</body>")  # a cell of a notebook
    page.frame_locator("iframe").locator("#path svg").wait_for()
    page.close()
