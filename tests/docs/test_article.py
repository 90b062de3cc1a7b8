"""The article's figures begin as their stills show, follow hands and keys, and compute what the library computes."""

import functools
import json
import re

import numpy as np
import pytest
from browsing import private_windows
from viewimit.app.lab.article.page import FIGURES, TURNED
from waiting import wait_until

from viewimit import Session, Settings, World, load_scene
from viewimit.analysis.construction import construct
from viewimit.analysis.minima import study_transfer
from viewimit.simulation.eyes import open_eyes
from viewimit.simulation.scene import extended

pytest.importorskip("sphinx")
from directives.live import still  # noqa: E402

HAND = 8
BEGIN_ALL = "() => document.querySelectorAll('[data-live]').forEach(place => article.mount(place))"
NUMBER = re.compile(r"-?[\d.]+(e-?\d+)?|base64,[^\"]*")  # differs by rounding, and a map as it is drawn
STATE = "name => article.begun.get(name).figure.state()"


def state_of(name):
    """What a still says that it shows."""
    return json.loads(re.match(r"<!-- (.*) -->\n", still(name))[1])


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    pictures = pytest.importorskip("pictures")
    path = tmp_path_factory.mktemp("article") / "figures.html"
    path.write_text(pictures.figures_page(still), "utf-8")
    return path


@pytest.fixture
def opened(browser, path):
    """Opens the figures in windows of their own, which must ask nobody and have no fault."""

    def open_(width=900, height=900, **options):
        page = page_of(browser.new_context(viewport={"width": width, "height": height}, **options))
        page.goto(path.as_uri())
        page.evaluate(BEGIN_ALL)
        return page

    with private_windows("error", own=("file:", "data:")) as page_of:
        yield open_


def seen(scene, start=(45, -90), **settings):
    """What the library sees at the start of the paper's method in a scene."""
    chosen = Settings.paper(demonstrator_deg=(45, -90), start_deg=start, rectify="off", **settings)
    return Session(chosen, open_eyes=lambda sensor, given, points: open_eyes(sensor, scene, points)).snapshot


def same(one, other):
    """Whether two states are, but for rounding."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(value, other[key]) for key, value in one.items())
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other if isinstance(one, str) else one == pytest.approx(other, rel=1e-6, abs=1e-9)


def centre(page, selector):
    box = wait_until(page.locator(selector).bounding_box)  # none while its drawing is made anew
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page, start, by, steps=5):
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, steps + 1):
        page.mouse.move(start[0] + by[0] * k / steps, start[1] + by[1] * k / steps)
        page.wait_for_timeout(30)
    page.mouse.up()


def differs(page, name, field, before):
    return page.evaluate(STATE, name)[field] != before


def waits_for(page, name, condition):
    """The state of a figure, once it is as it should be."""
    found = [page.evaluate(STATE, name)]

    def holds():
        found[0] = page.evaluate(STATE, name)
        return condition(found[0])

    wait_until(holds)
    return found[0]


def test_the_figures_compute_what_the_library_computes():
    panda = load_scene("panda")
    assert state_of("assumption")["E"] == pytest.approx(seen(panda, (25, -45)).E, rel=1e-9)
    made, shown = construct(seen(panda), HAND), state_of("crossing")
    assert shown["angle"] == pytest.approx(made.angle[0], rel=1e-6)
    assert shown["halfAxes"] == pytest.approx(made.half_axes[0], rel=1e-6)
    turned = extended(panda, TURNED)
    off = study_transfer(World(turned, 10), seen(turned), "epipolar").bias_deg
    assert state_of("distance")["shift"] == pytest.approx(np.abs(off).max(), abs=0.01)
    assert state_of("points")["E"] < 1e-9


@pytest.mark.browser
def test_stills_show_the_figures_as_they_begin(opened):
    page = opened(width=736)
    for name in FIGURES:
        html, begun = still(name), page.evaluate("name => article.stillOf(article.begun.get(name), name)", name)
        assert same(page.evaluate(STATE, name), state_of(name)), f"{name}: python docs/pictures.py stills"
        assert NUMBER.sub("", begun) == NUMBER.sub("", html.partition("\n")[2].strip()), f"{name}: as above"
        assert "<script" not in html and not re.findall(r'(?:src|href)="(?!data:|#)', html)


@pytest.mark.browser
def test_hands_and_keys_change_what_is_computed(opened):
    page = opened()
    before = {name: page.evaluate(STATE, name) for name in FIGURES}
    part = lambda name, inside: f"[data-live={name}] .live-now {inside}"
    for name, grip, by, changed in (
        ("lines", ".room .vi-mark", (-60, -40), "share"),
        ("crossing", ".l .vi-mark", (6, -10), "crossing"),
        ("assumption", ".L .vi-ring", (-20, 60), "E"),
        ("bowl", ".vi-now", (-60, -30), "theta"),
        ("bowl", ".ground .vi-seen", (50, 20), "demonstrator"),
        ("points", ".vi-now", (-50, -40), "theta"),
    ):
        page.locator(f"[data-live={name}]").scroll_into_view_if_needed()
        drag(page, centre(page, part(name, grip)), by)
        wait_until(functools.partial(differs, page, name, changed, before[name][changed]))
    assert page.evaluate(STATE, "points")["E"] < 1e-6  # four points fit anything
    theta = page.evaluate(STATE, "bowl")["theta"]
    page.locator(part("bowl", ".map .box")).focus()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Shift+ArrowLeft")
    after = waits_for(page, "bowl", lambda now: now["theta"][1] < theta[1])["theta"]
    assert np.degrees(np.subtract(after, theta)) == pytest.approx([1, -5])
    page.locator("[data-live=distance] input[type=range]").focus()
    page.keyboard.press("End")
    far = waits_for(page, "distance", lambda now: now["distance"] == 10)
    assert far["E"] < before["distance"]["E"] / 100 and before["distance"]["shift"] / far["shift"] > 40
    page.locator("[data-live=points] input[type=radio]:checked").focus()
    page.keyboard.press("ArrowRight")
    assert waits_for(page, "points", lambda now: now["count"] == "5")["E"] > 1
    page.emulate_media(reduced_motion="reduce")
    page.get_by_role("button", name="Play").focus()
    page.keyboard.press("Enter")
    waits_for(page, "servo", lambda now: now["motion"] > before["servo"]["motion"])


@pytest.mark.browser
def test_print_and_browsers_without_script_show_the_stills(opened, browser, path):
    page = opened(width=390)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    shown = "kind => [...document.querySelectorAll(kind)].map(e => getComputedStyle(e).display !== 'none')"
    assert not any(page.evaluate(shown, ".still")) and all(page.evaluate(shown, ".live-now"))
    page.emulate_media(media="print")
    assert all(page.evaluate(shown, ".still")) and not any(page.evaluate(shown, ".live-now"))
    plain = browser.new_context(java_script_enabled=False).new_page()
    plain.goto(path.as_uri())
    assert all(plain.locator(f"[data-live={name}] .still .facts").is_visible() for name in FIGURES)
    plain.context.close()
