"""The lab is one file that asks nobody for anything, and all that it shows can be touched."""

import html
import re

import numpy as np
import pytest
from browsing import private_windows, sparing
from msgspec.structs import replace
from viewimit.app.lab.page import lab_page
from viewimit.app.lab.recording import lab_methods
from viewimit.app.model.keeping import lab_address, lab_lacks
from viewimit.app.model.link import read_link
from viewimit.app.presets import LAB_PRESETS, PRESETS
from waiting import wait_until

from viewimit import Session, Settings

MB = 1_000_000
NOW = """() => {
    const {theta, thetaDemo, E, motion, status} = lab.session().now;
    return {theta, thetaDemo, E, motion, status};
}"""


WANTS_3D = "try { localStorage['viewimit-in-3d'] = 1 } catch {}"
SLOW_WEBGL = """WebGL2RenderingContext.prototype.readPixels = () => {
    for (const until = performance.now() + 200; performance.now() < until;);
}"""
HAND = """() => {
    const T = lab.world().arms.demonstrator.linkFrames(lab.session().now.thetaDemo).at(-1);
    return lab.placed([T[3] + .1 * T[2], T[7] + .1 * T[6], T[11] + .1 * T[10]]);
}"""


@pytest.fixture(scope="module")
def lab():
    return lab_page()


@pytest.fixture(scope="module")
def path(lab, tmp_path_factory):
    path = tmp_path_factory.mktemp("lab") / "lab.html"
    path.write_text(lab, "utf-8")
    return path


@pytest.fixture
def opened(browser, path):
    """Opens the file in windows of their own, which must ask nobody and have no fault."""

    def open_(address="", width=1000, height=700, ready=True, before=None, unfolded=True, **options):
        page = page_of(sparing(browser.new_context(viewport={"width": width, "height": height}, **options)))
        page.add_init_script(before or WANTS_3D)
        page.goto(path.as_uri() + address)
        if ready:
            wait_until(lambda: page.evaluate("typeof lab === 'object'"))
        if ready and unfolded:
            page.evaluate("document.querySelectorAll('.panel details').forEach(one => { one.open = true; })")
        return page

    with private_windows("error") as page_of:
        yield open_


def now(page):
    return page.evaluate(NOW)


def degrees(angles):
    return np.degrees(angles).round(3).tolist()


def drag(page, start, by, steps=6):
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, steps + 1):
        page.mouse.move(start[0] + by[0] * k / steps, start[1] + by[1] * k / steps)
        page.wait_for_timeout(25)
    page.mouse.up()


def swipe(page, start, by, steps=8):
    """With a finger."""
    devtools = page.context.new_cdp_session(page)
    touch = lambda kind, points: devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    touch("touchStart", [{"x": start[0], "y": start[1]}])
    for k in range(1, steps + 1):
        touch("touchMove", [{"x": start[0] + by[0] * k / steps, "y": start[1] + by[1] * k / steps}])
        page.wait_for_timeout(25)
    touch("touchEnd", [])
    page.wait_for_timeout(100)


def test_the_file_is_small_and_its_policy_is_strict(lab):
    assert len(lab.encode()) < 0.8 * MB
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', lab)
    assert "default-src 'none'" in policy and "unsafe-eval" not in policy and "connect-src" not in policy
    assert re.findall(r'\b(?:src|href)="(?!data:|#)[^"]*"', lab) == []


def test_the_command_writes_it_for_a_robot_of_ones_own_and_says_what_it_cannot(ask, own_arm, tmp_path):
    status, _, said = ask("lab", "--scene", own_arm, "--out", tmp_path / "arm.html")
    assert status == 0 and "written to" in said
    written = (tmp_path / "arm.html").read_text("utf-8")
    assert len(written.encode()) < 0.8 * MB
    assert ask("lab", "--out", tmp_path / "lab.txt")[::2] == (
        2,
        f"viewimit lab: --out: {tmp_path}/lab.txt must end in .html\n",
    )
    scene = tmp_path / "seven.toml"
    joints = "moving_joints = [2, 4, 6]\nrange_deg = [[0, 90], [-180, 0], [0, 180]]\nstart_deg = [25, -25, 90]\n"
    scene.write_text(f'extends = "panda"\n{joints}')
    status, _, said = ask("lab", "--scene", scene)
    assert status == 2 and "needs 2 moving joints, this scene has 3" in said


