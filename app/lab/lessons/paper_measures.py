"""Measures of a step's first picture that a browser computes when it shows them, computed by the library for paper."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.construction import construct
from viewimit.analysis.landscape import Landscape
from viewimit.geometry.affine import LINE_VIEWS, POINT_VIEWS

from . import records
from .facts import Fact
from .situation import Situation

L = 2  # index of the view
MAP_STEP_DEG = 1.0
Array = NDArray[np.float64]


def _alike(situation: Situation) -> Situation:
    """The same state with the learner in the demonstrator's posture."""
    return situation.with_settings(start_deg=tuple(np.degrees(situation.start.theta_demo).tolist()))


def _angle(situation: Situation) -> float:
    """Radians between both lines of the chosen point in L."""
    found = construct(situation.start, situation.chosen or 0)
    return np.nan if found is None or found.angle is None else float(found.angle[0])


def _crossing_moves(situation: Situation) -> float:
    """px that the crossing goes in L if the line from r moves by 1 px."""
    found = situation.start.epipolar_lines(situation.chosen or 0)
    if found is None:
        return np.nan
    first, second = (found[np.flatnonzero((LINE_VIEWS == L) & (POINT_VIEWS == eye))[0]] for eye in (0, 1))
    moved = second + [0.0, 0.0, np.hypot(*second[:2])]
    places = [np.cross(first, line)[:2] / np.cross(first, line)[2] for line in (second, moved)]
    return float(np.linalg.norm(places[1] - places[0]))


def _arrows(situation: Situation) -> Array:
    """(N, 2, 2) px in L, R: from the place where the lines put a point to the learner's own point."""
    start = situation.start
    return (start.views.own - start.recovered).reshape(-1, 2, 2)


def _ways(situation: Situation) -> Array:
    """(N, 2, 2) px in L, R: from the learner's own point to where it is in the demonstrator's posture."""
    return (_alike(situation).start.views.own - situation.start.views.own).reshape(-1, 2, 2)


def _length_in_L(vectors: Array, point: int) -> float:
    return float(np.linalg.norm(vectors[point, 0]))


def _arrow(point: int) -> Fact:
    return Fact(lambda situation: _length_in_L(_arrows(situation), point), " px", 0)


def _way(point: int) -> Fact:
    return Fact(lambda situation: _length_in_L(_ways(situation), point), " px", 0)


def _cosine(situation: Situation) -> float:
    start, goal = situation.start, _alike(situation).start.views.own
    return records.signpost_cosine(start.views, start.recovered, goal)


def _share_of_the_longest(situation: Situation) -> float:
    squares = (_arrows(situation) ** 2).sum(-1)
    return float(100 * squares.max() / squares.sum())


def _crossing_to(situation: Situation, goal: Array) -> float:
    chosen = situation.chosen or 0
    return float(np.linalg.norm(situation.start.recovered[chosen, :2] - goal[chosen, :2]))


def _energy(of: Callable[[Situation], float]) -> Fact:
    """E, as a browser writes it."""
    return Fact(of, write=lambda E: f"{energy_text(E)} px²")


def energy_text(E: float) -> str:
    """E in px², with the digits that it has on the page."""
    return f"{E:.{0 if E >= 100 else 1 if E >= 10 else 2}f}"


def _map(situation: Situation) -> Landscape:
    """E at every degree, as a browser's map has it."""
    return records.landscape(situation, MAP_STEP_DEG)


def _map_off(situation: Situation) -> float:
    """Degrees from the lowest place of the map to the demonstrator's posture."""
    return records.degrees_off(_map(situation).minimum, situation.start.theta_demo)


PAPER_MEASURES: Mapping[str, Fact] = {
    "E": _energy(lambda situation: situation.start.E),
    "E alike": _energy(lambda situation: _alike(situation).start.E),
    "crossing angle": Fact(lambda situation: float(np.degrees(_angle(situation))), "°", 1),
    "crossing moves": Fact(_crossing_moves, " px", 1),
    "crossing to own point": Fact(
        lambda situation: _crossing_to(situation, situation.start.views.own),
        write=lambda px: f"{px:.{int(px < 10)}f} px",
    ),
    "crossing to ghost": Fact(lambda situation: _crossing_to(situation, _alike(situation).start.views.own), " px", 0),
    "baseline": Fact(lambda situation: 100 * situation.scene.head.baseline, " cm", 0),
    "cond A": Fact(lambda situation: situation.start.transfer.condition if situation.start.transfer else np.nan, "", 0),
    "arrow of 3": _arrow(3),
    "arrow of 9": _arrow(9),
    "way of 9": _way(9),
    "cosine": Fact(_cosine, "", 2),
    "share of the longest": Fact(_share_of_the_longest, " %", 0),
    "smallest E": _energy(lambda situation: float(np.nanmin(_map(situation).E))),
    "smallest E is off": Fact(_map_off, "°", 1),
}
