"""What the library computes for a step: state, facts, records, moved eyes and samples. Those of the shipped lessons are
in assets/lessons/data.json, which assets/build_lessons.py writes, by a digest of what they are computed from. Those of
other lessons are computed when a page is written."""

import hashlib
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from viewimit.assets import ROOT

import viewimit

from ..engine_scene import engine_scene
from ..page import with_few_points
from ..recording import lab_settings
from . import facts
from .format import Do, Item, Lesson, Slider, Step, figures_of, measures_in, measures_of, settings_of
from .records import sample_postures
from .situation import Situation

DATA = ROOT / "lessons" / "data.json"
EYE_SLIDERS = ("distance", "camera distance", "baseline")
LOGARITHMIC_VALUES = 25  # of a slider that moves the eyes, besides 1 and 10
SAMPLE_SEED = 44
SAMPLES = 12  # states that are sampled of a step
COPIED_FIELDS = "title", "short", "about", "afterwards", "minutes"  # fields of a lesson that a page has as they are
Scenes = dict[str, dict[str, Any]]


def situation_of(lesson: Lesson, step: Step) -> Situation:
    """Return the fixed state that a step shows. A step that carries on begins as the earlier one did."""
    origin = _origin(lesson, step)
    ask = origin.ask
    goal = ask.below if isinstance(ask, Do) and ask.measure == "E" else None
    settings = settings_of(lesson, step, **{**origin.settings, **step.settings})
    chosen = origin.chosen if step.chosen is None else step.chosen
    scene = {**origin.scene, **step.scene}
    return Situation(settings, scene, chosen, step.race, goal)


def _origin(lesson: Lesson, step: Step) -> Step:
    while step.carry is not None:
        step = next(other for other in lesson.step if other.id == step.carry)
    return step


def lesson_data(name: str, lesson: Lesson, scenes: Scenes) -> dict[str, Any]:
    """Return a lesson as the page has it, without the eight questions. Its scenes are added to `scenes`."""
    copied = {key: getattr(lesson, key) for key in COPIED_FIELDS}
    steps = []
    for step in lesson.step:
        own_scenes, computed = step_data(lesson, step)
        scenes.update(own_scenes)
        steps.append({**msgspec.to_builtins(step), **computed})
    return {"name": name, **copied, "steps": steps}


def step_data(lesson: Lesson, step: Step) -> tuple[Scenes, dict[str, Any]]:
    """Return (scenes by key, computed fields) of a step: the shipped ones, or computed."""
    shipped = shipped_data()
    computed = shipped["computed"].get(digest_of(lesson, step))
    if computed is None:
        return compute_step(lesson, step)
    used = {one["state"]["scene"] for one in (computed, *computed.get("samples", ()))}
    return {key: shipped["scenes"][key] for key in used}, computed


@cache
def shipped_data() -> dict[str, Any]:
    """Read the data of the shipped lessons: {"scenes", "computed", "questions"}."""
    return json.loads(DATA.read_bytes())


def digest_of(lesson: Lesson, step: Step) -> str:
    """Return a digest of all that a step's data are computed from, but not of its words."""
    situation, names = situation_of(lesson, step), [figure.figure for figure in figures_of(step)]
    moved = {slider.name: values_of(slider) for slider in step.sliders if slider.name in EYE_SLIDERS}
    inputs = (
        *(situation.settings, situation.scene_fields, situation.chosen, situation.race, situation.goal),
        *(_origin(lesson, step).randomise, moved, sorted(measures_of(step)), names),
    )
    return hashlib.sha256(msgspec.json.encode(inputs, order="deterministic")).hexdigest()[:16]


def items_with_facts(items: Iterable[Item]) -> list[dict[str, Any]]:
    """Return the eight questions as the page has them, their numbers filled in."""
    texts = shipped_data()["questions"]
    plain = msgspec.to_builtins(tuple(items))
    for item in plain:
        for answer in item["answers"]:
            for name in measures_in(answer["because"]):
                answer["because"] = answer["because"].replace(f"{{{name}}}", texts[name])
    return plain