@pytest.mark.browser
def test_it_plays_to_where_the_library_comes_to_rest(opened):
    page = opened()
    assert page.inner_text("#outcome") == "Ready."
    page.keyboard.press(" ")
    wait_until(lambda: now(page)["status"] == "settled", 30)
    session = Session(Settings.paper(rectify="off"))
    session.run()
    here = now(page)
    assert here["motion"] == session.snapshot.motion
    assert np.abs(np.degrees(np.array(here["theta"]) - session.snapshot.theta)).max() < 1e-6
    wait_until(lambda: now(page)["status"] == "settled")
    assert "Hidden from the learner" in page.inner_text("#truth") and page.inner_text("#play") == "Following"
    assert page.locator("#step").is_disabled()
    page.evaluate("lab.pose([0.9, -1.2])")  # it wakes, and follows
    wait_until(lambda: now(page)["motion"] > here["motion"], 30)
    page.keyboard.press(" ")
    page.keyboard.press("r")
    assert now(page)["motion"] == 0 and degrees(now(page)["thetaDemo"]) == pytest.approx(
        degrees([0.9, -1.2]), abs=0.006
    )
    page.keyboard.press("r")  # again: back to the poses of the experiment
    assert degrees(now(page)["thetaDemo"]) == [45, -90]


@pytest.mark.browser
def test_everything_can_be_dragged(opened):
    page = opened(width=1300, height=800)
    scene = page.locator("#space").bounding_box()
    hand = page.evaluate(HAND)
    before = now(page)
    drag(page, (scene["x"] + hand[0], scene["y"] + hand[1]), (-15, -40))
    after = now(page)
    assert degrees(after["thetaDemo"]) != degrees(before["thetaDemo"]) and after["theta"] == before["theta"]

    def at_point(view, point):
        box = page.locator(f"#{view}").bounding_box()
        x, y = page.evaluate(
            """([k, i]) => {
                const {x, y, scale} = lab.images.views[k].window, {demo, own} = lab.session().now.views;
                const images = k < 2 ? demo : own, at = 4 * i + 2 * (k & 1);
                return [(images[at] - x) * scale * lab.images.unit, (images[at + 1] - y) * scale * lab.images.unit];
            }""",
            ["lrLR".index(view), point],
        )
        return box["x"] + x, box["y"] + y

    page.wait_for_timeout(900)  # until the windows stand
    drag(page, at_point("l", 9), (3, 12))
    moved = now(page)
    assert degrees(moved["thetaDemo"]) != degrees(after["thetaDemo"])
    assert "point 9" in page.inner_text("#residual")
    page.wait_for_timeout(900)
    drag(page, at_point("R", 8), (-10, 25))
    assert degrees(now(page)["theta"]) != degrees(moved["theta"])

    box = page.locator("#map").bounding_box()
    place = lambda theta: page.evaluate("theta => lab.map.place(theta).map(v => v * lab.map.unit)", theta)
    goal = [0.7, -2.0]
    start, end = place(now(page)["theta"]), place(goal)
    drag(page, (box["x"] + start[0], box["y"] + start[1]), (end[0] - start[0], end[1] - start[1]))
    wait_until(lambda: np.abs(np.array(now(page)["theta"]) - goal).max() < 0.03)
    page.locator("#map").focus()
    theta = now(page)["theta"]
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Shift+ArrowLeft")
    assert degrees(now(page)["theta"]) == pytest.approx(np.degrees(theta) + (1, -5), abs=2e-3)

    page.locator("#demo input").nth(1).fill("-45")
    assert degrees(now(page)["thetaDemo"])[1] == -45
    page.locator("#own input").nth(0).fill("60")
    assert degrees(now(page)["theta"])[0] == 60


