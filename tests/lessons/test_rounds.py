"""Design your own: what is dealt, what is selected, and the rounds against the page's own choice."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from viewimit.app.control.commands.lessons import touched
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.course import Course
from viewimit.app.lessons.dealing import FEWEST_POINTS, deal, deal_start, varied
from viewimit.app.lessons.format import Range
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.progress import Progress
from viewimit.app.lessons.scenes import Staging
from viewimit.app.lessons.source import load, shipped
from viewimit.app.lessons.works import WORKS, rounds
from viewimit.app.lessons.works.work import Task
from viewimit.assets import ROOT
from walking import at_once

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

DESIGN = shipped()["design"]
STEP = DESIGN.step[0]
SETTINGS = msgspec.convert({**DESIGN.settings, **STEP.settings}, Settings)


def course(progress=None, work=at_once):
    return Course(DESIGN, progress or Progress(lesson="design"), work)


@pytest.fixture
def few(monkeypatch):
    """Two rounds of few motions."""
    monkeypatch.setattr(rounds, "ROUNDS", 2)
    monkeypatch.setattr(rounds, "MOST_MOTIONS", 6)


@pytest.mark.parametrize("seed", range(1, 13))
def test_in_every_scene_that_is_dealt_five_points_are_seen_wherever_the_arms_stand(seed):
    fields, head = deal(STEP.dealt, SETTINGS, seed)
    world = World(varied(load_scene(), head), SETTINGS.points)
    grid = np.meshgrid(*(np.linspace(low, high, 19) for low, high in zip(world.scene.lower, world.scene.upper)))
    visible = np.concatenate([world.demo_images(grid)[1], world.own_images(grid)[1]], -1).all(-1).sum(-1)
    assert visible.min() >= FEWEST_POINTS
    for one in STEP.dealt:
        assert one.low <= {**fields, **head}[one.name] <= one.high


def test_a_seed_deals_the_same_scene_and_another_one_another():
    assert deal(STEP.dealt, SETTINGS, 5) == deal(STEP.dealt, SETTINGS, 5) != deal(STEP.dealt, SETTINGS, 6)


def test_the_head_stands_and_looks_as_dealt():
    scene = load_scene()
    dealt = varied(scene, {"head distance": 2.5, "head baseline": 0.2, "head toe-in": 7.0})
    left, right = dealt.stereo_head().gaze(dealt.head.gaze_learner)
    centres = left.T_world_camera[:3, 3], right.T_world_camera[:3, 3]
    assert np.linalg.norm(np.subtract(*centres)) == pytest.approx(0.2)
    middle = (np.array(dealt.head.gaze_demonstrator) + dealt.head.gaze_learner) / 2
    assert np.linalg.norm(np.mean(centres, 0) - middle) == pytest.approx(2.5)
    axes = left.T_world_camera[:3, 2], right.T_world_camera[:3, 2]
    assert np.degrees(np.arccos(np.dot(*axes))) == pytest.approx(14.0)
    old, new = (np.array(head.position) - middle for head in (scene.head, dealt.head))
    np.testing.assert_allclose(np.cross(old, new), 0, atol=1e-12)


def test_nothing_is_dealt_where_too_few_points_are_seen():
    with pytest.raises(ValueError, match="in none of 100 scenes dealt are 5 points seen"):
        deal([Range(name="head distance", low=0.3, high=0.35, step=0.05)], SETTINGS, 1)


def test_what_is_told_of_the_scene_is_so():
    page = course()
    head, settings = page.session.scene.head, page.session.settings
    fields, dealt = deal(STEP.dealt, SETTINGS, 1)
    assert (settings.noise_px, settings.missing) == (fields["noise_px"], fields["missing"])
    told = {name: MEASURES[name].of(page.stage) for name in ("head distance", "head baseline", "head toe-in")}
    assert told["head distance"] == pytest.approx(dealt["head distance"])
    assert told["head baseline"] == pytest.approx(100 * head.baseline) == pytest.approx(100 * dealt["head baseline"])
    assert told["head toe-in"] == head.toe_in_deg == dealt["head toe-in"]


def test_both_fields_are_to_be_selected_before_anything_is_run():
    page = course()
    with pytest.raises(ValueError, match="no value 5 of field 1"):
        page.select(0, 4)
    page.select(0, 2)
    with pytest.raises(ValueError, match="an answer comes first"):
        page.show()
    touched("select,1,1").apply(type("Model", (), {"guided": type("Guided", (), {"course": page})}), 0.0)
    assert page.answered and page.given.selected == (2, 1)
    drawn = draw_lesson(page, "/x")
    assert drawn.count("chosen") >= 2 and "lesson/select,1,2" in drawn and "<kbd>7</kbd>" in drawn


def test_the_rounds_are_what_sessions_of_their_own_come_to(few):
    page = course()
    page.select(0, 1)
    page.select(1, 1)
    page.show()
    made = page.stage.made["rounds"]
    fields, head = deal(STEP.dealt, SETTINGS, 1)
    for k, (yours, pages) in enumerate(zip(made.yours, made.pages, strict=True)):
        scene = Session(msgspec.structs.replace(SETTINGS, **fields), open_eyes=Staging(head=head).open_eyes)
        start = deal_start(scene.scene, scene.snapshot.theta_demo, [1, k])
        for run, transfer, servo in ((yours, "linear", "broyden"), (pages, Settings().transfer, Settings().servo)):
            changes = {**fields, "transfer": transfer, "servo": servo, "start_deg": start}
            last = (
                Session(msgspec.structs.replace(SETTINGS, **changes), open_eyes=Staging(head=head).open_eyes)
                .run(6, 3)
                .last
            )
            assert (run.off_deg, run.motions) == (np.degrees(np.abs(last.theta - last.theta_demo)).max(), last.motion)
    assert page.given.outcomes[0].numbers == (
        sum(run.off_deg <= 1 for run in made.yours),
        sum(run.off_deg <= 1 for run in made.pages),
        sum(a.off_deg < b.off_deg for a, b in zip(made.yours, made.pages)),
    )


def test_one_round_is_asked_for_at_a_time_and_a_new_scene_forgets_the_old_one_s(few):
    asked = []
    page = course(work=lambda name, make, take: asked.append((make, take)))
    page.select(0, 1)
    page.select(1, 1)
    page.show()
    (make, take), first = asked.pop(), "start 1 of"
    assert first in draw_lesson(page, "/x")
    take(make())
    assert len(page.stage.made["rounds"].yours) == 1 and len(asked) == 1 and page.given.outcomes == ()
    page.again()
    make, take = asked.pop()
    take(make())
    assert "rounds" not in page.stage.made and not asked


def test_results_are_kept_by_scene_and_choice_and_go_with_the_session(few):
    page = course()
    for servo, seed in ((1, 1), (1, 2), (1, 2), (2, 2)):
        page.again(seed)
        page.select(0, 1)
        page.select(1, servo)
        page.show()
    kept = [(one.seed, one.selected) for one in page.given.outcomes]
    assert kept == [(1, (1, 1)), (2, (1, 1)), (2, (1, 2))], "the same again takes the place of what it came to before"
    stored = msgspec.json.decode(msgspec.json.encode(page.progress), type=Progress)
    assert stored == page.progress
    resumed = course(stored)
    assert [(one.seed, one.selected) for one in resumed.given.outcomes] == kept
    drawn = draw_lesson(resumed, "/x")
    assert "scene 1: linear, Broyden" in drawn and "scene 2: linear, trust region" in drawn


def test_the_words_name_the_page_s_own_choice():
    names = [
        value.text
        for field in STEP.ask.fields
        for value in field.values
        if value.value == getattr(Settings(), field.name)
    ]
    assert all(name in STEP.after for name in names) and len(names) == 2


def test_a_slow_law_makes_no_more_motions_than_are_told():
    page = course()
    session, selected = page.session, {"transfer": "epipolar", "servo": "gradient"}
    task = Task(page.step, session.world, page.moments[-1], session.settings, {}, 1, page.staging, selected)
    made = WORKS["rounds"].make(task)
    assert len(made.yours) == 1 and made.yours[0].motions <= rounds.MOST_MOTIONS


SHIPPED = (ROOT / "lessons" / "4-design.toml").read_text()


@pytest.mark.parametrize(
    ("was", "becomes", "told"),
    [
        ('name = "noise_px", low = 0,', 'name = "noise", low = 0,', "dealt[0].name"),
        ('name = "noise_px", low = 0, high = 0.5', 'name = "noise_px", low = 0, high = 50', "noise_px must be"),
        ("high = 2.6", "high = 1.1", "must be at most high, 1.1"),
        ("deal = true", "deal = false", "add deal = true"),
        ('value = "rank3"', 'value = "rank4"', "no transfer 'rank4'"),
        ('name = "servo"', 'name = "law"', "law"),
        ('kind = "select"', 'kind = "choose"', "choose"),
    ],
)
def test_what_is_wrong_with_a_deal_or_with_a_field_is_told_by_line(tmp_path: Path, was, becomes, told):
    assert was in SHIPPED
    file = tmp_path / "mine.toml"
    file.write_text(SHIPPED.replace(was, becomes))
    with pytest.raises(ValueError, match=r"mine\.toml, line \d+: ") as fault:
        load(file)
    assert told.replace("dealt[0].name", "dealt[") in str(fault.value)
