"""What a step can ask for and reveal, by name: numbers, places and postures, each computed from the step's session.

A number is told with its unit; the words of a lesson hold none.
"""

from collections.abc import Mapping

import numpy as np

from ..format import Place, Pose
from ..stage import Stage
from . import (
    carried,
    crossing_angle,
    exchange,
    four_points,
    minimum,
    noise,
    observability,
    posture,
    rectification,
    rest,
    rounds,
    tour,
)
from .measure import Measure


def _distance(stage: Stage) -> float:
    """From the visitor's mark to what is true, in the unit of the figure; of a posture, by its joint that is farthest
    off."""
    ask = stage.step.ask
    if stage.guess is None or not isinstance(ask, Place | Pose):
        return np.nan
    apart = stage.guess - MEASURES[ask.truth].of(stage)
    return float(np.abs(apart).max() if isinstance(ask, Pose) else np.linalg.norm(apart))


MEASURES: Mapping[str, Measure] = {
    "px apart": Measure(_distance, " px", 0),
    "degrees apart": Measure(_distance, "°", 0),
    **tour.MEASURES,
    **minimum.MEASURES,
    **crossing_angle.MEASURES,
    **four_points.MEASURES,
    **observability.MEASURES,
    **rest.MEASURES,
    **posture.MEASURES,
    **noise.MEASURES,
    **exchange.MEASURES,
    **rectification.MEASURES,
    **carried.MEASURES,
    **rounds.MEASURES,
}


def fill(words: str, stage: Stage) -> str:
    """Each {measure} in words by its number."""
    parts = words.split("{")
    filled = parts[0]
    for part in parts[1:]:
        name, rest = part.split("}", 1)
        filled += MEASURES[name].told(stage) + rest
    return filled


def named_in(words: str) -> list[str]:
    """The measures that words have in braces."""
    return [part.split("}", 1)[0] for part in words.split("{")[1:]]
