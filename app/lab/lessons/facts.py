"""Facts and records of a step: computed by the library when the page is written.

    situation = Situation(settings, step.scene, step.chosen, step.race, goal)
    facts, records = compute(situation, measures, figures)

A fact is a number of the step's fixed state, and its text. Records are runs, clouds and postures that figures draw.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from viewimit.analysis.landscape import conflict_at, seen_from
from viewimit.analysis.observability import unobservable_joints
from viewimit.drawing import svg
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

from . import circle, records, sign
from .circle import Followed
from .situation import Situation

FAR_TIMES = 10.0  # the distance of the eyes that is asked for
PAPER_BIAS_DEG = 4.0  # of the smallest E: at (41°, -90°) instead of (45°, -90°) in Section 4, (45°, -86°) in Section 5
RECTIFIED_DEG = 5.0  # off, up to which something has put the eyes right
ALONG_DEG, ROUND_RATIO = 30.0, 1.3  # of a cloud: to the valley of E; length over breadth, below which it is round
OPEN_BELOW = 1.0  # px²: of E, how wide it leaves the pose open
TENTH = {1: "the whole", 2: "half", 3: "a third", 4: "a quarter", 10: "a tenth"}


@dataclass(frozen=True)
class Fact:
    """A measure that the library computes."""

    of: Callable[[Situation], Any]  # a number, NaN where there is none, or a text
    unit: str = ""  # behind the number
    digits: int | None = None  # after the point; None for two below 10, one below 1000, none above
    missing: str = "–"  # instead of NaN
    write: Callable[[float], str] | None = None  # the number in words, instead of digits

    def tell(self, situation: Situation) -> dict[str, Any]:
        """Return the value, its unit, and its text as it stands in a sentence."""
        value = float(self.of(situation))
        if not np.isfinite(value):
            return {"value": None, "unit": self.unit, "text": self.missing}
        number = svg.short(value) if self.digits is None else svg.number(value, self.digits)
        text = number + self.unit if self.write is None else self.write(value)
        return {"value": records.plain(value, 6), "unit": self.unit, "text": text}


def compute(
    situation: Situation, measures: Iterable[str], figures: Iterable[str] = ()
) -> tuple[dict[str, dict[str, Any]], dict[str, Any]]:
    """Compute the facts {measure: {"value", "unit", "text"}} and the records {name: plain data for JSON} of a step.
    situation: the step's fixed state, or one that was sampled; measures: names in braces and of the question, of which
    those that the browser computes are left out; figures: names of the step's figures."""
    facts = {name: FACTS[name].tell(situation) for name in measures if name in FACTS}
    names = {record for figure in figures for record in FIGURE_RECORDS.get(figure, ())}
    names |= {"races"} if situation.race else set()
    names |= {"swapped"} if situation.settings.swapped else set()
    return facts, {name: RECORDS[name](situation) for name in RECORDS if name in names}


def share(value: float) -> str:
    """Write a share of one as a fraction: "a tenth", "a 48th"; as a multiple above two thirds."""
    whole = round(1 / value)
    if whole < 2:
        return f"{value:.2g} times"
    if whole in TENTH:
        return TENTH[whole]
    ending = "th" if whole % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(whole % 10, "th")
    leading = str(whole)  # as it is spoken: an eighth, an eighteenth, an eight hundredth, an eleventh
    return f"{'an' if leading[0] == '8' or whole in (11, 18) else 'a'} {whole}{ending}"


def _bias_at(times: float) -> Callable[[Situation], float]:
    return lambda situation: records.bias_deg(situation.with_eyes(distance=times))


def _left_of_arrows(situation: Situation) -> float:
    return float(np.sqrt(situation.with_eyes(distance=FAR_TIMES).start.E / situation.start.E))


def valley_E(situation: Situation) -> float:
    """px²: the largest E over the range of the unobservable joint, the others as the demonstrator's."""
    start, scene = situation.start, situation.scene
    joint = int(np.argmax(records.costs(situation)))
    theta = [np.full(200, angle) for angle in start.theta_demo]
    theta[joint] = np.linspace(scene.lower[joint], scene.upper[joint], 200)
    return float(np.nanmax(conflict_at(*seen_from(situation.world, start), theta)))


def _unobservable(situation: Situation) -> float:
    """Which answer is right: each joint in turn, all of them, none."""
    spread = records.costs(situation)
    found = unobservable_joints(spread)
    return float(found[0] + 1 if len(found) == 1 else len(spread) + (1 if found else 2))


