"""What is asked in a step and can be answered: options, numbers on a scale, or how far it is to the goal. HTML."""

from collections.abc import Sequence

import numpy as np

from viewimit.drawing.svg import escape

from ..drawing.links import link
from .format import Choice, Do, Number, Place, Select
from .measures import MEASURES
from .stage import Stage
from .words import inline, shown

MOVE = "Click again to move the mark, or use the arrow keys."
NUMBERS = 13  # on the scale of a number that is asked for


def draw_ask(stage: Stage, address: str | None) -> str:
    ask, given = stage.step.ask, stage.given
    assert ask is not None
    question = f"<b>{inline(ask.question)}</b>"
    if isinstance(ask, Choice):
        return f'<div class="vi-guide-ask">{question}{_answers(stage, ask, address)}</div>'
    if isinstance(ask, Select):
        return f'<div class="vi-guide-ask">{question}{_fields(stage, ask, address)}</div>'
    if given.revealed:
        return ""
    if isinstance(ask, Number):
        return f'<div class="vi-guide-ask">{question}{_scale(ask, given.number, address)}</div>'
    if isinstance(ask, Do):
        return f'<div class="vi-guide-ask">{question}{_meter(stage, ask)}</div>'
    hint = MOVE if isinstance(ask, Place) else "Turn the joints below."
    return f'<div class="vi-guide-ask">{question}<small>{hint}</small></div>'


def _answers(stage: Stage, ask: Choice, address: str | None) -> str:
    right = right_answer(stage, ask) if stage.revealed else None
    rows = [(answer.text, k == right) for k, answer in enumerate(ask.answers)]
    return draw_options(rows, stage.given.choice, stage.revealed, address)


def right_answer(stage: Stage, ask: Choice) -> int | None:
    """Its index: as written, or as computed; None while it is computed."""
    if ask.right is not None:
        number = float(MEASURES[ask.right].of(stage))
        return round(number) - 1 if np.isfinite(number) else None
    return next(k for k, answer in enumerate(ask.answers) if answer.right)


def draw_options(rows: Sequence[tuple[str, bool]], choice: int | None, revealed: bool, address: str | None) -> str:
    drawn = []
    for k, (words, right) in enumerate(rows):
        kind = "vi-option" + (" vi-chosen-one" if k == choice else "")
        if revealed:
            kind += " vi-right-one" if right else " vi-wrong-one" if k == choice else ""
            mark = "✓ " if right else "✗ " if k == choice else ""
            drawn.append(f'<span class="{kind}">{mark}{inline(words)}</span>')
            continue
        inside = f'<span class="{kind}"><kbd>{k + 1}</kbd>{inline(words)}</span>'
        said = words.replace("**", "")
        drawn.append(
            inside if address is None else link(address, f"lesson/choose,{k}", said, inside, True, k == choice)
        )
    return f'<div class="vi-options">{"".join(drawn)}</div>'


def scale_of(ask: Number) -> list[float]:
    """The numbers to choose from."""
    if ask.logarithmic:
        values = np.geomspace(ask.low, ask.high, NUMBERS)
    else:
        count = NUMBERS if ask.step is None else round((ask.high - ask.low) / ask.step) + 1
        values = np.linspace(ask.low, ask.high, count)
    return [float(f"{number:.2g}") for number in values]


def _scale(ask: Number, chosen: float | None, address: str | None) -> str:
    """Each a link."""
    drawn = []
    for value in scale_of(ask):
        here = chosen is not None and abs(value - chosen) < 1e-9
        kind = "vi-option" + (" vi-chosen-one" if here else "")
        words = f"{shown(value)}{ask.unit}"
        inside = f'<span class="{kind}">{escape(words)}</span>'
        drawn.append(inside if address is None else link(address, f"lesson/guess,{value:g}", words, inside, True, here))
    return f'<div class="vi-options vi-numbers">{"".join(drawn)}</div>'


def _fields(stage: Stage, ask: Select, address: str | None) -> str:
    """A list of links a field, which keys number through; once it is revealed, what was selected."""
    given, parts, key = stage.given, [], 0
    for k, (field, chosen) in enumerate(zip(ask.fields, given.selected or (-1,) * len(ask.fields))):
        drawn = []
        for j, value in enumerate(field.values):
            key += 1
            if given.revealed and j != chosen:
                continue
            kind = "vi-option" + (" vi-chosen-one" if j == chosen else "")
            number = "" if given.revealed else f"<kbd>{key}</kbd>"
            inside = f'<span class="{kind}">{number}{inline(value.text)}</span>'
            said = f"{field.label}: {value.text}{', chosen' if j == chosen else ''}"
            if address is not None and not given.revealed:
                inside = link(address, f"lesson/select,{k},{j}", said, inside)
            drawn.append(inside)
        parts.append(f'<small>{inline(field.label)}</small><div class="vi-options vi-fields">{"".join(drawn)}</div>')
    return "".join(parts)


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
        begun = f"<span>start {shown(round(first, 1))}</span>" if ask.measure == "E" else ""
    return (
        f'<div class="vi-meter"><i style="width:{100 * float(share):.0f}%"></i></div>'
        f'<div class="vi-meter-words">{begun}<span>{said}</span><span>goal {shown(goal)}</span></div>'
    )
