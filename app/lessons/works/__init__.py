"""What takes longer than a page may wait, by name: computed beside it for a step, and shown by its figures."""

from collections.abc import Mapping

from . import carried, four_points, minimum, noise, rectification, rounds, tour
from .work import Work

WORKS: Mapping[str, Work] = {
    **tour.WORKS,
    **minimum.WORKS,
    **four_points.WORKS,
    **noise.WORKS,
    **rectification.WORKS,
    **carried.WORKS,
    **rounds.WORKS,
}
