"""A link that people read says how a state differs from a preset, and opens it to the last bit."""

import re

import msgspec
import numpy as np
import pytest
from quiet_page import QuietPage
from viewimit.app.model.choices import PRESETS
from viewimit.app.model.readable_link import NotReadable, read_link, write_link
from viewimit.app.panels.share import share_html
from viewimit.app.sessions.link import encode_link

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

BY_POINTS = [preset for preset in PRESETS if preset.settings.sensor == "projected"]
HERE = "http://here:8080"


def opened(text: str, **begun) -> QuietPage:
    """A page that has followed a link."""
    page = QuietPage(Settings.paper(**begun))
    page.page.queue.call("link", text)
    page.tick(0.1)
    page.tick_until(lambda: not page.page.model.following.goes_on)
    page.tick(0.1)
    page.settle()
    page.tick(0.1)
    return page


def stepped(page: QuietPage, times: int) -> None:
    for _ in range(times):
        page.page.queue.call("step")
        page.tick(0.3)
        page.settle()
    page.tick(0.3)


def same(one: Session, other: Session) -> bool:
    postures = one.snapshot.theta.tobytes() == other.snapshot.theta.tobytes()
    return postures and np.array_equal(one.snapshot.E, other.snapshot.E, equal_nan=True)


def test_every_preset_has_a_key_of_its_own_that_needs_no_quotes():
    keys = [preset.key for preset in PRESETS]
    assert len(set(keys)) == len(keys) and all(re.fullmatch("[a-z]+", key) for key in keys)


@pytest.mark.parametrize("preset", BY_POINTS, ids=lambda preset: preset.key)
def test_a_link_opens_what_was_shared(preset):
    sender = QuietPage(preset.settings)
    stepped(sender, 3)
    text = write_link(sender.page.model)
    assert f"preset={preset.key}" in text and "steps=3" in text and len(text) < 200
    model = opened(text).page.model
    assert same(model.session, sender.page.model.session) and model.session.settings == sender.page.model.settings
    assert model.session.cursor == 3 and model.preset.name == preset.name and not model.modified


@pytest.mark.parametrize("servo", ["broyden", "trust-region"])
def test_a_learner_at_rest_is_at_rest_for_others_too(servo):
    page = QuietPage(Settings.paper(servo=servo))
    page.page.queue.call("play")
    page.tick_until(lambda: page.page.model.snapshot.status.is_at_rest)
    sender, receiver = (one.page.model.session for one in (page, opened(write_link(page.page.model))))
    assert same(sender, receiver) and receiver.snapshot.status == sender.snapshot.status
    sender.scrub(3)
    assert "steps=3" in write_link(page.page.model)


def test_postures_that_were_dragged_are_where_the_link_begins():
    page = QuietPage(Settings.paper())
    page.page.model.session.pose(np.radians([30.5, -100]))
    page.page.model.session.pose(np.radians([45, -80.1]))
    page.page.model.player.speed = 4.0
    page.page.model.show(rays=True, chosen=2)
    text = write_link(page.page.model)
    assert text == "preset=paper&demo=45,-80.1&speed=4&point=2&rays=1"
    model = opened(text).page.model
    assert same(model.session, page.page.model.session)
    assert model.view.rays and model.view.chosen == 2 and model.player.speed == 4.0


def test_a_link_may_be_written_by_hand():
    model = opened("demo=45,-90&start=25,-45&noise=0.5&seed=3").page.model
    settings = model.session.settings
    assert settings.demonstrator_deg == (45, -90) and settings.start_deg == (25, -45)
    assert settings.noise_px == 0.5 and settings.seed == 3 and settings.transfer == "epipolar"


@pytest.mark.parametrize(
    "text, complaint",
    [
        ("preset=papr", "'papr'; there are paper, best"),
        ("preset=paper&utm_source=x", "'utm_source'; there are preset, scene"),
        ("demo=45,-90,0", "demonstrator"),
        ("demo=45,a", "demonstrator_deg"),
        ("demo=nan,0", "demonstrator"),
        ("noise=-1", "noise_px must be between 0"),
        ("points=many", "points"),
        ("steps=2.5", "steps must be a whole number"),
        ("steps=999999999", "steps must be a whole number up to"),
        *((f"speed={value}", "speed must be one of 0.5, 1, 2") for value in ("nan", "inf", "-2", "3", "fast", "")),
        ("rays=yes", "rays is neither 0 nor 1"),
        ("servo=own", "only its author has"),
        ("scene=/etc/passwd", "a scene that is not here"),
        ("demo=1,2&demo=3,4", "a field twice"),
        ("frames=1000", "averages 1000 images"),
        ("demo=" + "1" * 3000, "too long"),
    ],
)
def test_a_link_that_cannot_be_says_why_and_changes_nothing(text, complaint):
    with pytest.raises(ValueError, match="the link") as caught:
        read_link(text, Settings.paper())
    assert complaint in str(caught.value) and "\n" not in str(caught.value)
    page = QuietPage(Settings.paper())
    before = page.page.model.session.snapshot
    page.page.queue.call("link", text)
    page.tick(0.1)
    assert page.page.model.session.snapshot is before and complaint in page.page.model.message.text


def moved_on_the_way(page: QuietPage) -> None:
    stepped(page, 1)
    page.page.model.session.pose(np.radians([40.0, -90.0]))


def placed_points(page: QuietPage) -> None:
    page.page.model.session.change(body_points=tuple((4, 0.01 * k, 0.02, 0.1 - 0.01 * k * k) for k in range(8)))


def a_scene_file(page: QuietPage) -> None:
    page.page.model.session.begin(Settings.paper(scene='title = "Mine"\nextends = "panda"\n[head]\nbaseline = 0.8\n'))


@pytest.mark.parametrize("did", [moved_on_the_way, placed_points, a_scene_file])
def test_what_no_field_says_is_packed(did):
    page = QuietPage(Settings.paper())
    did(page)
    with pytest.raises(NotReadable):
        write_link(page.page.model)
    assert f"{HERE}/?s={encode_link(page.page.model.linked())}" in share_html(page.page.model, HERE)


def test_where_the_first_looks_count_no_link_pretends_otherwise():
    """Two toed-in cameras are rectified by all matches so far, those of the posture before the drag too."""
    page = QuietPage(Settings(scene="panda-toed", start_deg=(25, -45)))
    page.page.model.session.pose(np.radians([40.0, -80.0]))
    begun = msgspec.structs.replace(page.page.model.settings, demonstrator_deg=(40.0, -80.0))
    assert Session(begun).snapshot.E != page.page.model.session.snapshot.E
    with pytest.raises(NotReadable):
        write_link(page.page.model)


def test_a_link_that_tells_the_answer_is_not_shown_while_the_answer_is_hidden():
    model = QuietPage(Settings.paper(demonstrator_deg=(37, -83))).page.model
    assert "?preset=paper&amp;demo=37,-83" in share_html(model, HERE)
    model.show(truth=False)
    card = share_html(model, HERE)
    assert "demo=37,-83</pre>" not in card.split('class="vi-tells"')[0] and "/?s=2." in card


def test_the_card_says_where_a_link_of_this_machine_opens_and_its_code_is_large():
    model = QuietPage(Settings.paper()).page.model
    here, elsewhere = (share_html(model, "http://localhost:8080", is_local=is_local) for is_local in (True, False))
    assert "opens on this machine only" in here and "--host 0.0.0.0" in here and "machine only" not in elsewhere
    assert float(re.search(r'QR code of the link" style="width:(\d+)px', here)[1]) >= 380