def compute_questions(items: Iterable[Item]) -> dict[str, str]:
    """Compute the numbers in the replies of the eight questions, as they stand in a sentence."""
    usual = Situation(msgspec.convert({"transfer": "epipolar", "servo": "broyden", "frames": 1}, viewimit.Settings))
    names = sorted({name for item in items for one in item.answers for name in measures_in(one.because)})
    return {name: fact["text"] for name, fact in facts.compute(usual, names)[0].items()}


def compute_step(lesson: Lesson, step: Step) -> tuple[Scenes, dict[str, Any]]:
    """Compute what `step_data` returns."""
    scenes = Scenes()
    data = _of_situation(step, situation_of(lesson, step), scenes)
    if samples := sampled_situations(lesson, step):
        data["samples"] = [_of_situation(step, one, scenes) for one in samples]
    return _plain(scenes), _plain(data)


def sampled_situations(lesson: Lesson, step: Step) -> list[Situation]:
    """Return the states that are sampled of a step, or in the one that it carries on; none for others."""
    if not _origin(lesson, step).randomise:
        return []
    return sample_postures(situation_of(lesson, step), SAMPLES, SAMPLE_SEED)


def _of_situation(step: Step, situation: Situation, scenes: Scenes) -> dict[str, Any]:
    found, records = facts.compute(situation, list(measures_of(step)), [figure.figure for figure in figures_of(step)])
    moved = lambda name, value: {"value": value, "cameras": _moved_cameras(situation, name, value)}
    eyes = (slider for slider in step.sliders if slider.name in EYE_SLIDERS)
    variants = {slider.name: [moved(slider.name, value) for value in values_of(slider)] for slider in eyes}
    settings, start = situation.settings, situation.start
    state = {
        "scene": _add_scene(situation, scenes),
        **lab_settings(settings),
        "demonstrator": start.theta_demo.tolist(),
        "start": start.theta.tolist(),
    }
    return {"state": state, "facts": found, "records": records, "variants": variants}


def _add_scene(situation: Situation, scenes: Scenes) -> str:
    """Add a situation's scene under a key of its content, and return the key."""
    scene = with_few_points(situation.scene)
    plain = engine_scene(scene)
    digest = hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()[:8]
    key = f"{Path(situation.settings.scene or 'panda').stem[:24]}-{digest}"
    scenes[key] = {**plain, "page": {"scene": situation.settings.scene, "layouts": list(scene.points)}}
    return key


def values_of(slider: Slider) -> list[float]:
    """Return the values of a slider at which the eyes are computed."""
    if not slider.logarithmic:
        count = round((slider.high - slider.low) / slider.step)
        return [round(slider.low + k * slider.step, 6) for k in range(count + 1)]
    values = np.geomspace(slider.low, slider.high, LOGARITHMIC_VALUES).tolist()
    marks = [mark for mark in (slider.start, 1.0, 10.0) if slider.low <= mark <= slider.high]
    return sorted({round(value, 6) for value in (*values, *marks)})


def _moved_cameras(situation: Situation, slider: str, value: float) -> list[dict[str, Any]]:
    """The cameras after a slider has moved the eyes. "camera distance" moves cameras away from what they look at, and
    multiplies their focal lengths by the same factor; each pair moves by itself, which no head does."""
    if slider != "camera distance":
        return engine_scene(situation.with_eyes(**{slider: value}).scene)["cameras"]
    scene, cameras = situation.scene, engine_scene(situation.scene)["cameras"]
    gazes = np.array([scene.head.gaze_demonstrator] * 2 + [scene.head.gaze_learner] * 2)
    for camera, gaze in zip(cameras, gazes):
        camera["centre"] = (gaze + value * (np.array(camera["centre"]) - gaze)).tolist()
        camera["focal"] = [value * focal for focal in camera["focal"]]
    return cameras


def _plain(made: Any) -> Any:
    """Plain data with null instead of numbers that are not finite, which JSON does not have."""
    return msgspec.json.decode(msgspec.json.encode(made, enc_hook=lambda array: array.tolist()))
