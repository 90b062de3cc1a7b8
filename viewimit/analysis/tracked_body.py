"""The learner's own body, learned from its pictures at known joint angles: it names points, and says why two differ.

Kinematics that explain these pictures predict how the own body would look in the demonstrator's posture. So points
that come without names are named, and it says why the demonstrator's body differs from its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS, image_unit
from ..geometry.arrays import Floats
from ..geometry.kinematics.adjustment import KinematicsCovariance
from ..geometry.kinematics.clusters import Observations
from ..geometry.kinematics.disturbed import Shortfall, fit_shortfall
from ..geometry.kinematics.model import ProjectiveKinematics
from ..geometry.kinematics.own_body import exact_body
from ..geometry.rectification import Rectification
from ..loop.self_calibration import MIN_POSTURES, SelfCalibration
from ..sensing.tracks.text import Table, column_names
from ..servo import Misfit, MisfitKind, Naming, Observation
from ..servo.estimator.naming import KnownBody, find_naming, mixed_up, nearest_posture
from ..servo.estimator.reasons import Explanation, explain, explain_again

UNITS_DEG = {"radians": float(np.degrees(1)), "turns": 360.0, "steps of 4096 a turn": 360 / 4096, "tenths": 0.1}
SAME_UNIT = 0.15  # of the logarithm of a joint's turn for a unit
MIN_GAIN_CHANGE, GAIN_SIGMA = 0.1, 4.0  # of a joint's turn for a degree; in standard errors
N_TOGETHER = 5  # frames that show how a demonstrator's body differs, at most
N_FRAMES = 5  # with the most points of the demonstrator, in which a naming is tried


@dataclass(frozen=True)
class TrackedBody:
    """The learner's own body, in image units."""

    points: NDArray[np.int_]  # (N,): its points, among those tracked
    seen: Observations  # in K postures
    kinematics: ProjectiveKinematics  # that explain these images
    shortfall: Shortfall | None  # of an arm that was not where the table says
    noise_px: float
    unit_px: float  # pixels of one unit
    lower: Floats  # (m,) rad, between which the demonstrator's posture is looked for
    upper: Floats
    gains: Floats | None = None  # (m,) degrees that each joint turns for a unit of the table, if no degree

    @property
    def model(self) -> KnownBody:
        """Predicts its images."""
        return KnownBody(self.kinematics, self.seen, self.noise_px)


@dataclass(frozen=True)
class NamedPoints:
    """The demonstrator's points in the order of the learner's own."""

    views: FourViews  # T frames of the learner's N points, px; without any of the demonstrator's if no naming fits them
    naming: Naming | None  # the best one that was found, in px; None if none was
    frame: int  # index of the frame in which it was found


def learn_tracked_body(
    seen: Observations,
    points: NDArray[np.int_],
    limits: tuple[Floats, Floats],
    noise_px: float,
    rectification: Rectification | None = None,
    of_table: bool = True,
) -> TrackedBody:
    """Learn the own body from its images at known joint angles.

    Parameters
    ----------
    seen : Observations
        K looks: displacements in rad, images in px.
    points : (N,) array of int
        Its points, among those tracked.
    limits : two (m,) arrays
        Between which the demonstrator's posture is looked for [rad].
    noise_px : float
        Standard deviation of an image coordinate.
    rectification : Rectification, optional
        Of images in px.
    of_table : bool, optional
        Whether the angles come from a table, whose units the images can contradict.

    Returns
    -------
    TrackedBody

    Raises
    ------
    ValueError
        For angles in another unit, which it names, and for postures that do not show how the joints move points.
    """
    unit_px = image_unit(seen.images[seen.visible_in_both])
    seen, noise = replace(seen, images=seen.images / unit_px), noise_px / unit_px
    rectified = None if rectification is None else rectification.in_units(unit_px)
    # as large as a table of radians would be if it were read as degrees
    in_radians = of_table and np.abs(seen.displacement).max() <= np.radians(2 * np.pi)
    if in_radians:
        _require_degrees(seen, noise, rectified, {"radians": UNITS_DEG["radians"]})
    body, shortfall = exact_body(seen, noise, rectified), None
    kinematics = None if body is None else body.kinematics
    if kinematics is None and (found := fit_shortfall(seen, noise, rectified)) is not None:
        kinematics, shortfall = found
        seen = replace(seen, displacement=shortfall.reached(seen.displacement))
    if kinematics is None and of_table:
        _require_degrees(seen, noise, rectified, UNITS_DEG)
    if kinematics is None:
        wanted = "turn each joint alone between two of them, by 10° to 30°, and show more poses"
        wanted += "; if these are radians, write degrees" if in_radians else ""
        without = lambda k: replace(seen, displacement=np.delete(seen.displacement, k, 1))
        m = seen.displacement.shape[1]
        joints = range(m) if of_table and m > 1 else ()
        idle = next((k for k in joints if exact_body(without(k), noise, rectified)), None)
        wanted = wanted if idle is None else f"joint {idle + 1} turns no point: leave its column out"
        raise ValueError(f"{len(seen.displacement)} poses do not show how the joints move points: {wanted}")
    gains = _gains(kinematics, seen, noise) if of_table else None
    return TrackedBody(points, seen, kinematics, shortfall, noise, unit_px, *limits, gains)


