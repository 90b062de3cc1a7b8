"""What `viewimit evaluate` tells with several postures of the learner's own body: names of points, and misfits.

The learner's own images at known joint angles determine kinematics, which predict its images in the demonstrator's
posture. The angles come from a calibration, or from a table beside the tracked points. So the demonstrator's points are
named (`--unmatched`), and it is said why the demonstrator is no body like the own one.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..estimation.outliers import find_outliers, select_matches
from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS, image_unit
from ..geometry.kinematics.adjustment import KinematicsCovariance, fit_kinematics
from ..geometry.kinematics.clusters import Observations
from ..geometry.kinematics.disturbed import Shortfall, fit_shortfall
from ..geometry.kinematics.model import ProjectiveKinematics
from ..geometry.rectification import Rectification, fit_rectification
from ..loop.self_calibration import MIN_POSTURES, SelfCalibration
from ..sensing.tracks.text import Table, column_names
from ..servo import Misfit, MisfitKind, Observation
from ..servo.observation import Visit
from ..servo.trust_region.image_models import KinematicImages
from ..servo.trust_region.misfit import Explanation, explain, explain_again
from ..servo.trust_region.naming import Naming, find_naming, mixed_up, nearest_posture
from ..servo.trust_region.options import DEFAULTS
from . import BadInput
from .options import misfit_json, naming, naming_json

MARGIN_RAD = np.radians(30.0)  # beyond the learner's own postures, in which the demonstrator's is looked for
UNITS_DEG = {"radians": float(np.degrees(1)), "turns": 360.0, "steps of 4096 a turn": 360 / 4096, "tenths": 0.1}
SAME_UNIT = 0.15  # of the logarithm of a joint's turn for a unit
MIN_GAIN_CHANGE, GAIN_SIGMA = 0.1, 4.0  # of a joint's turn for a degree; in standard errors
N_TOGETHER = 5  # frames that show how a demonstrator's body differs, at most
N_FRAMES = 5  # with the most points of the demonstrator, in which a naming is tried
NEEDED = "--calibration FILE of viewimit rehearse, or --postures FILE with the learner's joint angles in each frame"


@dataclass(frozen=True)
class OwnBody:
    """The learner's own body, in image units."""

    points: NDArray[np.int_]  # (N,): its points, among those tracked
    seen: Observations  # in K postures
    kinematics: ProjectiveKinematics  # that explain these images
    shortfall: Shortfall | None  # of an arm that was not where the table says
    noise_px: float
    unit_px: float  # pixels of one unit
    lower: NDArray[np.float64]  # (m,) rad, between which the demonstrator's posture is looked for
    upper: NDArray[np.float64]
    gains: NDArray[np.float64] | None  # (m,) degrees that each joint turns for a unit of the table, if it is no degree

    @property
    def model(self) -> KinematicImages:
        """Predicts its images."""
        return KinematicImages(self.kinematics, self.seen.displacement[0], self.seen, self.noise_px, None)

    @property
    def visits(self) -> tuple[Visit, ...]:
        seen = self.seen
        rows = zip(seen.displacement, seen.images, np.repeat(seen.visible_in_both[..., None], 2, -1))
        return tuple(Visit.of(*row) for row in rows)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--unmatched",
        action="store_true",
        help="names in l and r are not those in L and R: find out which point is which; needs one of the next two",
    )
    also = "it also shows why a demonstrator is no body like it"
    parser.add_argument(
        "--calibration", type=Path, metavar="FILE", help=f"the learner's body, by viewimit rehearse; {also}"
    )
    parser.add_argument(
        "--postures",
        type=Path,
        metavar="FILE",
        help=f"table of the learner's joint angles: frame, then a column of degrees for each joint; {also}",
    )


def require_options(args: argparse.Namespace) -> None:
    """Raise BadInput for options that do not go together."""
    given = [name for name in ("calibration", "postures") if vars(args)[name] is not None]
    if len(given) > 1:
        raise BadInput("--calibration, --postures: both show the learner's body, give one")
    if args.unmatched and not given:
        raise BadInput(f"--unmatched: needs {NEEDED}")


