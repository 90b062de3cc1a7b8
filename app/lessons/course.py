"""The walk through a lesson: one screen after the other, what is answered, and a session of its own, so that the page's
is as it was when the lesson is left."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

from .answering import Ask, choices, chosen, guessed, is_answered, placed, selected, settings_selected, with_outcome
from .format import Do, Lesson, Pose, Select, Step
from .measures import MEASURES
from .playing import Playing
from .progress import Given, Progress, fitting
from .scenes import SLIDERS, Staging
from .screens import Screen, answers_by_id, asked_on, right_among, screens_of
from .stage import Stage
from .step_session import StepSession
from .step_works import StepWorks, Work
from .works.work import Task

MOST_PATH = 200  # motions by hand
MOST_SEED = 9999
JOINTS = ("own ", "guess ")  # of sliders that stand at first where the learner does
replace = msgspec.structs.replace


class Course:
    """work: as `StepWorks` has it. changes: how often anything that is shown has changed; others: what a class has
    placed in the step's figure, in its unit."""

    def __init__(self, lesson: Lesson, progress: Progress, work: Work):
        self.lesson = lesson
        self.screens = screens_of(lesson)
        self.steps = {step.id: step for step in lesson.step}
        at, answers = int(np.clip(progress.at, 0, len(self.screens) - 1)), answers_by_id(lesson)
        given = {id: one for id, one in progress.given.items() if id in answers and fitting(one, *answers[id])}
        self.progress = replace(progress, at=at, given=given)
        self.changes = 0
        self.works, self._playing = StepWorks(work, self._change, self._keep), Playing()
        self._at_work, self._narrow = StepSession(), False
        self.others: tuple[tuple[float, float], ...] = ()
        self._enter()

    @property
    def session(self) -> Session:
        """Its own, of the step that is shown."""
        return self._at_work.session

    @property
    def staging(self) -> Staging:
        """What is different in its scene."""
        return self._at_work.staging

    @property
    def moments(self) -> Sequence[Snapshot]:
        """What was seen since the step began, the last of them shown."""
        return self._at_work.moments

    @property
    def made(self) -> dict[str, object]:
        """What the step's works have come to so far, by name."""
        return self.works.made

    @property
    def failed(self) -> tuple[str, ...]:
        """What could not be computed, and why."""
        return self.works.failed

    @property
    def played(self) -> int:
        """Motions that are shown where they are played."""
        return self._playing.played

    @property
    def screen(self) -> Screen:
        return self.screens[self.progress.at]

    def shows(self, lesson: str, step: str) -> bool:
        """Whether it is at this step, by both names."""
        return self.step is not None and (self.progress.lesson, self.step.id) == (lesson, step)

    @property
    def step(self) -> Step | None:
        """None at a question and at the end."""
        return self.lesson.step[self.screen.number] if self.screen.kind == "step" else None

    @property
    def _ask(self) -> Ask:
        return self.step.ask if self.step else None

    @property
    def given(self) -> Given:
        """To this screen."""
        return self.progress.given.get(self.screen.id, Given())

    @property
    def stage(self) -> Stage | None:
        step = self.step
        if step is None:
            return None
        return Stage(
            step, self.session, self.moments, self.given, self.progress.given, self.steps, self.made,
            self._played_so_far, self._at_work.bodies, self._narrow, self.others,
        )  # fmt: skip

    @property
    def _played_so_far(self) -> int | None:
        """Motions that are shown where they are played; None for all."""
        return None if self.step is None or self.step.play is None or self._playing.over else self.played

    @property
    def see_through(self) -> NDArray | None:
        """(m,) rad: the posture that the visitor gives a see-through arm; None where none is asked for."""
        if self.step is None or not isinstance(self.step.ask, Pose) or len(self.given.sliders) != 2:
            return None
        return np.radians(self.given.sliders)

    @property
    def poses(self) -> tuple[NDArray, ...]:
        """(m,) rad each: where the learner is seen, the demonstrator, and the see-through arm if there is one."""
        shown, guessed = self.moments[-1], self.see_through
        return shown.theta, shown.theta_demo, *(() if guessed is None else (guessed,))

    @property
    def answered(self) -> bool:
        """Whether it may be shown what is true."""
        if self.screen.kind in ("before", "after"):
            return self.given.choice is not None
        return is_answered(self.given, self._ask)

    def question(self) -> tuple[str, tuple[str, ...]]:
        """Words and answers of a question before or after all, in the order in which they are shown."""
        return asked_on(self.lesson, self.screen)

    def right_before_and_after(self) -> tuple[int, int]:
        """How many of the lesson's questions were answered rightly."""
        before, after = (right_among(self.lesson, kind, self.progress.given) for kind in ("before", "after"))
        return before, after

    # What a visitor does

    def choose(self, k: int) -> None:
        question = self.screen.kind in ("before", "after")
        self._give(choice=chosen(self.given, k, len(self.question()[1]) if question else choices(self.step)))

    def place(self, at: NDArray) -> None:
        """at: (2,) units of the figure's drawing."""
        self._give(place=placed(self.stage, at))

    def guess(self, number: float) -> None:
        self._give(number=guessed(self.given, self._ask, number))

    def select(self, k: int, value: int) -> None:
        """One of the values of a field of settings, both counted from 0."""
        self._give(selected=selected(self.given, self._ask, k, value))

    def turn(self, k: int, value: float) -> None:
        """One of the step's sliders; value: in its own unit."""
        step = self.step
        if step is None or not 0 <= k < len(step.sliders):
            raise ValueError("there is no such slider here")
        slider = step.sliders[k]
        if slider.name.startswith("guess ") and self.given.revealed:
            raise ValueError("what is true is shown: the posture has been answered")
        if slider.name.startswith("own ") and len(self.given.path) > MOST_PATH:
            raise ValueError(f"{MOST_PATH} motions by hand are the most; begin the step again")
        value = float(np.clip(value, slider.low, slider.high))
        stands = [*(self.given.sliders or (other.start for other in step.sliders))]
        if stands[k] == value:
            return
        stands[k] = value
        self._give(sliders=tuple(stands))
        if isinstance(step.ask, Pose):
            self._give(place=(stands[0], stands[1]))
        self._turned(slider.name, value)
        self._look_whether_done()

    def show(self) -> None:
        """What is true."""
        if not self.answered:
            raise ValueError("an answer comes first")
        self.reveal(self.others)

    def reveal(self, others: tuple[tuple[float, float], ...] = ()) -> None:
        """What is true, be it answered or not. others: what a class has placed, in the figure's unit."""
        self.show_others(others)
        if not self.given.revealed:
            self._reveal()

    def present(self) -> None:
        """On, before a class: to what is true, though nobody has answered here, or else to the next screen."""
        step = self.step
        if step is None or self.given.revealed or isinstance(step.ask, Do | Select):
            self.go(1)
        else:
            self._reveal()

    def show_others(self, others: tuple[tuple[float, float], ...]) -> None:
        """What a class has placed, in the figure's unit."""
        if others != self.others:
            self.others = others
            self.changes += 1

    def ask_anew(self) -> None:
        """The step is as if nobody had answered it."""
        fresh = {id: one for id, one in self.progress.given.items() if id != self.screen.id}
        self.progress = replace(self.progress, given=fresh)
        self._enter()

    def again(self, seed: int | None = None) -> None:
        """From a new start, or that of a seed."""
        step = self.step
        if step is None or not step.deal:
            raise ValueError("no start is dealt here")
        seed = self.given.seed % MOST_SEED + 1 if seed is None else seed
        if not 1 <= seed <= MOST_SEED:
            raise ValueError(f"starts have numbers from 1 to {MOST_SEED}")
        fresh = Given(seed=seed, outcomes=self.given.outcomes)
        self.progress = replace(self.progress, given={**self.progress.given, self.screen.id: fresh})
        self._enter()

    def go(self, by: int) -> bool:
        """So many screens on or back. False past the end."""
        at = self.progress.at + by
        if at >= len(self.screens):
            return False
        self.progress = replace(self.progress, at=max(at, 0))
        self._enter()
        return True

    def fit(self, narrow: bool) -> None:
        """Into a window that is narrow, or not."""
        if narrow != self._narrow:
            self._narrow = narrow
            self.changes += 1

    def tick(self, now: float, still: bool = False) -> None:
        """Show one more motion, where they are played; still: all of them, as nothing is to move."""
        step = self.step
        if step is None or step.play is None or self._playing.over or not self.given.revealed:
            return
        if self.works.plays and self._playing.tick(now, step.play, still):
            self.changes += 1

    # What follows from it

    def _reveal(self) -> None:
        self._give(revealed=True)
        self._meet()
        self._ask_for("revealed")

    def _give(self, **fields) -> None:
        given = replace(self.given, **fields)
        self.progress = replace(self.progress, given={**self.progress.given, self.screen.id: given})
        self.changes += 1

    def _enter(self) -> None:
        """The screen is another: begin its session, and go again what was gone by hand."""
        self.changes += 1
        self.works.begin()
        self._playing = Playing()
        self.others = ()
        step = self.step
        if step is None:
            self._at_work.rest()
            return
        self._begin(step)
        given = self.given
        if step.ask is None and not given.revealed:
            self._give(revealed=True)
        for posture in given.path[1:]:
            self._at_work.move_learner(np.radians(posture))
        if given.revealed:
            self._meet()
        for slider, value in zip(step.sliders, given.sliders):
            if not slider.name.startswith(JOINTS) and slider.name not in SLIDERS:
                self._turned(slider.name, value)
        if any(slider.name.startswith(JOINTS) for slider in step.sliders) and not given.sliders:
            self._give(sliders=tuple(self._stands(slider.name, slider.start) for slider in step.sliders))
        self._ask_for("entered", "turned", *(["revealed"] if self.given.revealed else []))

    def _begin(self, step: Step) -> None:
        """Its session, in its scene as it is dealt and as the sliders have it; its start may be that of the step whose
        path goes on here."""
        dealt = step if step.deal else self.steps.get(step.carry or "")
        dealt = dealt if dealt is not None and dealt.deal else None
        seed = self.progress.given.get(dealt.id, Given()).seed if dealt else 0
        fields = {**self.lesson.settings, **step.settings}
        self._at_work.begin(step, fields, self._sliders(step), dealt, seed)

    def _turned(self, name: str, value: float) -> None:
        kind, _, number = name.partition(" ")
        if kind == "own" and number.isdigit():
            self._at_work.turn_learner(int(number), np.radians(value))
            first, now = self.moments[0], self.moments[-1]
            path = self.given.path or (_degrees(first.theta),)
            E = self.given.E or (round(first.E, 6),)
            self._give(path=(*path, _degrees(now.theta)), E=(*E, round(now.E, 6)))
        elif kind == "demo" and number.isdigit():
            self._at_work.turn_demonstrator(int(number), np.radians(value))
            self._ask_for("turned")
        elif name in SLIDERS and self.step is not None:
            self._begin(self.step)
            self._ask_for("turned")
        elif name in Settings.__struct_fields__:
            self._at_work.change(**{name: value})
            self._ask_for("turned")

    def _meet(self) -> None:
        """Where the step ends with both arms alike, they are."""
        if self.step is not None and self.step.meets:
            self._at_work.move_learner(self.moments[-1].theta_demo)

    def _stands(self, name: str, start: float) -> float:
        """Where a slider stands at first: a joint's where that joint is."""
        kind, _, number = name.partition(" ")
        moment = self.moments[-1]
        theta = {"own": moment.theta, "guess": moment.theta, "demo": moment.theta_demo}.get(kind)
        return start if theta is None else round(float(np.degrees(theta[int(number) - 1])), 3)

    def _look_whether_done(self) -> None:
        stage, ask = self.stage, self._ask
        if stage is None or not isinstance(ask, Do) or self.given.done:
            return
        value = float(MEASURES[ask.measure].of(stage))
        if (ask.below is not None and value < ask.below) or (ask.above is not None and value > ask.above):
            self._give(done=True, revealed=True)
            self._ask_for("revealed")

    def _ask_for(self, *when: str) -> None:
        """The works of the step's figures, and its own, that are due then."""
        step = self.step
        if step is None:
            return
        session = self.session
        task = Task(
            step, session.world, self.moments[-1], session.settings, self._sliders(step), self.given.seed,
            self.staging, settings_selected(self.given, step.ask),
        )  # fmt: skip
        self.works.ask(task, *when)

    def _keep(self, numbers: tuple[float, ...]) -> None:
        """What a work came to."""
        self._give(outcomes=with_outcome(self.given, numbers))

    def _change(self) -> None:
        self.changes += 1

    def _sliders(self, step: Step) -> dict[str, float]:
        """Where they stand, by name."""
        stands = self.given.sliders or tuple(slider.start for slider in step.sliders)
        return {slider.name: value for slider, value in zip(step.sliders, stands)}


def _degrees(theta: NDArray) -> tuple[float, ...]:
    return tuple(np.round(np.degrees(theta), 3).tolist())