def _cloud_direction(situation: Situation) -> float:
    """Which answer is right: along the valley of E, across it, or the same in all directions."""
    one = records.clouds(situation)[records.FRAMES[0]]
    spread, directions = np.linalg.eigh(np.cov(one.T))
    if np.sqrt(spread[-1] / spread[0]) < ROUND_RATIO:
        return 3.0
    J = records.jacobian(situation, True)
    flattest = np.linalg.eigh(J.T @ J)[1][:, 0]  # of the curvature of E
    angle = np.degrees(np.arccos(min(abs(float(directions[:, -1] @ flattest)), 1.0)))
    return 1.0 if angle < ALONG_DEG else 2.0 if angle > 90 - ALONG_DEG else 3.0


def _scatter(frames: int, joint: int) -> Callable[[Situation], float]:
    return lambda situation: float(np.degrees(records.clouds(situation)[frames].std(0)[joint]))


def _shrinks(situation: Situation) -> float:
    one, averaged = (records.clouds(situation)[frames].var(0).sum() for frames in records.FRAMES)
    return float(np.sqrt(one / averaged))


def _middle_off(situation: Situation) -> float:
    averaged = records.clouds(situation)[records.FRAMES[1]]
    return records.degrees_off(averaged.mean(0), situation.start.theta_demo)


def _off_case(name: str) -> Callable[[Situation], float]:
    return lambda situation: records.bias_deg(records.rectified(situation)[name])


def _rectifies(situation: Situation) -> float:
    """Which answer is right: more points, bending the images, nothing."""
    off = [_off_case(name)(situation) for name in ("more points", "rectified")]
    return float(np.argmin(off) + 1 if min(off) < RECTIFIED_DEG else 3)


def _at_rest(of: Callable[[Snapshot], float]) -> Callable[[Situation], float]:
    return lambda situation: of(records.run(situation, situation.race[0]).snapshot)


def _followed(of: Callable[[Followed], float], which: str) -> Callable[[Situation], float]:
    return lambda situation: float(of(getattr(circle.follow_circle(situation), which)))


def _median_motions(servo: str) -> Callable[[Situation], float]:
    motions = lambda one: records.motions_to(records.run(one, servo), records.RACE_GOAL)
    return lambda situation: float(np.median(list(map(motions, records.race_starts(situation)))))


def widest_deg(situation: Situation, below: float) -> float:
    """Degrees from the demonstrator's posture to the farthest one with an E below `below` px²."""
    found = records.landscape(situation, 1.0)
    demo = situation.start.theta_demo
    off = np.maximum(np.abs(found.axes[0] - demo[0])[:, None], np.abs(found.axes[1] - demo[1]))
    return float(np.degrees(off[found.E < below].max(initial=0.0)))


def _open(points: int) -> Callable[[Situation], float]:
    usual = Situation(Settings.paper(demonstrator_deg=(62, -118), points=points))
    return lambda situation: widest_deg(usual, OPEN_BELOW)


def _hand_run_off(situation: Situation) -> float:
    """Degrees: the error of the second joint in the run whose points are all on the hand."""
    one = next(one for one in sign.signed_runs() if one.settings.body_points is not None)
    return float(sign.off_deg(one.session.snapshot)[1])


def _first_shown(joint: int, by_arrows: bool) -> Fact:
    return Fact(lambda situation: records.shown_px(situation, joint, by_arrows), " px")


def _cost(joint: int) -> Fact:
    return Fact(lambda situation: float(np.degrees(records.costs(situation)[joint])), "°", 1, "any angle")