def learn_body(args: argparse.Namespace, frames: Sequence[int], views: FourViews) -> OwnBody | None:
    """Learn the own body from a table of joint angles or a calibration; None without either. views: T frames.

    Raises BadInput.
    """
    if args.postures is None and args.calibration is None:
        return None
    own = np.flatnonzero(views.visible[..., 2:].all(-1).any(0))
    matches, noise_px = select_matches(views), find_outliers(views).noise_px or 0.0
    rectification = None if args.rectify == "off" else fit_rectification(matches[:, :2], matches[:, 2:])
    if args.postures:
        with naming("--postures"):
            seen = _with_postures(args.postures, frames, views, own)
        lower, upper = seen.displacement.min(0) - MARGIN_RAD, seen.displacement.max(0) + MARGIN_RAD
    else:
        with naming("--calibration"):
            calibration = SelfCalibration.load(args.calibration)
            seen = _of_calibration(calibration, len(own))
        lower, upper = np.zeros(len(calibration.body.span_deg)), np.radians(calibration.body.span_deg)
        noise_px = max(noise_px, calibration.noise_px)
    unit_px = image_unit(seen.images[seen.visible_in_both])
    seen, noise = replace(seen, images=seen.images / unit_px), noise_px / unit_px
    rectified = None if rectification is None else rectification.in_units(unit_px)
    in_radians = args.postures is not None and np.abs(seen.displacement).max() <= np.radians(2 * np.pi)
    if in_radians:
        _require_degrees(seen, noise, rectified, {"radians": UNITS_DEG["radians"]})
    kinematics, shortfall = fit_kinematics(seen, noise, rectified), None
    if kinematics is None and (found := fit_shortfall(seen, noise, rectified)) is not None:
        kinematics, shortfall = found
        seen = replace(seen, displacement=shortfall.reached(seen.displacement))
    if kinematics is None and args.postures:
        _require_degrees(seen, noise, rectified, UNITS_DEG)
    if kinematics is None:
        option = "--postures" if args.postures else "--calibration"
        wanted = "turn each joint alone between two of them, by 10° to 30°, and show more postures"
        wanted += "; if these are radians, write degrees" if in_radians else ""
        raise BadInput(f"{option}: {len(seen.displacement)} postures do not show how the joints move points: {wanted}")
    gains = _gains(kinematics, seen, noise) if args.postures else None
    return OwnBody(own, seen, kinematics, shortfall, noise, unit_px, lower, upper, gains)


def _require_degrees(
    seen: Observations, noise: float, rectified: Rectification | None, units_deg: dict[str, float]
) -> None:
    """Raise BadInput for joint angles of which the images tell that they are in one of these units."""
    for unit, degrees in units_deg.items():
        scaled = replace(seen, displacement=seen.displacement * degrees)
        kinematics = fit_kinematics(scaled, noise, rectified)
        if kinematics is not None and (rates := kinematics.rates).min() > 0:
            if np.abs(np.log(degrees * rates)).max() < SAME_UNIT:
                return
            if np.abs(np.log(rates)).max() < SAME_UNIT:
                raise BadInput(f"--postures: these look like {unit}, not degrees: multiply them by {degrees:.5g}")
            raise BadInput(f"--postures: these are no degrees: {gain_words(degrees * rates)}; write degrees")


def _gains(kinematics: ProjectiveKinematics, seen: Observations, noise: float) -> NDArray[np.float64] | None:
    """By how many degrees each joint turns for a unit of the table, (m,); None if the images agree to degrees."""
    rates, m = kinematics.rates, seen.displacement.shape[1]
    twists = kinematics.parameters[-6 * m :].reshape(m, 6)[:, :3]
    cov = KinematicsCovariance.estimate(kinematics, seen).sqrt_cov[-6 * m :].reshape(m, 6, -1)[:, :3]
    along = twists / np.maximum(rates, 1e-9)[:, None]
    std = noise * np.linalg.norm(np.einsum("mk,mkp->mp", along, cov), axis=1)
    differs = np.abs(rates - 1) > np.maximum(MIN_GAIN_CHANGE, GAIN_SIGMA * std)
    return rates if differs.any() else None


