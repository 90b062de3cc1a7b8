"""A replay is one file that asks nobody for anything, and shows at each moment what the page showed."""

import base64
import io
import re
import zlib

import msgspec
import numpy as np
import pytest
from browsing import SPARING, sparing
from PIL import Image
from viewimit.app.lab.recording import MAP_DEG, PX, RAD, SHARE
from waiting import wait_until

import viewimit
from viewimit.drawing.export.citation import cite
from viewimit.drawing.export.panels import compute_landscape, make_landscape
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

replace = msgspec.structs.replace
MB = 1_000_000


def unpacked(replay):
    """What the file has packed."""
    packed = re.search(r'id="data">([^<]*)<', replay.html)[1]
    return msgspec.json.decode(zlib.decompress(base64.b64decode(packed)))


def numbers(values):
    """Hundredths of a px as px; null as NaN."""
    return np.array(values, float) / PX


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


def test_at_every_moment_it_has_what_the_learner_saw_and_made_of_it(session, replay):
    run = unpacked(replay)["run"]
    assert [each["motion"] for each in run["snapshots"]] == list(range(len(session.history)))
    for recorded, moment in zip(run["snapshots"], session.history):
        demo = run["demonstrators"][recorded["demo"]]
        np.testing.assert_allclose(np.array(recorded["theta"]) / RAD, moment.theta, atol=1e-6)
        np.testing.assert_allclose(np.array(demo["theta"]) / RAD, moment.theta_demo, atol=1e-6)
        for name, images in (("own", moment.views.own), ("recovered", moment.recovered)):
            np.testing.assert_allclose(numbers(recorded[name]), images.ravel(), atol=0.01)
        np.testing.assert_allclose(numbers(demo["images"]), moment.views.demo.ravel(), atol=0.01)
        assert recorded["E"] == pytest.approx(moment.E, rel=1e-5)
        off = np.degrees(np.abs(moment.theta - moment.theta_demo).max())
        assert f"{off:.1f}° off" in recorded["truth"] or off < 0.05
        assert "press space" not in recorded["sentence"]
    assert run["snapshots"][0]["map"] == 0 and run["snapshots"][-1]["map"] == 1  # of the demonstrator's other posture


def test_the_map_has_E_over_both_joints(session, replay):
    run, moment = unpacked(replay)["run"], session.history[0]
    wanted = compute_landscape(session.world, moment, MAP_DEG)
    found = run["maps"][0]
    E = np.exp(np.cumsum(found["level"]) / SHARE).reshape(found["size"])
    E.ravel()[np.array(found["unknown"], int)] = np.nan
    np.testing.assert_allclose(E, wanted.E, rtol=1e-3)
    np.testing.assert_allclose(np.array(found["minimum"]) / RAD, wanted.minimum, atol=1e-6)
    assert found["E_true"] == pytest.approx(make_landscape(session.world, moment).E_true)


def test_it_says_what_repeats_it_and_tells_no_folder(own_arm, ask_json):
    session = Session(Settings(scene=str(own_arm), start_deg=(20, 30), demonstrator_deg=(40, 40), points=10))
    session.run(4)
    replay = viewimit.replay(session)
    cited = cite(session)
    assert "someones-folder" not in replay.html and "--scene=my-arm.urdf" in cited.command
    words = cited.command.replace("my-arm.urdf", str(own_arm)).split()
    _, result = ask_json(*words[1:-1])
    assert result["final_deg"] == pytest.approx(np.degrees(session.snapshot.theta), abs=1e-6)
    assert f"viewimit {viewimit.__version__}" in replay.html and "seed 7" in replay.html
    assert len(unpacked(replay)["robot"]["links"]) >= 2 and len(replay.html) < 0.5 * MB


@pytest.mark.parametrize(
    "settings, motions, status",
    [
        (Settings.paper(servo="gradient-retuned", start_deg=(25, -45)), 100, "no-progress"),
        (Settings.paper(points=16, missing=0.75, transfer="linear"), 3, "too-few-points"),
        (Settings(joints=(1, 2, 3, 4, 5, 6, 7), points=16, demonstrator_deg=(10, 40, -10, -80, 15, 100, 30)), 3, ""),
    ],
)
def test_long_failed_and_many_jointed_runs_are_small(settings, motions, status):
    session = Session(settings)
    session.run(motions, patience=3)
    replay = viewimit.replay(session)
    assert session.snapshot.status == (status or session.snapshot.status)
    assert len(replay.html) < 0.8 * MB and len(unpacked(replay)["run"]["snapshots"]) == len(session.history)


def test_the_command_writes_it_and_says_its_size(tmp_path, ask):
    path = tmp_path / "run.html"
    status, _, said = ask("imitate", "--max-motions", 2, "--out", path)
    assert status == 1 and f"written to {path}, {path.stat().st_size / MB:.2f} MB" in said
    status, _, said = ask("imitate", "--out", tmp_path / "run.docx")
    assert status == 2 and "there are .csv, .npz, .html" in said


def colours(page):
    picture = Image.open(io.BytesIO(page.locator("#space").screenshot())).convert("RGB")
    return len(picture.getcolors(picture.width * picture.height))


@pytest.fixture
def opened(browser, tmp_path):
    """Opens a replay from a file in a window of its own, which must ask nobody and have no fault."""
    pages, faults, requests = [], [], []

    def open_(replay, address="", width=1280, height=720, before=None, **options):
        path = tmp_path / "run.html"
        assert replay.save(path) == path.stat().st_size
        page = browser.new_page(viewport={"width": width, "height": height}, color_scheme="light", **options)
        page.add_init_script("try { localStorage['viewimit-in-3d'] = 1 } catch {}")
        pages.append(page)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        page.on("request", lambda request: requests.append(request.url))
        if before is not None:
            page.add_init_script(before)
        page.goto(path.as_uri() + address)
        wait_until(lambda: page.evaluate("document.querySelector('#l .vi-seen')?.getAttribute('d') || false"))
        return page

    yield open_
    for page in pages:
        page.close()
    assert faults == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "about:"))] == []


