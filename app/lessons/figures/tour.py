"""Of the tour: the four images, the scene, the formula of E, the landscape, and how all went."""

from collections.abc import Collection, Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.lessons import bowl, view
from viewimit.drawing.lessons.bowl import Way, draw_bowl
from viewimit.drawing.lessons.formula import draw_formula
from viewimit.drawing.lessons.progress import draw_progress
from viewimit.drawing.lessons.standings import Row, draw_standings
from viewimit.drawing.lessons.view import draw_view
from viewimit.servo import SERVOS, ServoStatus

from ..format import Place
from ..measures import MEASURES
from ..measures.crossing_angle import construction
from ..measures.exchange import named
from ..measures.tour import error_deg, reached
from ..stage import Race, Stage
from .figure_kind import FigureKind
from .see_through import see_through

ROLES = {"trust-region": "learner", "broyden": "opponent"}  # of races; all others are slow
ORDER = ("slow", "learner", "opponent")  # in which ways are drawn, so that where two coincide both are seen
WHY = {
    ServoStatus.CONVERGED: "says: arrived",
    ServoStatus.SETTLED: "rests where E is least",
    ServoStatus.UNOBSERVABLE: "says: a joint is not told",
    ServoStatus.NO_PROGRESS: "found nothing lower",
    ServoStatus.TOO_FEW_POINTS: "too few points are seen",
}


def _view(name: str) -> FigureKind:
    def draw(stage: Stage, layers: Collection[str], small: bool) -> str:
        asked = isinstance(stage.step.ask, Place) and stage.step.ask.figure == name
        guess = stage.guess if asked else None
        apart = MEASURES["px apart"].told(stage) if guess is not None and stage.revealed else ""
        spread = construction(stage) if "ellipse" in layers else None
        said, others = (stage.step.chosen, guess, apart, stage.shown(small)), _others(stage, name)
        about = spread, named(stage), see_through(stage), others
        return draw_view(name, stage.moment, stage.bodies, layers, *said, *about)

    return FigureKind(draw, view.LAYERS, partial(_place_in_view, name))


def _others(stage: Stage, figure: str) -> NDArray | None:
    """(k, 2) in its unit: what a class has placed in it; None for nothing."""
    ask = stage.step.ask
    return np.array(stage.others) if isinstance(ask, Place) and ask.figure == figure and stage.others else None


def _place_in_view(name: str, stage: Stage, at: NDArray) -> NDArray:
    """px, within the drawing."""
    window = stage.window(name)
    return window.unplace(np.clip(at, 0, window.size))


def _bowl(stage: Stage, layers: Collection[str], small: bool) -> str:
    asked = isinstance(stage.step.ask, Place) and stage.step.ask.figure == "landscape"
    guess = stage.guess if asked else None
    apart = MEASURES["degrees apart"].told(stage) if guess is not None and stage.revealed else ""
    ways = []
    if "others" in layers:
        alone = len(stage.step.race) == 1
        others = (_way(race, "the learner" if alone else _title(race.servo)) for race in stage.races_so_far)
        ways += sorted(others, key=lambda way: ORDER.index(way.role))
    if "paths" in layers and stage.trail.path:
        path = np.array(stage.trail.path)
        ways.append(Way("you", "you", path, np.zeros(len(path), bool), len(path) - 1))
    note = "" if not any(way.probes.any() for way in ways) else f"hollow: a prob{'e' if stage.narrow else 'ing motion'}"
    theta_demo = stage.moment.theta_demo
    crowd = stage.narrow, _others(stage, "landscape")
    return draw_bowl(stage.session.scene, stage.landscape, layers, theta_demo, ways, guess, apart, note, *crowd)


def _way(race: Race, name: str) -> Way:
    postures = np.degrees([moment.theta for moment in race.moments])
    probes = np.array([moment.probe for moment in race.moments])
    best = int(np.argmin([moment.E for moment in race.moments]))
    return Way(name, ROLES.get(race.servo, "slow"), postures, probes, best)


def _title(servo: str) -> str:
    return {"trust-region": "trust region", "broyden": "Broyden", "gradient": "the paper's law"}.get(
        servo, SERVOS[servo].title
    )


def _progress(stage: Stage, layers: Collection[str], small: bool) -> str:
    E = [moment.E for moment in stage.moments]
    note = f"start no. {stage.given.seed}" if stage.step.deal else ""
    return draw_progress(E, stage.goal, note, stage.narrow)


def _standings(stage: Stage, layers: Collection[str], small: bool) -> str:
    goal = stage.goal
    if goal is None:
        return ""
    rows = []
    if stage.trail.path:
        off = float(np.abs(np.array(stage.trail.path[-1]) - np.degrees(stage.moment.theta_demo)).max())
        E = list(stage.trail.E)
        rows.append(Row("you", "you", _whole(reached(E, goal)), len(E) - 1, E[-1], off, "goal reached"))
    rows += [_raced(race, whole, goal) for race, whole in zip(stage.races_so_far, stage.races)]
    if len(stage.races) < len(stage.step.race):
        return draw_standings(rows, goal) + '<p class="vi-waits">the others are on their way …</p>'
    return draw_standings(rows, goal)


def _raced(race: Race, whole: Race, goal: float) -> Row:
    """Of what is shown of a race. What it tries after its best, far from there, is not where it ends."""
    E, last = [moment.E for moment in race.moments], race.moments[-1]
    row = _title(race.servo), ROLES.get(race.servo, "slow"), _whole(reached(E, goal)), len(E) - 1
    if len(race.moments) < len(whole.moments):
        return Row(*row, None, None, "looks for anything lower" if min(E) < goal else "on its way")
    return Row(*row, E[-1], error_deg(last), WHY.get(last.status, f"still on its way at {len(E) - 1}"))


def _whole(motions: float) -> int | None:
    return int(motions) if np.isfinite(motions) else None


FIGURES: Mapping[str, FigureKind] = {
    **{name: _view(name) for name in "lrLR"},
    "scene": FigureKind(lambda stage, layers, small: '<div class="vi-hole"></div>'),
    "formula": FigureKind(lambda stage, layers, small: draw_formula(stage.moment, stage.narrow)),
    "progress": FigureKind(_progress),
    "landscape": FigureKind(
        _bowl, bowl.LAYERS, lambda stage, at: bowl.unplace(stage.session.scene, at, stage.narrow), ("landscape",)
    ),
    "standings": FigureKind(_standings, works=("races",)),
}