FACTS: Mapping[str, Fact] = {
    # tour
    "median cosine": Fact(lambda situation: float(np.median(records.signposts(situation))), "", 2),
    # limits
    "bias at once the distance": Fact(_bias_at(1.0), "°", 1),
    "bias at ten times the distance": Fact(_bias_at(FAR_TIMES), "°"),
    "share of the bias that is left": Fact(
        lambda situation: _bias_at(FAR_TIMES)(situation) / records.bias_deg(situation), write=share
    ),
    "share of the arrows that is left": Fact(_left_of_arrows, write=share),
    "E once the distance": Fact(lambda situation: situation.start.E, " px²"),
    "the paper's bias": Fact(lambda situation: PAPER_BIAS_DEG, "°", 0),
    "bias without noise": Fact(lambda situation: records.bias_deg(situation.with_settings(noise_px=0.0)), "°", 1),
    "middle of the cloud is off": Fact(_middle_off, "°", 1),
    "direction of the cloud": Fact(_cloud_direction),
    "joint that can be anything": Fact(_unobservable),
    "largest E along the valley": Fact(lambda situation: max(valley_E(situation), svg.UNSEEN_E), " px²"),
    "first joint moves": _first_shown(0, False),
    "first joint shows": _first_shown(0, True),
    "second joint shows": _first_shown(1, True),
    "cost at the first joint": _cost(0),
    "cost at the second joint": _cost(1),
    "scatter of the first joint": Fact(_scatter(records.FRAMES[0], 0), "°", 1),
    "averaged scatter of the first joint": Fact(_scatter(records.FRAMES[1], 0), "°", 1),
    "times the cloud shrinks": Fact(_shrinks, "", 1),
    "runs": Fact(lambda situation: float(records.RUNS), "", 0),
    "what puts it right": Fact(_rectifies),
    "off as seen": Fact(_off_case("as seen"), "°", 1),
    "off rectified": Fact(_off_case("rectified"), "°", 1),
    "off with more points": Fact(_off_case("more points"), "°", 1),
    "matches": Fact(lambda situation: 2.0 * float(situation.start.usable.sum()), "", 0),
    # motion
    "off at rest": Fact(_at_rest(lambda last: records.degrees_off(last.theta, last.theta_demo)), "°", 1),
    "motions to rest": Fact(_at_rest(lambda last: float(last.motion)), "", 0),
    "what the early geometry draws": Fact(_followed(lambda one: circle.DRAWS.index(one.draws) + 1, "early")),
    "mm between hands, frozen at agreement": Fact(_followed(lambda one: one.hand_mm, "right"), " mm", 0),
    "mm between hands, frozen early": Fact(_followed(lambda one: one.hand_mm, "early"), " mm", 0),
    "px overlap, frozen at agreement": Fact(_followed(lambda one: np.median(one.overlap_px), "right"), " px", 1),
    "px overlap, frozen early": Fact(_followed(lambda one: np.median(one.overlap_px), "early"), " px", 1),
    "px from the true path, frozen early": Fact(_followed(lambda one: np.median(one.truth_px), "early"), " px", 0),
    "off when frozen early": Fact(
        _followed(lambda one: records.degrees_off(one.frozen.theta, one.frozen.theta_demo), "early"), "°", 0
    ),
    "E when frozen early": Fact(_followed(lambda one: one.frozen.E, "early"), " px²"),
    "circle's width": Fact(_followed(lambda one: 2e3 * one.radius_m, "right"), " mm", 0),
    "length of the early loop": Fact(_followed(lambda one: 1e3 * one.loop_m[0], "early"), " mm", 0),
    "breadth of the early loop": Fact(_followed(lambda one: 1e3 * one.loop_m[1], "early"), " mm", 0),
    "mm a pixel": Fact(lambda situation: circle.follow_circle(situation).mm_per_px, " mm", 0),
    # jacobian
    "median steps of the gradient law": Fact(_median_motions("gradient-retuned"), missing="never", write="{:g}".format),
    "median steps of Broyden": Fact(_median_motions("broyden"), missing="never", write="{:g}".format),
    "starts of the race": Fact(lambda situation: float(records.RACE_STARTS), "", 0),
    # the eight questions
    "open with five points": Fact(_open(5), "°", 0),
    "open with ten points": Fact(_open(10), "°", 0),
    "elbow off with hand points": Fact(_hand_run_off, "°", 0),
}
RECORDS: Mapping[str, Callable[[Situation], Any]] = {  # by the name under which the page has it
    "races": records.races,
    "biases": records.biases,
    "clouds": records.clouds_record,
    "swapped": lambda situation: [list(pair) for pair in records.true_pairs(situation)],
    "rectification": records.rectification_record,
    "offDeg": lambda situation: {
        name: records.plain(records.bias_deg(one)) for name, one in records.rectified(situation).items()
    },
    "circle": circle.circle_record,
    "runs": lambda situation: sign.runs_record(),
}
FIGURE_RECORDS: Mapping[str, tuple[str, ...]] = {  # the records that a figure draws
    "biases": ("biases",),
    "clouds": ("clouds",),
    "rectified": ("rectification", "offDeg"),
    "rows": ("rectification",),
    "circle in L": ("circle",),
    "circle from the side": ("circle",),
    "claim": ("runs",),
    "run images": ("runs",),
    "E history": ("runs",),
    "bets": ("runs",),
    "review of runs": ("runs",),
}
