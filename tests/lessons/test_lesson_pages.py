"""A page of lessons: one file, with everything that the browser does not compute."""

import base64
import json
import re
import subprocess
import zlib
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest
import typescript
from serving import Server
from viewimit.app.lab.lessons import page, source, step_data
from viewimit.app.lab.page import lab_page

HERE = Path(__file__).parent
LAB = HERE.parent.parent / "app" / "lab"
LESSONS = source.shipped()


@pytest.fixture(scope="module")
def data():
    return {name: page.page_data({name: lesson}, LESSONS) for name, lesson in LESSONS.items()}


def steps_of(data):
    return [(name, step) for name, one in data.items() for step in one["lessons"][0]["steps"]]


def data_in(text: str) -> dict:
    packed = re.search(r'id="data">([^<]*)<', text)[1]
    return json.loads(zlib.decompress(base64.b64decode(packed)))


@pytest.mark.parametrize("name", LESSONS)
def test_a_page_is_one_small_file_that_asks_nobody(name):
    text = page.lesson_page({name: LESSONS[name]})
    assert len(text.encode()) <= page.MAX_BYTES
    markup = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", markup)
    assert "default-src 'none'" in text
    found = data_in(text)
    assert [one["name"] for one in found["lessons"]] == [name]
    assert [one["name"] for one in found["catalogue"]] == [name]


def test_a_computed_right_answer_is_one_of_the_answers_and_a_number_is_on_its_scale(data):
    for name, step in steps_of(data):
        ask, facts = step["ask"], [step["facts"], *(sample.get("facts", {}) for sample in step.get("samples", []))]
        if ask["kind"] == "choice" and ask["right"] in step["facts"]:
            assert step["facts"][ask["right"]]["value"] in range(1, len(ask["answers"]) + 1), (name, step["id"])
        if ask["kind"] == "number":
            for told in (one[ask["truth"]]["value"] for one in facts if ask["truth"] in one):
                assert ask["low"] < told < ask["high"], (name, step["id"])


def test_dealt_poses_are_off_the_centre_and_apart(data):
    """The regions in which the goal can be reached and the map has one minimum."""
    regions = [((10, 25), (-160, -120)), ((65, 80), (-160, -110)), ((65, 80), (-70, -60))]
    sampled = [(step, sample) for _, step in steps_of(data) for sample in step.get("samples", [])]
    assert len(sampled) >= 4 * step_data.SAMPLES
    for step, sample in sampled:
        shoulder, elbow = np.degrees(sample["state"]["demonstrator"])
        assert any(a - 1e-6 <= shoulder <= b + 1e-6 and c - 1e-6 <= elbow <= d + 1e-6 for (a, b), (c, d) in regions), (
            step["id"]
        )
        apart = np.degrees(np.abs(np.subtract(sample["state"]["start"], sample["state"]["demonstrator"])))
        assert apart.min() >= 20 - 1e-6


def test_a_step_links_to_the_lab_and_to_viewimit_only_where_they_have_its_scene(data):
    lab = data_in(lab_page())
    command = [typescript.node(), str(HERE / "elsewhere.mjs"), str(LAB)]
    asked = json.dumps({"pages": list(data.values()), "lab": lab})
    done = subprocess.run(command, input=asked, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for one in found:
        assert one["wrong"] == [], one
        assert one["preset"] is None or (one["isSame"] and one["turned"] < 1e-3), one
        assert one["moved"] in (None, [None, None]), one
    named = {scene.rsplit("-", 1)[0] for scene in (one["scene"] for one in found)}
    assert named == {"panda", "panda-toed", "panda-forearm"} and any(one["moved"] for one in found)
    links = {one["step"]: (one["preset"], one["viewimit"]) for one in found}
    assert links["tour/servo"] == ("paper", True)
    assert {links[step] for step in links if "panda-toed" in scene_of(found, step)} == {("toed", True)}
    assert {links[step] for step in links if "panda-forearm" in scene_of(found, step)} == {(None, True)}
    assert links["limits/minimum"] == (None, False)


def scene_of(found: list[dict], step: str) -> str:
    return next(one["scene"] for one in found if one["step"] == step)


def test_the_data_of_the_shipped_lessons_are_in_the_package():
    computed = step_data.shipped_data()["computed"]
    steps = {step_data.digest_of(lesson, step) for lesson in LESSONS.values() for step in lesson.step}
    assert steps == computed.keys(), "run python assets/build_lessons.py"


STEPS = [(lesson, step) for lesson in LESSONS.values() for step in lesson.step]


@pytest.mark.parametrize(
    "lesson, step",
    [pytest.param(*one, id=one[1].id, marks=[] if one[0] is LESSONS["ray"] else pytest.mark.slow) for one in STEPS],
)
def test_the_data_in_the_package_are_what_the_library_computes(lesson, step):
    """To 1 % of the numbers of a run, which other processors round otherwise."""
    for shipped, fresh in zip(step_data.step_data(lesson, step), step_data.compute_step(lesson, step)):
        assert_near(shipped, fresh)


def assert_near(one, other):
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        pairs = [(one[key], other[key]) for key in one]
    elif isinstance(one, list):
        assert len(one) == len(other)
        pairs = list(zip(one, other))
    else:
        assert one == (pytest.approx(other, rel=0.01, abs=1e-3) if isinstance(one, float) else other)
        return
    for pair in pairs:
        assert_near(*pair)


@pytest.mark.slow
def test_the_numbers_of_the_eight_questions_are_what_the_library_computes():
    assert step_data.shipped_data()["questions"] == step_data.compute_questions(source.questions().item)


def test_viewimit_serves_each_lesson(tmp_path):
    """Also a lecturer's own, with links to the shipped ones."""
    mine = tmp_path / "mine.toml"
    text = (source.FOLDER / "ray.toml").read_text("utf-8")
    mine.write_text(text.replace('title = "The ray and its shadow"', 'title = "Mine"', 1), "utf-8")
    server = Server("--lesson", str(mine))
    opened = lambda url: urlopen(url).read().decode()  # noqa: E731
    try:
        found = data_in(opened(f"{server.url}/lab/limits"))
        names = [one["name"] for one in found["catalogue"]]
        assert names[0].startswith("mine-") and names[1:] == list(LESSONS)
        own = data_in(opened(f"{server.url}/lab/{names[0]}"))
        assert own["lessons"][0]["title"] == "Mine"
        with pytest.raises(HTTPError, match="404"):
            urlopen(f"{server.url}/lab/nothing")
    finally:
        server.stop()
