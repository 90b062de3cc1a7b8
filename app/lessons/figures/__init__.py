"""The figures that a step can show, by name, drawn of what measures and works have found."""

from collections.abc import Collection, Mapping

from ..stage import Stage
from . import carried, crossing_angle, four_points, minimum, noise, rectification, rounds, tour, verdict
from .figure_kind import FigureKind

FIGURES: Mapping[str, FigureKind] = {
    **tour.FIGURES,
    **minimum.FIGURES,
    **crossing_angle.FIGURES,
    **four_points.FIGURES,
    **verdict.FIGURES,
    **noise.FIGURES,
    **rectification.FIGURES,
    **carried.FIGURES,
    **rounds.FIGURES,
}


def layers_of(stage: Stage, show: Collection[str], reveal: Collection[str], hide: Collection[str]) -> list[str]:
    """Those of a figure that are shown at a moment."""
    if not stage.revealed:
        return list(show)
    return [layer for layer in show if layer not in hide] + list(reveal)