@pytest.mark.browser
def test_a_finger_poses_and_plays_on_a_phone(opened):
    page = opened(width=390, height=844, has_touch=True, is_mobile=True, device_scale_factor=3)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    for name in ("#play", "#step", "#undo", "#reset"):
        box = page.locator(name).bounding_box()
        assert box["y"] + box["height"] <= 844 and box["height"] >= 32
    page.locator("#step").tap()
    wait_until(lambda: now(page)["motion"] == 1)
    page.locator("#undo").tap()
    assert now(page)["motion"] == 0
    box = page.locator("#map").bounding_box()
    page.evaluate("scrollTo(0, document.querySelector('#map').getBoundingClientRect().top - 100)")
    box = page.locator("#map").bounding_box()
    page.touchscreen.tap(box["x"] + 120, box["y"] + 60)
    wait_until(lambda: degrees(now(page)["theta"]) != [25, -25])

    page.evaluate("scrollTo(0, 0)")
    scene, hand = page.locator("#space").bounding_box(), page.evaluate(HAND)
    before = now(page)
    swipe(page, (scene["x"] + hand[0], scene["y"] + hand[1]), (-8, -40))  # takes hold of it: the page stands still
    assert degrees(now(page)["thetaDemo"]) != degrees(before["thetaDemo"]) and page.evaluate("scrollY") == 0
    before = now(page)
    swipe(page, (scene["x"] + 60, scene["y"] + scene["height"] - 20), (0, -150))  # takes hold of nothing, and scrolls
    wait_until(lambda: page.evaluate("scrollY") > 50)
    assert now(page) == before
    page.wait_for_timeout(800)
    for name in ("l", "r", "L", "map"):  # of these, only a dot or the chosen point is held
        page.evaluate(f"scrollTo(0, document.querySelector('#{name}').getBoundingClientRect().top + scrollY - 250)")
        box, top = page.locator(f"#{name}").bounding_box(), page.evaluate("scrollY")
        swipe(page, (box["x"] + 0.75 * box["width"], box["y"] + 0.6 * box["height"]), (0, -150))
        page.wait_for_timeout(800)
        wait_until(lambda top=top: page.evaluate("scrollY") > top + 50)
        assert now(page) == before
    page.evaluate("scrollTo(0, document.querySelector('#map').getBoundingClientRect().top + scrollY - 200)")
    box = page.locator("#map").bounding_box()
    x, y = page.evaluate("lab.map.place(lab.session().now.theta).map(v => v * lab.map.unit)")
    page.wait_for_timeout(800)  # until nothing scrolls any more
    box, top = page.locator("#map").bounding_box(), page.evaluate("scrollY")
    swipe(page, (box["x"] + x, box["y"] + y), (10, -60))  # takes hold of the learner's dot
    assert degrees(now(page)["theta"]) != degrees(before["theta"]) and page.evaluate("scrollY") == top


@pytest.mark.browser
def test_the_address_says_what_is_shown_and_leads_back(opened):
    changed = "servo=gradient-retuned&transfer=linear&noise=0.5&missing=0.1&seed=3"
    address = f"#preset=lost&demo=50,-80&start=30,-40&points=10&{changed}&steps=4"
    page = opened(address)
    first = now(page)
    assert first["motion"] == 4 and degrees(first["thetaDemo"]) == [50, -80]
    page.keyboard.press("ArrowRight")
    wait_until(lambda: page.evaluate("location.hash").endswith("steps=5"))
    there = page.evaluate("location.hash")
    assert all(
        part in there for part in ("preset=lost", "servo=gradient-retuned", "noise=0.5", "missing=0.1", "seed=3")
    )
    other = opened(there)
    assert now(other) == now(page)
    library = Session(Settings.paper(
        demonstrator_deg=(50, -80), start_deg=(30, -40), servo="gradient-retuned", transfer="linear", noise_px=0.5,
        missing=0.1, seed=3, rectify="off",
    ))  # fmt: skip
    library.run(5)
    assert np.abs(np.degrees(np.array(now(page)["theta"]) - library.snapshot.theta)).max() < 1e-6
    wrong = opened("#preset=nothing&demo=1,2,3&start=x&servo=best&noise=-1&seed=1e99&points=7")
    assert degrees(now(wrong)["thetaDemo"]) == [45, -90]
    assert "preset=nothing" in wrong.inner_text("#says") and "points=7" in wrong.inner_text("#says")
    wait_until(lambda: wrong.evaluate("location.hash").startswith("#preset=paper"))
    unknown = opened("#preset=paper&demo=40,-80&colour=blue")
    assert degrees(now(unknown)["thetaDemo"]) == [40, -80] and "colour=blue" in unknown.inner_text("#says")


