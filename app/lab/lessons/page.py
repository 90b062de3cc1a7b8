"""A page of lessons: scenes, texts, computed data, styles and the modules in one HTML file that sends no request."""

import html
import json
import threading
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from string import Template
from types import MappingProxyType
from typing import Any, TypeAlias

from viewimit import __version__
from viewimit.drawing.glossary import glossary
from viewimit.simulation.scene import load_scene

from ...ways import Ways, header
from ..engine_scene import describe_hulls, engine_scene
from ..page import NO_WAYS, SHIPPED, served_page, served_scenes, with_few_points
from ..replay import bundle, packed, styles, with_policy
from .format import Lesson
from .source import ORDER, questions, shipped
from .step_data import COPIED_FIELDS, Scenes, items_with_facts, lesson_data, situation_of

HERE = Path(__file__).parent
ENTRY = "lessons/lesson.js"
STYLE_FILES = (
    "lessons/lesson.css", "view/ways.css", "lessons/paper.css", "lessons/figures/figures.css",
    "lessons/figures/limits.css", "challenge/joints.css",
)  # fmt: skip
Lessons: TypeAlias = Mapping[str, Lesson]
LabScene: TypeAlias = tuple[str, str | None]  # scene and robot, as settings name them
NO_LESSONS: Lessons = MappingProxyType({})
SHIPPED_LAB: LabScene = SHIPPED, None
MAX_BYTES = 800_000  # of a page with one lesson


def lesson_page(
    lessons: Lessons, entry: str = ENTRY, more_styles: str = "", others: Lessons = NO_LESSONS,
    lab: LabScene = SHIPPED_LAB, ways: Ways = NO_WAYS,
) -> str:  # fmt: skip
    """Return lessons, by name in their order, as one HTML page. entry: the module that runs, a path in app/lab/;
    more_styles: CSS after the page's own; others: lessons that are served beside this page, to which it then has links
    by name; lab: scene and robot of the lab beside it, as settings name them; ways: where the header's verbs lead.
    Raises ValueError for lessons of more than one robot, or a scene that the lab cannot compute."""
    first = next(iter(lessons.values()))
    data = json.dumps(page_data(lessons, others, lab), separators=(",", ":"), allow_nan=False)
    title = f"{first.title} · viewimit" if len(lessons) == 1 else "Lessons · viewimit"
    page = Template(HERE.joinpath("lesson.html").read_text("utf-8")).substitute(
        version=html.escape(__version__),
        title=html.escape(title),
        about=html.escape(first.about),
        ways=header(ways, "learn"),
        styles="\n".join((styles(*STYLE_FILES), more_styles)),
        data=packed(data.encode()),
        meshes=packed(b""),
        script=bundle(entry),
    )
    return with_policy(page)


def page_data(lessons: Lessons, others: Lessons = NO_LESSONS, lab: LabScene = SHIPPED_LAB) -> dict[str, Any]:
    """Return what the page's script reads: hulls, scenes, glossary, catalogue and lessons."""
    scenes, plain = Scenes(), []
    for name, lesson in lessons.items():
        asked = items_with_facts(questions().item) if lesson.questions else None
        plain.append({**lesson_data(name, lesson, scenes), "questions": asked})
    catalogue = [
        {"name": name, "here": name in lessons, **{key: getattr(lesson, key) for key in COPIED_FIELDS}}
        for name, lesson in {**others, **lessons}.items()
    ]
    return {
        "hulls": describe_hulls(_robot_of(lessons.values())),
        "scenes": {key: _with_links(scene, lab) for key, scene in scenes.items()},
        "glossary": terms(),
        "catalogue": sorted(catalogue, key=lambda one: ORDER.index(one["name"]) if one["name"] in ORDER else -1),
        "lessons": plain,
    }


def _with_links(scene: dict[str, Any], lab: LabScene) -> dict[str, Any]:
    """The scene with the lab's preset and viewimit's name for it; None where they have no such scene."""
    plain = {name: field for name, field in scene.items() if name != "page"}
    page = scene["page"]
    shown = engine_scene(with_few_points(load_scene(page["scene"] or SHIPPED)))
    preset = next((name for name, offered in served_scenes(*lab).items() if _is_equal(offered, plain)), None)
    named = page["scene"] if _is_equal(shown, plain) else None
    return {**plain, "page": {**page, "scene": named, "preset": preset}}


def _is_equal(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether two scenes are the same as JSON, which has no tuples."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def _robot_of(lessons: Iterable[Lesson]) -> str:
    robots = {situation_of(lesson, step).scene.robot for lesson in lessons for step in lesson.step}
    if len(robots) > 1:
        raise ValueError(f"a page shows one robot, these lessons have {', '.join(sorted(map(str, robots)))}")
    return robots.pop()


@cache
def terms() -> dict[str, str]:
    """Return what the field's terms mean, by the words under which texts name them."""
    return {term: entry.sentence for entry in glossary().values() for term in (entry.symbol, *entry.terms)}


class LabPages:
    """The pages of the lab on a server: the lab itself, and each lesson when it is asked for first. scene, robot: of
    the lab, as settings name them; own: a lecturer's lessons by name, whose pages are computed at once."""

    def __init__(self, scene: str = SHIPPED, robot: str | None = None, own: Mapping[str, Lesson] | None = None):
        self.lessons: Mapping[str, Lesson] = {**(own or {}), **shipped()}
        self._lab = scene, robot
        self._pages = {name: self._write(name) for name in own or {}}
        self._lock = threading.Lock()

    def page(self, name: str) -> str | None:
        """Return the page of a lesson, the lab for "", None for an unknown name."""
        if not name:
            return served_page(*self._lab, Ways.served("./", ORDER[0]))
        if name not in self.lessons:
            return None
        with self._lock:
            if name not in self._pages:
                self._pages[name] = self._write(name)
            return self._pages[name]

    def _write(self, name: str) -> str:
        ways = Ways.served("../", ORDER[0])
        return lesson_page({name: self.lessons[name]}, others=self.lessons, lab=self._lab, ways=ways)
