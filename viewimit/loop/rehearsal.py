"""A rehearsal: a session visits postures without a demonstrator and records its own body; then it imitates."""

import numpy as np
from numpy.typing import NDArray

from ..servo.observation import Visit
from ..servo.status import ServoStatus
from .embodiment import Embodiment, require_in_workspace
from .self_calibration import MIN_POSTURES, SelfCalibration, calibration_postures
from .snapshot import Limits, Snapshot


def draw_postures(
    now: Snapshot, workspace: Limits, count: int, seed: int, within_deg: float | None
) -> NDArray[np.float64]:
    """Draw postures, (count, m) rad, from the workspace, or from the part of it near where the arm is."""
    low, high = workspace
    if within_deg is not None:
        reach = np.radians(within_deg)
        low, high = np.maximum(low, now.commanded - reach), np.minimum(high, now.commanded + reach)
    return calibration_postures(low, high, count, np.random.default_rng(seed))


def begin(
    now: Snapshot, embodiment: Embodiment, workspace: Limits, noise_px: float, postures: NDArray[np.float64]
) -> Snapshot:
    """Prepare to visit these postures, (K, m) rad. Raises ValueError for impossible ones."""
    if len(postures) < MIN_POSTURES:
        raise ValueError(f"needs {MIN_POSTURES} postures or more, got {len(postures)}")
    possible = [embodiment.require_posture(theta, "the rehearsed") for theta in postures]
    pending = np.array([require_in_workspace(theta, *workspace, "the rehearsed") for theta in possible])
    calibration = SelfCalibration(embodiment.body(now.settings), now.settings.scene_title, noise_px)
    return prepared(now, ServoStatus.REHEARSING, calibration, pending)


def record(after: Snapshot, lower: NDArray[np.float64]) -> Snapshot:
    """Record the images after a motion of a rehearsal, if the arm has arrived. lower: (m,) rad, the arm's limits."""
    assert after.pending_postures is not None and after.calibration is not None
    pending, calibration = after.pending_postures, after.calibration
    if after.target is None:
        visit = Visit.of(after.commanded - lower, after.views.own, after.views.visible[:, 2:])
        pending, calibration = pending[1:], calibration.with_visit(visit)
    status = ServoStatus.REHEARSING if len(pending) else after.awake_status
    return after.with_fields(calibration=calibration, pending_postures=pending, status=status)


def prepared(
    now: Snapshot,
    status: ServoStatus,
    calibration: SelfCalibration | None,
    pending: NDArray[np.float64] | None = None,
) -> Snapshot:
    """Let the servo start again with a calibration, of which postures, (K, m) rad, may be pending."""
    return now.with_fields(
        status=status, calibration=calibration, pending_postures=pending, servo_state=None, target=None
    )