def _require_degrees(
    seen: Observations, noise: float, rectified: Rectification | None, units_deg: Mapping[str, float]
) -> None:
    """Raise ValueError for joint angles of which the images tell that they are in one of these units."""
    for unit, degrees in units_deg.items():
        scaled = replace(seen, displacement=seen.displacement * degrees)
        body = exact_body(scaled, noise, rectified)
        if body is not None and (rates := body.kinematics.rates).min() > 0:
            if np.abs(np.log(degrees * rates)).max() < SAME_UNIT:
                return
            if np.abs(np.log(rates)).max() < SAME_UNIT:
                raise ValueError(f"these look like {unit}, not degrees: multiply them by {degrees:.5g}")
            raise ValueError(f"these are not degrees: {gain_words(degrees * rates)}; write degrees")


def _gains(kinematics: ProjectiveKinematics, seen: Observations, noise: float) -> Floats | None:
    """By how many degrees each joint turns for a unit of the table, (m,); None if the images agree to degrees."""
    rates, m = kinematics.rates, seen.displacement.shape[1]
    twists = kinematics.parameters[-6 * m :].reshape(m, 6)[:, :3]
    cov = KinematicsCovariance.estimate(kinematics, seen).sqrt_cov[-6 * m :].reshape(m, 6, -1)[:, :3]
    along = twists / np.maximum(rates, 1e-9)[:, None]
    std = noise * np.linalg.norm(np.einsum("mk,mkp->mp", along, cov), axis=1)
    differs = np.abs(rates - 1) > np.maximum(MIN_GAIN_CHANGE, GAIN_SIGMA * std)
    return rates if differs.any() else None


def gain_words(gains: Floats) -> str:
    """Say by how much the joints turn for a unit."""
    turns = ", ".join(f"joint {k} by {gain:.3g}°" for k, gain in enumerate(gains, 1))
    return f"the pictures show that one unit turns {turns}"


def find_misfit(body: TrackedBody, views: FourViews) -> tuple[Misfit, int] | None:
    """Find out why the demonstrator is no body like the own one, or the own arm not where it was sent.

    Parameters
    ----------
    body : TrackedBody
    views : FourViews
        T frames of its points, (T, N, …) px.

    Returns
    -------
    misfit, frame
        The reason in px, and the index of the frame with the most points of the demonstrator, which shows it; None if
        there is no sign of one.
    """
    shown = np.asarray(views.visible[..., :2].all(-1))
    demos = np.where(shown[..., None], views.demo / body.unit_px, np.nan)
    at = int(shown.sum(-1).argmax())
    demo = demos[at]
    if shown[at].sum() < MIN_POINTS:
        return None
    observation = Observation(
        own=body.seen.images[-1],
        seen=np.repeat(body.seen.visible_in_both[-1, :, None], 2, -1),
        E=np.nan,
        displacement=body.seen.displacement[-1],
        lower=body.lower,
        upper=body.upper,
        motion=0,
        noise_px=body.noise_px,
        rectification=body.kinematics.rectification,
        demo=demo,
    )
    theta = nearest_posture(demo, body.model, body.lower, body.upper)
    explanation = explain(body.kinematics, body.seen, observation, theta)
    if explanation is not None:
        if swaps := mixed_up(demo, body.model, body.lower, body.upper):
            return Misfit(MisfitKind.MIXED_UP, tuple(sorted({k for pair in swaps for k in pair}))), at
        if explanation.misfit.kind is MisfitKind.ANOTHER_BODY:
            explanation = _explained_together(body, demos) or explanation
        return explanation.misfit.per_pixel(body.unit_px), at
    return None if body.shortfall is None else (Misfit(MisfitKind.ARM, amount=body.shortfall.share), at)


