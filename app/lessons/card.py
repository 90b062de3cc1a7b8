"""What stands on the page in a lesson: the card with words, question and buttons, and the figures beside it. HTML."""

import re

from viewimit.drawing.svg import escape

from ..drawing.links import button, sink
from .answers import draw_ask, draw_options
from .course import Course
from .figure_area import draw_figures
from .format import Do
from .measures import fill
from .reveal import draw_reveal, spoken
from .sliders import slides
from .stage import Stage
from .words import heading, inline

AGAIN = {False: "from a new start", True: "in a new scene"}  # by whether a scene is dealt
LEADS = {
    "before": "A guess is enough: it will be asked again at the end.",
    "after": "Asked again, in other words.",
}


def draw_lesson(course: Course, address: str | None, refusal: str = "", below: str = "", held: bool = False) -> str:
    """The whole page of a lesson but for its sliders. address: that its links begin with, None for no links; refusal:
    why what was done last could not be; below: HTML at the end of the card; held: the step is somebody else's to leave
    and to reveal."""
    step, stage = course.step, course.stage
    body = _ending(course, address) if stage is None or step is None else _body(course, stage, address, held)
    kind = "" if stage is None or step is None else f" vi-guide-{step.id}{' vi-sliding' if slides(course) else ''}"
    figures = "" if stage is None or step is None else draw_figures(stage, address)
    refused = f'<p class="vi-guide-refused" role="alert">{escape(refusal)}</p>' if refusal else ""
    head, foot = (part(course, None if held else address) for part in (_head, _foot))
    card = f'<div class="vi-guide-card">{head}{body}{below}{refused}{foot}</div>'
    label = f"Lesson: {escape(course.lesson.title)}"
    told = "" if address is None else f'data-lesson="{address}/lesson/" '
    told += f'data-screen="{course.screen.id}" data-spoken="{"" if stage is None else escape(spoken(stage))}"'
    return f'<section class="vi-guide{kind}" aria-label="{label}" {told}>{card}{figures}</section>{sink()}'


def _head(course: Course, address: str | None) -> str:
    count, screen = len(course.lesson.step), course.screen
    where = {
        "before": "before we begin",
        "step": f"{screen.number + 1} of {count}",
        "after": "what you can say now",
        "end": "done",
    }[screen.kind]
    at = {"before": -1, "step": screen.number}.get(screen.kind, count)
    bars = "".join(f'<i class="{"vi-gone" if k < at else "vi-here" if k == at else ""}"></i>' for k in range(count))
    leave = "" if address is None else button(address, "lesson/leave", "Leave the lesson", "Leave <kbd>Esc</kbd>")
    name = escape(course.lesson.short)
    return (
        f'<div class="vi-guide-head"><b>{name}</b> {where}<span class="vi-guide-leave">{leave}</span></div>'
        f'<div class="vi-guide-bars" aria-hidden="true">{bars}</div>'
    )


def _foot(course: Course, address: str | None) -> str:
    """Buttons at a fixed place: back, skip, next."""
    if address is None:
        return ""
    at, last = course.progress.at, len(course.screens) - 1
    back = _button(address, "back", "← Back", "vi-plain") if at else "<span></span>"
    open_ = course.screen.kind == "step" and not course.given.revealed
    skip = _button(address, "next", "Skip step", "vi-text") if open_ and at < last else "<span></span>"
    words = "Finish" if at == last else "Next →"
    ready = course.given.revealed if course.screen.kind == "step" else course.answered or course.screen.kind == "end"
    if not ready:
        onwards = f'<span class="vi-button vi-off" role="button" aria-disabled="true">{words}</span>'
    else:
        onwards = _button(address, "leave" if at == last else "next", words, "vi-filled vi-guide-main")
    return f'<div class="vi-guide-foot">{back}{skip}{onwards}</div>'


def _button(address: str, what: str, words: str, kind: str) -> str:
    key = " <kbd>Enter</kbd>" if "vi-guide-main" in kind and what == "show" else ""
    inside = f'<span class="vi-button {kind}">{words}{key}</span>'
    return button(address, f"lesson/{what}", re.sub(r"[←→] ?| ?[←→]", "", words), inside)


def _body(course: Course, stage: Stage, address: str | None, held: bool) -> str:
    step, given = stage.step, stage.given
    parts = [heading(escape(step.title))]
    if not given.revealed or step.ask is None:
        parts.append(f"<p>{inline(fill(step.text, stage))}</p>")
    if step.ask is not None:
        parts.append(draw_ask(stage, address))
    if (
        not given.revealed
        and step.ask is not None
        and not isinstance(step.ask, Do)
        and address is not None
        and not held
    ):
        off = '<span class="vi-button vi-wide vi-off" role="button" aria-disabled="true">Show me</span>'
        parts.append(_button(address, "show", "Show me", "vi-wide vi-filled vi-guide-main") if course.answered else off)
    parts += [f'<p class="vi-guide-failed">Not computed: {escape(why)}.</p>' for why in course.failed]
    if given.revealed:
        parts.append(draw_reveal(stage))
        if step.deal and address is not None and not held:
            parts.append(_button(address, "again", f"Again, {AGAIN[bool(step.dealt)]}", "vi-wide vi-plain"))
            parts.append(_seeds(address, given.seed, "scene" if step.dealt else "start"))
    elif step.deal and address is not None and not held and len(given.path) > 1:
        parts.append(_button(address, f"seed,{given.seed}", "Start again", "vi-wide vi-plain"))
    return "".join(parts)


def _seeds(address: str, seed: int, what: str) -> str:
    """This start's number, which others can play, and a box for theirs."""
    to = f'aria-label="{what.capitalize()} number" data-go="{address}/lesson/seed,"'
    box = f'<input type="number" min="1" max="9999" value="{seed}" {to}/>'
    return f'<p class="vi-guide-seed">this was {what} {box} others can play the same</p>'


def _ending(course: Course, address: str | None) -> str:
    """A question before or after all, or what came of them."""
    if course.screen.kind == "end":
        before, after = course.right_before_and_after()
        count = len(course.lesson.question)
        moved = f"<b>{before}</b> of {count} were right before, <b>{after}</b> of {count} after."
        again = "The page is yours now: pose the demonstrator, and press Play."
        return f'{heading("Done")}<div class="vi-guide-told"><span>{moved}</span></div><p>{again}</p>'
    words, answers = course.question()
    rows = [(answer, False) for answer in answers]
    options = draw_options(rows, course.given.choice, False, address)
    return f'{heading(inline(words))}<p>{LEADS[course.screen.kind]}</p><div class="vi-guide-ask">{options}</div>'