def place_of(page, view, point):
    """px of the window where a point is drawn in an image."""
    box = page.locator(f"#{view}").bounding_box()
    x, y = page.evaluate(
        """([k, i]) => {
            const {images} = replay.view, {demo, own} = replay.moment.views;
            const of = k < 2 ? demo : own, at = 4 * i + 2 * (k & 1);
            return images.place(k, of[at], of[at + 1]).map(v => v * images.unit);
        }""",
        ["lrLR".index(view), point],
    )
    return box["x"] + x, box["y"] + y


@pytest.mark.browser
def test_it_opens_from_a_file_slides_and_plays_and_asks_nobody(session, replay, opened):
    assert len(replay.html) < 0.5 * MB
    page = opened(replay)
    last, time = len(session.history) - 1, page.locator("#time")
    wait_until(lambda: page.evaluate("document.querySelector('#labels span').style.transform"))
    assert colours(page) > 200
    assert page.evaluate("document.documentElement.scrollHeight") == 720  # all is seen together
    asks = page.locator(".vi-ask:visible").evaluate_all("all => all.map(one => [one.offsetWidth, one.offsetHeight])")
    assert len(asks) > 5 and all(size == [14, 14] for size in asks)

    where = lambda: page.locator("#where").inner_text()
    start = page.locator(".card").inner_text()
    time.fill("3")
    wait_until(lambda: where() == f"3 of {last}" and page.locator(".card").inner_text() != start)
    page.keyboard.press("End")
    assert where() == f"{last} of {last}"
    page.keyboard.press("ArrowLeft")
    assert where() == f"{last - 1} of {last}"
    page.locator("#speed").select_option("25")
    page.locator("#run").click()  # on from there, to the end
    wait_until(lambda: page.evaluate(f"document.querySelector('#where').value == '{last} of {last}'"))
    wait_until(lambda: page.locator("body.playing").count() == 0)
    for curve in ("#curve", "#angles"):  # are sliders, too
        box = page.locator(curve).bounding_box()
        page.mouse.click(box["x"] + 0.1 * box["width"], box["y"] + 0.5 * box["height"])
        assert where() == f"0 of {last}"
        page.keyboard.press("End")
    page.keyboard.press("Home")

    for digit in (0, 9, 4):
        page.keyboard.press(str(digit))
        assert page.evaluate("replay.chosen") == digit
    page.keyboard.press("n")
    assert page.evaluate("replay.chosen") == 5
    page.mouse.click(*place_of(page, "R", 8))
    wait_until(lambda: "point 8" in page.locator("#residual").inner_text())
    page.keyboard.press("ArrowRight")  # it stays chosen
    assert page.evaluate("replay.chosen") == 8

    rows = page.evaluate("Array.from(replay.world.arms.learner.points(replay.moment.theta, replay.world.body))")
    truth = session.world.points_world(session.history[1].theta, session.world.T_world_own)
    assert np.allclose(np.reshape(rows, (-1, 3)), truth, atol=1e-5)  # m; angles are kept to a microradian

    page.keyboard.press("d")
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(240, 242, 245)"
    page.set_viewport_size({"width": 390, "height": 844})
    wait_until(lambda: page.evaluate("document.querySelector('#space').width < 800"))
    assert page.evaluate("document.documentElement.scrollWidth") == 390 and colours(page) > 200
    assert page.locator("#run").is_visible()


@pytest.mark.browser
def test_a_cell_of_a_notebook_shows_it(browser, replay):
    page = sparing(browser.new_page())
    page.set_content(f"<body>{replay._repr_html_()}</body>")
    frame = page.frame_locator("iframe")
    frame.locator("#map .vi-now").wait_for()
    frame.locator("#forward").click()
    frame.get_by_text("1 of", exact=False).first.wait_for()
    page.close()


@pytest.mark.browser
def test_the_lab_takes_over_from_any_moment_and_leads_back(session, replay, opened):
    page, state = (
        opened(replay, "#2", before=SPARING),
        "() => { const {theta, thetaDemo} = lab.session().now; return [theta, thetaDemo]; }",
    )
    page.locator("#takeover").click()
    wait_until(lambda: page.evaluate("typeof lab === 'object'"))
    moment = session.history[2]
    np.testing.assert_allclose(page.evaluate(state), [moment.theta, moment.theta_demo], atol=2e-6)
    assert "after step 2" in page.locator("#says").inner_text() and page.locator("#run").is_hidden()
    assert "rectified pictures" in page.locator("#says").inner_text()  # the lab has none
    page.locator("#step").click()
    wait_until(lambda: page.evaluate("lab.session().now.motion") == 1)
    wait_until(lambda: page.evaluate("location.hash").endswith("steps=1"))
    address = page.evaluate("location.hash")
    page.keyboard.press("t")
    wait_until(lambda: page.locator("#run").is_visible())
    assert page.locator("#where").inner_text().startswith("2 of") and page.locator("#play").is_hidden()
    page.keyboard.press("End")
    page.keyboard.press("t")  # from another moment
    last = session.history[-1]
    wait_until(lambda: page.locator("#play").is_visible())
    np.testing.assert_allclose(page.evaluate(state), [last.theta, last.theta_demo], atol=2e-6)
    again = opened(replay, address, before=SPARING)  # straight into the lab
    wait_until(lambda: again.evaluate("typeof lab === 'object' && lab.session().now.motion") == 1)
    again.locator("#return").click()
    wait_until(lambda: again.locator("#run").is_visible())
