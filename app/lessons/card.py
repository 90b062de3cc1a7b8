"""What stands on the page in a lesson: the card with words, question and buttons, and the figures beside it. HTML."""

import re
from collections.abc import Sequence

import numpy as np

from viewimit.drawing.over.links import link, sink
from viewimit.drawing.svg import escape

from .course import Course
from .figures import FIGURES, layers_of
from .format import Choice, Do, Figure, Number, Place, Pose, Slider
from .measures import MEASURES, fill
from .stage import Stage

MOVE = "Click again to move the mark, or use the arrow keys."
LEADS = {
    "before": "A guess is enough: it will be asked again at the end.",
    "after": "Asked again, in other words.",
}
NUMBERS = 13  # on the scale of a number that is asked for


def draw_lesson(course: Course, address: str | None) -> str:
    """The whole page of a lesson but for its sliders. address: that its links begin with, None for no links."""
    step, stage = course.step, course.stage
    body = _ending(course, address) if stage is None or step is None else _body(course, stage, address)
    kind = "" if stage is None or step is None else f" vi-guide-{step.id}{' vi-sliding' if slides(course) else ''}"
    figures = "" if stage is None or step is None else _figures(stage, address)
    card = f'<div class="vi-guide-card" aria-live="polite">{_head(course, address)}{body}{_foot(course, address)}</div>'
    label = f"Lesson: {escape(course.lesson.title)}"
    return f'<section class="vi-guide{kind}" aria-label="{label}">{card}{figures}</section>{sink()}'


def slides(course: Course) -> bool:
    """Whether the step's sliders are in reach: where something is to be done, or once it is revealed."""
    step = course.step
    if step is None or not step.sliders:
        return False
    return isinstance(step.ask, Do | Pose) or course.given.revealed


def draw_sliders(course: Course, address: str | None) -> str:
    """An element of its own, which stays while a slider is dragged."""
    step = course.step
    if step is None or address is None or not slides(course):
        return ""
    stands = course.given.sliders or tuple(slider.start for slider in step.sliders)
    rows = "".join(_slider(k, slider, stands[k], address) for k, slider in enumerate(step.sliders))
    return f'<div class="vi-guide-sliders vi-sliders-{len(step.sliders)}">{rows}</div>'


def _slider(k: int, slider: Slider, value: float, address: str) -> str:
    low, high, at = (_even(slider, number) for number in (slider.low, slider.high, value))
    step = (high - low) / 200 if slider.logarithmic else slider.step
    shown = "" if slider.unit is None else f"<output>{_number(value)}{escape(slider.unit)}</output>"
    live = "" if slider.name.startswith("own ") else ' data-live=""'
    log = ' data-log=""' if slider.logarithmic else ""
    told = f'data-turn="{address}/lesson/turn,{k},"{live}{log}'
    return (
        f'<label><span>{escape(slider.label)}</span><input type="range" id="vi-guide-slider-{k}" min="{low:g}"'
        f' max="{high:g}" step="{step:g}" value="{at:g}" {told}/>{shown}</label>'
    )


def _even(slider: Slider, number: float) -> float:
    return float(np.log10(number)) if slider.logarithmic else number


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
    leave = "" if address is None else link(address, "lesson/leave", "Leave the lesson", "Leave <kbd>Esc</kbd>")
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
        onwards = f'<span class="vi-button vi-off" aria-disabled="true">{words}</span>'
    else:
        onwards = _button(address, "leave" if at == last else "next", words, "vi-filled vi-guide-main")
    return f'<div class="vi-guide-foot">{back}{skip}{onwards}</div>'


def _button(address: str, what: str, words: str, kind: str) -> str:
    key = " <kbd>Enter</kbd>" if "vi-guide-main" in kind and what == "show" else ""
    inside = f'<span class="vi-button {kind}">{words}{key}</span>'
    return link(address, f"lesson/{what}", re.sub(r"[←→] ?| ?[←→]", "", words), inside)


def _body(course: Course, stage: Stage, address: str | None) -> str:
    step, given = stage.step, stage.given
    parts = [f"<h2>{escape(step.title)}</h2>"]
    if not given.revealed or step.ask is None:
        parts.append(f"<p>{inline(fill(step.text, stage))}</p>")
    if step.ask is not None:
        parts.append(_ask(course, stage, address))
    if not given.revealed and step.ask is not None and not isinstance(step.ask, Do) and address is not None:
        off = '<span class="vi-button vi-wide vi-off" aria-disabled="true">Show me</span>'
        parts.append(_button(address, "show", "Show me", "vi-wide vi-filled vi-guide-main") if course.answered else off)
    if given.revealed:
        parts.append(_reveal(stage))
        if step.deal and address is not None:
            parts.append(_button(address, "again", "Again, from a new start", "vi-wide vi-plain"))
            parts.append(_seeds(address, given.seed))
    elif step.deal and address is not None and len(given.path) > 1:
        parts.append(_button(address, f"seed,{given.seed}", "Start again", "vi-wide vi-plain"))
    return "".join(parts)