def _explained_together(body: TrackedBody, demos: Floats) -> Explanation | None:
    """Find out how the demonstrator's body differs from several of the frames with the most points, (T, N, 4) px."""
    counts = np.isfinite(demos).all(-1).sum(-1)
    most = np.flatnonzero(counts == counts.max())
    some = np.unique(demos[most[np.linspace(0, len(most) - 1, N_TOGETHER).round().astype(int)]], axis=0)
    postures = np.array([nearest_posture(demo, body.model, body.lower, body.upper) for demo in some])
    return explain_again(body.kinematics, body.seen, some, postures, body.noise_px)


def name_points(body: TrackedBody, views: FourViews) -> NamedPoints:
    """Find out which of the demonstrator's points is which of the learner's. views: T frames of P points, (T, P, …)."""
    views = replace(views, matched=False)
    shown = np.asarray(views.visible[..., :2].all(-1))
    found: Naming | None = None
    used = 0
    for frame in np.argsort(-shown.sum(-1), kind="stable")[:N_FRAMES].tolist():
        demo = np.where(shown[frame, :, None], views.demo[frame] / body.unit_px, np.nan)
        tried = find_naming(demo, body.model, body.lower, body.upper)
        if tried is not None and (found is None or tried.accepted):
            found, used = tried, frame
        if found is not None and found.accepted:
            break
    names = np.full(views.own.shape[1], -1)
    if found is not None and found.accepted:
        names[body.points] = found.names
    ordered = views.named(names).select(body.points)
    return NamedPoints(ordered, None if found is None else found.per_pixel(body.unit_px), used)


# What shows the own body: a table of its joint angles beside the tracks, or a calibration.


def observed_in_postures(path: Path, frames: Sequence[int], views: FourViews, own: NDArray[np.int_]) -> Observations:
    """Return the own images of the frames whose joint angles a table has. Raises OSError or ValueError."""
    table, heading, angles = Table(path), None, dict[int, list[float]]()
    for line, cells in table.lines():
        if heading is None:
            heading = column_names(cells)
            if heading[:1] != ["frame"] or len(heading) < 2:
                raise ValueError(f"{path}: the heading must be frame, and a column for each joint")
            continue
        cells = table.filled(line, cells, len(heading))
        values = [table.number(line, name, text, np.nan) for name, text in zip(heading[1:], cells[1:])]
        frame = table.whole(line, "frame", cells[0])
        if angles.setdefault(frame, values) is not values:
            raise ValueError(f"{path}: line {line}: frame {frame} stands in an earlier line too")
    at = [k for k, frame in enumerate(frames) if np.isfinite(angles.get(frame, [np.nan])).all()]
    if len(at) < MIN_POSTURES:
        raise ValueError(f"{path}: it has the joint angles of {len(at)} frames; needs {MIN_POSTURES} or more")
    there = np.radians([angles[frames[k]] for k in at])
    still = [name for name, span in zip((heading or [])[1:], np.ptp(there, axis=0)) if span == 0]
    if still:
        raise ValueError(
            f"{path}: {', '.join(still)}: the same in all frames: turn each joint, or leave its column out"
        )
    return Observations(there, views.own[at][:, own], np.asarray(views.visible[at][:, own, 2:].all(-1)))


def observed_in_calibration(calibration: SelfCalibration, n_own: int) -> Observations:
    """Return the own images of a calibration. Raises ValueError for another number of points than the tracks have."""
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