@pytest.mark.browser
def test_every_experiment_opens_and_the_page_of_viewimit_opens_in_it(opened):
    page = opened()
    for preset in LAB_PRESETS:
        page.select_option("#preset", preset.key)
        assert page.inner_text("#says") == preset.says
        assert page.evaluate("lab.step() ?? lab.session().now.motion") == 1
        text = page.evaluate("lab.pageLink()")
        script = read_link(text, Settings()).script
        settings = script.settings
        method = "transfer", "servo", "noise_px", "missing"
        assert [getattr(settings, name) for name in method] == [getattr(preset.settings, name) for name in method]
        if preset.settings.points != 4:  # the Workbench needs five
            session = Session(settings)
            session.step()
            assert session.snapshot.E == pytest.approx(now(page)["E"], rel=1e-6)


@pytest.mark.browser
def test_it_works_in_a_frame_of_any_page_and_without_webgl(opened, lab):
    page = opened(before="HTMLCanvasElement.prototype.getContext = new Proxy(HTMLCanvasElement.prototype.getContext,"
                  "{apply: (f, it, given) => given[0] === 'webgl2' ? null : Reflect.apply(f, it, given)})")  # fmt: skip
    page.locator("#still .vi-hull").first.wait_for()
    page.keyboard.press("ArrowRight")
    wait_until(lambda: now(page)["motion"] == 1)
    page = page.context.new_page()
    page.set_content(f'<iframe sandbox="allow-scripts" srcdoc="{html.escape(lab)}" width=900 height=700></iframe>')
    frame = page.frame_locator("iframe")
    frame.locator("#step").click()
    frame.get_by_text("1 step", exact=True).wait_for()


@pytest.mark.browser
def test_arrow_keys_step_after_a_pointer_and_stay_with_a_widget_reached_by_keys(opened):
    page = opened(width=1440, height=900)
    middle = lambda name: (lambda b: (b["x"] + b["width"] / 2, b["y"] + 0.7 * b["height"]))(
        page.locator(name).bounding_box()
    )

    def steps_and_undoes(after):
        page.wait_for_timeout(50)
        motion = now(page)["motion"]
        page.keyboard.press("ArrowRight")
        assert now(page)["motion"] == motion + 1, after
        page.keyboard.press("ArrowLeft")
        assert now(page)["motion"] == motion, after

    page.locator(".choice span", has_text="Linear").click()
    steps_and_undoes("a choice")
    for what in ("#space", "#map"):
        page.mouse.click(*middle(what))
        steps_and_undoes(f"a click in {what}")
        drag(page, middle(what), (40, 10))
        steps_and_undoes(f"a drag in {what}")

    page.locator("[name=servo][value=broyden]").focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("[name=servo]:checked").get_attribute("value") == "gradient-retuned"
    page.keyboard.press("ArrowRight")
    assert page.locator("[name=servo]:checked").get_attribute("value") == "gradient" and now(page)["motion"] == 0


@pytest.mark.browser
def test_back_leads_to_the_preset_before_as_it_was_left(opened):
    page = opened()
    page.evaluate("lab.pose([0.7, -1.4])")
    page.locator("#preset").select_option("near")
    page.locator("#preset").select_option("flat")
    page.go_back()
    wait_until(lambda: page.locator("#preset").input_value() == "near")
    page.go_back()
    wait_until(lambda: page.locator("#preset").input_value() == "paper")
    assert np.allclose(now(page)["thetaDemo"], [0.7, -1.4], atol=1e-3)


