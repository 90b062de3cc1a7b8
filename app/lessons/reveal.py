"""What is told once a step is answered: a number in large, what is said to this very answer, and the sentence to take
along. HTML."""

import numpy as np

from viewimit.drawing.svg import escape

from .format import Choice, Do, Number, Place, Pose
from .judging import is_near
from .measures import MEASURES, fill
from .stage import Stage
from .words import inline


def draw_reveal(stage: Stage) -> str:
    step, parts = stage.step, []
    if step.told is not None and (step.ask is None or _has_answer(stage)):
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


def _has_answer(stage: Stage) -> bool:
    """Or it was shown to a class."""
    given, ask = stage.given, stage.step.ask
    return given.place is not None or not isinstance(ask, Place | Pose)


def spoken(stage: Stage) -> str:
    """What is read aloud as it becomes known: what came of the last motion, or of the answer. Not the whole card."""
    step = stage.step
    if not stage.revealed:
        ask = step.ask
        return f"{ask.measure} {MEASURES[ask.measure].told(stage)}" if isinstance(ask, Do) else ""
    told = "" if step.told is None else f"{step.told.label}: {MEASURES[step.told.measure].told(stage)}."
    parts = told, fill(verdict(stage), stage), fill(step.say, stage)
    return " ".join(filter(None, parts)).replace("**", "") if step.ask is not None else ""


def verdict(stage: Stage) -> str:
    """What is said about this very answer; nothing while what is true is computed."""
    ask, given = stage.step.ask, stage.given
    if isinstance(ask, Choice):
        return "" if given.choice is None else ask.answers[given.choice].because
    if isinstance(ask, Place | Pose) and given.place is not None:
        off = MEASURES["px apart"].of(stage)
        if np.isnan(off):
            return ""
        if off <= ask.near:
            return ask.close
        if isinstance(ask, Place) and ask.line is not None and ask.on_line is not None:
            if MEASURES[ask.line].of(stage) < ask.near:
                return ask.on_line
        return ask.far
    if isinstance(ask, Number) and given.number is not None:
        truth = float(MEASURES[ask.truth].of(stage))
        if np.isnan(truth):
            return ""
        near = is_near(ask, given.number, truth)
        return ask.close if near else ask.less if ask.less is not None and given.number < truth else ask.far
    return ""