def _seeds(address: str, seed: int) -> str:
    """This start's number, which others can play, and a box for theirs."""
    to = f'aria-label="Start number" data-go="{address}/lesson/seed,"'
    box = f'<input type="number" min="1" max="9999" value="{seed}" {to}/>'
    return f'<p class="vi-guide-seed">this was start {box} others can play the same</p>'


def _ask(course: Course, stage: Stage, address: str | None) -> str:
    ask, given = stage.step.ask, stage.given
    assert ask is not None
    question = f"<b>{inline(ask.question)}</b>"
    if isinstance(ask, Choice):
        return f'<div class="vi-guide-ask">{question}{_answers(course, stage, ask, address)}</div>'
    if given.revealed:
        return ""
    if isinstance(ask, Number):
        return f'<div class="vi-guide-ask">{question}{_scale(ask, given.number, address)}</div>'
    if isinstance(ask, Do):
        return f'<div class="vi-guide-ask">{question}{_meter(stage, ask)}</div>'
    hint = MOVE if isinstance(ask, Place) else "Turn the joints below."
    return f'<div class="vi-guide-ask">{question}<small>{hint}</small></div>'


def _answers(course: Course, stage: Stage, ask: Choice, address: str | None) -> str:
    right = right_answer(stage, ask)
    rows = [(answer.text, k == right) for k, answer in enumerate(ask.answers)]
    return _options(rows, stage.given.choice, stage.revealed, address)


def right_answer(stage: Stage, ask: Choice) -> int:
    """Its index: as written, or as computed."""
    if ask.right is not None:
        return round(float(MEASURES[ask.right].of(stage))) - 1
    return next(k for k, answer in enumerate(ask.answers) if answer.right)


def _options(rows: Sequence[tuple[str, bool]], choice: int | None, revealed: bool, address: str | None) -> str:
    shown = []
    for k, (words, right) in enumerate(rows):
        kind = "vi-option" + (" vi-chosen-one" if k == choice else "")
        if revealed:
            kind += " vi-right-one" if right else " vi-wrong-one" if k == choice else ""
            mark = "✓ " if right else "✗ " if k == choice else ""
            shown.append(f'<span class="{kind}">{mark}{inline(words)}</span>')
            continue
        inside = f'<span class="{kind}"><kbd>{k + 1}</kbd>{inline(words)}</span>'
        said = f"{words}{', chosen' if k == choice else ''}"
        shown.append(inside if address is None else link(address, f"lesson/choose,{k}", said, inside))
    return f'<div class="vi-options">{"".join(shown)}</div>'


def _scale(ask: Number, chosen: float | None, address: str | None) -> str:
    """Numbers to choose from, each a link."""
    if ask.logarithmic:
        values = np.geomspace(ask.low, ask.high, NUMBERS)
    else:
        count = NUMBERS if ask.step is None else round((ask.high - ask.low) / ask.step) + 1
        values = np.linspace(ask.low, ask.high, count)
    shown = []
    for value in (float(f"{number:.2g}") for number in values):
        kind = "vi-option" + (" vi-chosen-one" if chosen is not None and abs(value - chosen) < 1e-9 else "")
        words = f"{_number(value)}{ask.unit}"
        inside = f'<span class="{kind}">{words}</span>'
        shown.append(inside if address is None else link(address, f"lesson/guess,{value:g}", words, inside))
    return f'<div class="vi-options vi-numbers">{"".join(shown)}</div>'


def _meter(stage: Stage, ask: Do) -> str:
    """How far it is from where it began to the goal."""
    measure = MEASURES[ask.measure]
    goal = ask.below if ask.below is not None else ask.above
    assert goal is not None
    now = float(measure.of(stage))
    said = f"now <b>{escape(measure.told(stage))}</b>"
    if ask.below is None:
        share = np.clip(now / goal, 0, 1) if goal > 0 else 0.0
        begun = ""
    else:
        first = max(float(stage.moments[0].E), goal * 1.01) if ask.measure == "E" else max(now, goal * 1.01)
        share = np.clip(np.log(first / max(now, 1e-9)) / np.log(first / goal), 0, 1)
        begun = f"<span>start {_number(round(first, 1))}</span>" if ask.measure == "E" else ""
    return (
        f'<div class="vi-meter"><i style="width:{100 * float(share):.0f}%"></i></div>'
        f'<div class="vi-meter-words">{begun}<span>{said}</span><span>goal {_number(goal)}</span></div>'
    )