def gain_words(gains: NDArray[np.float64]) -> str:
    """Say by how much the joints turn for a unit."""
    turns = ", ".join(f"joint {k} by {gain:.3g}°" for k, gain in enumerate(gains, 1))
    return f"the images show that one unit turns {turns}"


def find_misfit(body: OwnBody, frames: Sequence[int], views: FourViews) -> tuple[Misfit, int] | None:
    """Find out why the demonstrator is no body like the own one, or the own arm not where it was sent.

    Parameters
    ----------
    body : OwnBody
    frames : sequence of int
        T numbers.
    views : FourViews
        T frames of its points, (T, N, …).

    Returns
    -------
    misfit, frame
        The reason in px, and the number of the frame with the most points of the demonstrator, which shows it; None if
        there is no sign of one.
    """
    shown = np.asarray(views.visible[..., :2].all(-1))
    demos = np.where(shown[..., None], views.demo / body.unit_px, np.nan)
    at = int(shown.sum(-1).argmax())
    demo = demos[at]
    if shown[at].sum() < MIN_POINTS:
        return None
    visits, last = body.visits, body.visits[-1]
    observation = Observation(
        own=last.own,
        seen=last.seen,
        E=np.nan,
        displacement=last.displacement,
        lower=body.lower,
        upper=body.upper,
        motion=0,
        noise_px=body.noise_px,
        rectification=body.kinematics.rectification,
        demo=demo,
    )
    theta = nearest_posture(demo, body.model, body.lower, body.upper)
    explanation = explain(body.kinematics, visits, observation, theta, DEFAULTS)
    if explanation is not None:
        if swaps := mixed_up(demo, body.model, body.lower, body.upper):
            return Misfit(MisfitKind.MIXED_UP, tuple(sorted({k for pair in swaps for k in pair}))), frames[at]
        if explanation.misfit.kind is MisfitKind.ANOTHER_BODY:
            explanation = _explained_together(body, demos) or explanation
        return explanation.misfit.per_pixel(body.unit_px), frames[at]
    return None if body.shortfall is None else (Misfit(MisfitKind.ARM, amount=body.shortfall.share), frames[at])


def _explained_together(body: OwnBody, demos: NDArray[np.float64]) -> Explanation | None:
    """Find out how the demonstrator's body differs from several of the frames with the most points, (T, N, 4) px."""
    counts = np.isfinite(demos).all(-1).sum(-1)
    most = np.flatnonzero(counts == counts.max())
    some = np.unique(demos[most[np.linspace(0, len(most) - 1, N_TOGETHER).round().astype(int)]], axis=0)
    postures = np.array([nearest_posture(demo, body.model, body.lower, body.upper) for demo in some])
    return explain_again(body.kinematics, body.visits, some, postures, body.noise_px, DEFAULTS)


def misfit_of(body: OwnBody, frames: Sequence[int], points: Sequence[str], views: FourViews) -> dict | None:
    """The misfit as JSON, with names of points and the frame that shows it. Parameters as of `find_misfit`."""
    found = find_misfit(body, frames, views)
    if found is None:
        return None
    said = misfit_json(found[0], range(1, 1 + len(body.lower)), points)
    assert said is not None
    return said | {"frame": found[1]}