@pytest.mark.browser
def test_the_server_serves_it_and_its_link_opens_the_page(browser, server):
    page = browser.new_page()
    page.goto(f"{server}/lab#preset=paper&demo=50,-80&steps=2")
    wait_until(
        lambda: page.evaluate(
            "typeof lab === 'object' && document.querySelector('.to-workbench').href.includes('demo=50')"
        )
    )
    script = read_link(page.locator(".to-workbench").get_attribute("href").partition("?")[2], Settings()).script
    assert script.settings.demonstrator_deg == (50, -80) and script.steps == 2
    page.close()


@pytest.mark.browser
def test_the_pages_link_leads_to_the_lab_in_its_state(opened):
    session = Session(
        Settings.paper(demonstrator_deg=(50, -80), start_deg=(30, -40), noise_px=0.5, seed=3, rectify="off")
    )
    session.run(3)
    page = opened("#" + lab_address(session.snapshot).partition("#")[2])
    there = now(page)
    assert degrees(there["thetaDemo"]) == [50, -80]
    assert np.abs(np.degrees(np.array(there["theta"]) - session.snapshot.theta)).max() < 0.01
    assert page.locator("#noise").input_value() == "0.5" and page.locator("#seed").input_value() == "3"
    assert lab_address(Session(Settings(scene="panda", joints=(1, 2, 4), points=16)).snapshot) is None
    assert "preset=facing" in lab_address(Session(Settings.paper(scene="panda-facing")).snapshot)


CARRIED = set("scene demonstrator_deg start_deg servo transfer points noise_px missing seed name".split())
SPOILT = [
    {"outliers": 0.05},
    {"frames": 4},
    {"latency": 1},
    {"matched": False, "servo": "likelihood"},
    {"joints": (1, 2)},
]


@pytest.mark.parametrize(
    "settings",
    [preset.settings for preset in PRESETS]
    + [replace(Settings.paper(), **field) for field in SPOILT if set(field) <= set(Settings.__struct_fields__)],
    ids=str,
)
def test_what_an_address_cannot_carry_is_said(settings):
    """The lab begins as the paper did, so every other field that differs must be told."""
    plain = replace(Settings.paper(), rectify="off")
    differs = {name for name in Settings.__struct_fields__ if getattr(settings, name) != getattr(plain, name)}
    now = Session(settings).snapshot
    carried = (
        lab_address(now) is not None
        and settings.servo in lab_methods().servos
        and settings.transfer in lab_methods().transfers
        and (differs - CARRIED <= {"rectify"} and now.rectification is None)
    )
    assert carried == (lab_lacks(now) == [])


@pytest.mark.browser
def test_where_3d_is_slow_a_drawing_stands_in_for_it_until_somebody_wants_it(opened):
    page = opened("#preset=paper", before=SLOW_WEBGL)
    page.locator("#slow").wait_for()
    wait_until(lambda: page.locator("#still .vi-hull").count() > 0)
    box, hand, before = page.locator("#still").bounding_box(), page.evaluate(HAND), now(page)
    drag(page, (box["x"] + hand[0], box["y"] + hand[1]), (-15, -40))
    assert now(page)["thetaDemo"] != before["thetaDemo"] and now(page)["theta"] == before["theta"]
    page.locator("#in-3d").click()
    page.locator("#space").wait_for()
    assert page.locator("#still, #slow").locator("visible=true").count() == 0


@pytest.mark.parametrize("address", ("", "#challenge=2026-11-28"))
def test_axe_finds_nothing(opened, violations, address):
    page = opened(
        address, width=390, height=844, ready=not address, has_touch=True, is_mobile=True, color_scheme="dark"
    )
    page.wait_for_selector(".steered .go" if address else "#outcome:not(:empty)")
    assert violations(page) == []
