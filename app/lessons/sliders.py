"""The sliders of a step. HTML."""

import numpy as np

from viewimit.drawing.svg import escape

from .course import Course
from .format import Do, Pose, Slider
from .words import shown


def slides(course: Course) -> bool:
    """Whether the step's sliders are in reach: where something is to be done, or once it is revealed; those of a
    see-through arm until then."""
    step = course.step
    if step is None or not step.sliders:
        return False
    if isinstance(step.ask, Pose):
        return not course.given.revealed
    return isinstance(step.ask, Do) or course.given.revealed


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
    words = "" if slider.unit is None else escape(f"{shown(value)}{slider.unit}")
    output = f"<output>{words}</output>" if words else ""
    said = f' aria-valuetext="{words}"' if words else ""
    live = "" if slider.name.startswith("own ") else ' data-live=""'
    log = ' data-log=""' if slider.logarithmic else ""
    told = f'data-turn="{address}/lesson/turn,{k},"{live}{log}'
    return (
        f'<label><span>{escape(slider.label)}</span><input type="range" id="vi-guide-slider-{k}" min="{low:g}"'
        f' max="{high:g}" step="{step:g}" value="{at:g}"{said} {told}/>{output}</label>'
    )


def _even(slider: Slider, number: float) -> float:
    return float(np.log10(number)) if slider.logarithmic else number