def named(
    body: OwnBody, frames: Sequence[int], points: Sequence[str], views: FourViews
) -> tuple[FourViews, tuple[str, ...], dict]:
    """Put the demonstrator's points in the order of the learner's own.

    Parameters
    ----------
    body : OwnBody
    frames : sequence of int
        T numbers.
    points : sequence of str
        P names, of both bodies.
    views : FourViews
        T frames, (T, P, …).

    Returns
    -------
    views : FourViews
        T frames of the learner's N points, (T, N, …); without any of the demonstrator's if no naming explains them.
    points : tuple of str
        Names of these points.
    naming : dict
        What was found, as JSON.
    """
    views, unit_px = replace(views, matched=False), body.unit_px
    shown = np.asarray(views.visible[..., :2].all(-1))
    found: Naming | None = None
    used = 0
    for frame in np.argsort(-shown.sum(-1), kind="stable")[:N_FRAMES].tolist():
        demo = np.where(shown[frame, :, None], views.demo[frame] / unit_px, np.nan)
        tried = find_naming(demo, body.model, body.lower, body.upper)
        if tried is not None and (found is None or tried.accepted):
            found, used = tried, frame
        if found is not None and found.accepted:
            break
    names = tuple(points[k] for k in body.points.tolist())
    unit = "posture_deg" if body.gains is None else "posture"
    rows = found.names if found is not None and found.accepted else np.full(len(body.points), -1)
    demo = np.where((rows >= 0)[:, None], views.demo[:, rows], np.nan)
    ordered = FourViews(demo, views.own[:, body.points], _visible(views, rows, body.points))
    return ordered, names, _json(found, frames[used], names, points, unit_px, unit)


def _visible(views: FourViews, rows: NDArray[np.int_], own: NDArray[np.int_]) -> NDArray[np.bool_]:
    """(T, N, 4), of the demonstrator's points in their new order and of the own points."""
    demo = np.where((rows >= 0)[:, None], views.visible[:, rows, :2], False)
    return np.concatenate([demo, views.visible[:, own, 2:]], -1)


def _with_postures(path: Path, frames: Sequence[int], views: FourViews, own: NDArray[np.int_]) -> Observations:
    """The own images of the frames whose joint angles a table has. Raises OSError or ValueError."""
    table, heading, angles = Table(path), None, dict[int, list[float]]()
    for line, cells in table.lines():
        if heading is None:
            heading = column_names(cells)
            if heading[:1] != ["frame"] or len(heading) < 2:
                raise ValueError(f"{path}: the heading must be frame, and a column for each joint")
            continue
        cells = table.filled(line, cells, len(heading))
        values = [table.number(line, name, text, np.nan) for name, text in zip(heading[1:], cells[1:])]
        angles[table.whole(line, "frame", cells[0])] = values
    at = [k for k, frame in enumerate(frames) if np.isfinite(angles.get(frame, [np.nan])).all()]
    if len(at) < MIN_POSTURES:
        raise ValueError(f"{path}: it has the joint angles of {len(at)} frames; needs {MIN_POSTURES} or more")
    visible = np.asarray(views.visible[at][:, own, 2:].all(-1))
    return Observations(np.radians([angles[frames[k]] for k in at]), views.own[at][:, own], visible)


def _of_calibration(calibration: SelfCalibration, n_own: int) -> Observations:
    """The own images of a calibration. Raises ValueError for another number of points than the tracks have."""
    count = len(calibration.visits[0].own)
    if count != n_own:
        raise ValueError(
            f"it has {count} points of the learner, the tracks have {n_own}: they must be the same, in order"
        )
    return Observations(
        np.array([visit.displacement for visit in calibration.visits]),
        np.array([visit.own for visit in calibration.visits]),
        np.array([visit.seen.all(-1) for visit in calibration.visits]),
    )


def _json(
    found: Naming | None, frame: int, names: Sequence[str], points: Sequence[str], unit_px: float, unit: str
) -> dict:
    """What was found, with names of points instead of indices and in pixels. unit: the name of the joint angles."""
    if found is None:
        return {"accepted": False, "frame": None}
    said = naming_json(found.per_pixel(unit_px))
    assert said is not None
    partner = [None if row < 0 or not found.accepted else points[row] for row in found.names]
    return said | {
        "frame": frame,
        unit: np.degrees(found.displacement),
        "names": dict(zip(names, partner)),
        "probability": dict(zip(names, found.probability)),
        "certain": dict(zip(names, found.certain)),
        "without_partner": {
            "learner": [name for name, row in zip(names, found.names) if row < 0],
            "demonstrator": [points[row] for row in found.unnamed],
        },
    }