def _reveal(stage: Stage) -> str:
    step, parts = stage.step, []
    if step.told is not None:
        note = f"<small>{inline(fill(step.told.note, stage))}</small>" if step.told.note else ""
        value = escape(MEASURES[step.told.measure].told(stage))
        parts.append(f'<div class="vi-guide-told"><span>{escape(step.told.label)}</span><b>{value}</b>{note}</div>')
    because = verdict(stage)
    if because:
        parts.append(f"<p>{inline(fill(because, stage))}</p>")
    if step.after:
        parts.append(f"<p>{inline(fill(step.after, stage))}</p>")
    parts.append(f'<div class="vi-guide-say"><small>Now you can say</small>{inline(fill(step.say, stage))}</div>')
    return "".join(parts)


def verdict(stage: Stage) -> str:
    """What is said about this very answer."""
    ask, given = stage.step.ask, stage.given
    if isinstance(ask, Choice):
        return "" if given.choice is None else ask.answers[given.choice].because
    if isinstance(ask, Place | Pose) and given.place is not None:
        off = np.linalg.norm(np.array(given.place) - MEASURES[ask.truth].of(stage))
        if off <= ask.near:
            return ask.close
        if isinstance(ask, Place) and ask.line is not None and ask.on_line is not None:
            if MEASURES[ask.line].of(stage) < ask.near:
                return ask.on_line
        return ask.far
    if isinstance(ask, Number) and given.number is not None:
        truth = float(MEASURES[ask.truth].of(stage))
        if ask.factor is not None:
            near = truth > 0 and 1 / ask.factor <= given.number / truth <= ask.factor
        else:
            near = abs(given.number - truth) <= (ask.within or 0.0)
        return ask.close if near else ask.less if ask.less is not None and given.number < truth else ask.far
    return ""


def _figures(stage: Stage, address: str | None) -> str:
    step = stage.step
    main = "".join(_figure(stage, figure, address, False) for figure in step.main)
    side = "".join(_figure(stage, figure, address, True) for figure in step.side)
    kind = " vi-alone" if not step.side else ""
    names = " ".join(f"vi-main-{_class(figure.figure)}" for figure in step.main)
    beside = f'<div class="vi-guide-side">{side}</div>' if side else ""
    return f'<div class="vi-guide-stage{kind}"><div class="vi-guide-figures {names}">{main}</div>{beside}</div>'


def _figure(stage: Stage, figure: Figure, address: str | None, small: bool) -> str:
    layers = layers_of(stage, figure.show, figure.reveal, figure.hide)
    drawn = FIGURES[figure.figure].draw(stage, layers, small)
    ask = stage.step.ask
    kind = f"vi-figure vi-figure-{_class(figure.figure)}"
    if not (isinstance(ask, Place) and ask.figure == figure.figure and not stage.revealed) or address is None:
        return f'<div class="{kind}">{drawn}</div>'
    name = "Place your mark: click, or move it by the arrow keys"
    return (
        f'<div class="{kind} vi-place" id="vi-place" tabindex="0" role="application" aria-label="{name}"'
        f' data-place="{address}/lesson/place,">{drawn}</div>'
    )


def _class(name: str) -> str:
    return name.replace(" ", "-")


def _ending(course: Course, address: str | None) -> str:
    """A question before or after all, or what came of them."""
    if course.screen.kind == "end":
        before, after = course.right_before_and_after()
        count = len(course.lesson.question)
        moved = f"<b>{before}</b> of {count} were right before, <b>{after}</b> of {count} after."
        again = "The page is yours now: pose the demonstrator, and press Play."
        return f'<h2>Done</h2><div class="vi-guide-told"><span>{moved}</span></div><p>{again}</p>'
    words, answers = course.question()
    rows = [(answer, False) for answer in answers]
    options = _options(rows, course.given.choice, False, address)
    return f'<h2>{inline(words)}</h2><p>{LEADS[course.screen.kind]}</p><div class="vi-guide-ask">{options}</div>'


def inline(words: str) -> str:
    """Escaped, with **bold**."""
    return re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", escape(words))


def _number(value: float) -> str:
    return f"{value:g}".replace("-", "−")
