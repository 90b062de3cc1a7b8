"""Golden runs: seeded runs as data, how one is played, and what is recorded of it.

A run is a row of RUNS: changes of `Settings`, and what is done with the session. A renamed setting or method of the
library changes this file only. `record.py` records the runs anew.

Rounding differs between processors, and a run can make it grow: where E is least but not 0, its minimum is found to
1e-8 rad, and a decision by the least of it can fall the other way. So a run is compared to 1e-9 where arithmetic is the
same as where it was recorded, to the last bit, and elsewhere to what rounding errors can come to.
"""

import hashlib
import math
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from own_arm import OwnArm

from viewimit import Session, Settings
from viewimit.servo import ServoStatus

RECORDING = Path(__file__).with_name("runs.npz")
CLOSE = 1e-9  # rad, and of E, where arithmetic is the same
E_PER_RAD = 30.0  # how much more E may differ elsewhere than postures may, of its value or px² if that is below 1


@dataclass(frozen=True)
class Run:
    """One golden run.

    settings: changes of `Settings()`, which is the default method; arm: options of `OwnArm`, if the session has an arm
    and eyes of its own, else None; shown_deg: (motion, posture) each, where the demonstrator goes once that many
    motions were made, or the servo rests before; rehearsed_deg: postures to go through first; most: motions at most;
    elsewhere: rad, how far postures may differ where arithmetic differs, ten times what was measured there or more;
    why: that is more than usual, or the run ends early.
    """

    name: str
    settings: Mapping[str, Any]
    arm: Mapping[str, Any] | None = None
    shown_deg: tuple[tuple[int, tuple[float, ...]], ...] = ()
    rehearsed_deg: tuple[tuple[float, ...], ...] = ()
    most: int = 60
    elsewhere: float = 1e-5
    why: str = ""


@dataclass(frozen=True)
class Trace:
    """What is kept of a run of K motions of m joints: commanded (K + 1, m) rad, where the arm was sent; status
    (K + 1,); E (K + 1,) px², NaN with too few points; expected_error: rad, at the end, NaN if the servo gives none."""

    commanded: NDArray
    status: NDArray
    E: NDArray
    expected_error: float


@dataclass(frozen=True)
class Difference:
    """Of two traces. said: the first status or the number of motions that differs, "" if none does; posture: rad; E: of
    its value, px² where that is below 1; expected_error: rad. The largest each, over the motions that both have."""

    said: str
    posture: float
    E: float
    expected_error: float

    def within(self, posture: float, E: float) -> bool:
        """Whether it is no more than that."""
        return not self.said and max(self.posture, self.expected_error) <= posture and self.E <= E

    def __str__(self) -> str:
        amounts = f"postures {self.posture:.1e} rad, E {self.E:.1e}, expected error {self.expected_error:.1e} rad"
        return f"{self.said}; {amounts}" if self.said else amounts


def play(run: Run, moved_deg: float = 0.0) -> Trace:
    """Play a run. moved_deg: by which its start is moved, to see how much that changes."""
    session, show = _begun(run, moved_deg)
    if run.rehearsed_deg:
        session.begin_calibration(np.radians(run.rehearsed_deg))
    for motion, posture_deg in run.shown_deg:
        session.run(motion)
        show(np.radians(posture_deg))
    session.run(run.most)
    moments = list(session.history)
    expected = moments[-1].expected_error
    return Trace(
        np.array([moment.commanded for moment in moments]),
        np.array([str(moment.status) for moment in moments]),
        np.array([moment.E for moment in moments]),
        np.nan if expected is None else float(expected),
    )


def _begun(run: Run, moved_deg: float) -> tuple[Session, Callable[[NDArray], object]]:
    """The session at its start, and the function that sends the demonstrator to a posture, rad."""
    if run.arm is None:
        session = Session(Settings(**run.settings))
        if moved_deg:
            start_deg = np.degrees(session.snapshot.commanded) + moved_deg
            session = Session(Settings(**{**run.settings, "start_deg": tuple(start_deg)}))
        return session, session.pose
    arm = OwnArm(**run.arm)
    session = Session.of(arm, arm, start_deg=tuple(np.degrees(arm.start) + moved_deg), **run.settings)

    def show(theta: NDArray) -> None:
        arm.demonstrator = theta
        session.look()

    return session, show


def difference(new: Trace, old: Trace) -> Difference:
    """How a run differs from the recorded one."""
    both = min(len(new.E), len(old.E))
    other = np.flatnonzero(new.status[:both] != old.status[:both])
    if len(other):
        said = f"motion {other[0]} is {new.status[other[0]]}, was {old.status[other[0]]}"
    elif len(new.E) != len(old.E):
        said = f"{len(new.E) - 1} motions, were {len(old.E) - 1}"
    else:
        said = ""
    E, E_old = new.E[:both], old.E[:both]
    return Difference(
        said,
        _most(new.commanded[:both], old.commanded[:both]),
        _most(E, E_old, np.fmax(1.0, np.abs(E_old))),
        _most(np.array(new.expected_error), np.array(old.expected_error)),
    )


def _most(new: NDArray, old: NDArray, unit: NDArray | float = 1.0) -> float:
    """The largest difference, in units; inf where only one of both is a finite number."""
    same = (new == old) | (np.isnan(new) & np.isnan(old))
    with np.errstate(invalid="ignore"):
        away = np.where(same, 0.0, np.abs(new - old) / unit)
    return float(np.max(np.where(np.isnan(away), np.inf, away), initial=0.0))


def arithmetic() -> str:
    """What this machine makes of some sums: another text wherever they are rounded otherwise."""
    digest = hashlib.sha256(" ".join([np.__version__, platform.machine(), *platform.libc_ver()]).encode())
    rng = np.random.default_rng(0)
    for n, m in ((2, 2), (2, 3), (4, 10), (7, 24), (10, 40), (40, 64)):
        A, b = rng.standard_normal((n, m)), rng.standard_normal(n)
        S = A @ A.T + np.eye(n)
        made = [S, A.T @ A, A.T @ b, np.einsum("ij,kj->ik", A, A), A.sum(), A.mean(0), np.linalg.norm(A), np.sin(A)]
        made += [np.cos(A), np.arctan2(A, 2.0), np.exp(A), np.log(np.abs(A)), np.hypot(A, 1.0), np.abs(A) ** 1.5]
        made += [*np.linalg.svd(A, full_matrices=False), *np.linalg.eigh(S), *np.linalg.qr(A.T), np.linalg.inv(S)]
        made += [np.linalg.solve(S, b), np.linalg.lstsq(A.T, A[0], rcond=None)[0], np.linalg.pinv(A)]
        made += [np.linalg.cholesky(S), np.linalg.det(S)]
        made += [np.array([math.sin(x), math.exp(x), math.atan2(x, 2.0), math.erf(x)]) for x in A[0]]
        for result in made:
            digest.update(np.ascontiguousarray(result).tobytes())
    return digest.hexdigest()


def write(traces: Mapping[str, Trace], path: Path = RECORDING) -> None:
    """All runs in one compressed file, with the arithmetic by which they were made. Same traces, same bytes."""
    every = list(traces.values())
    np.savez_compressed(
        path,
        arithmetic=np.array(arithmetic()),
        name=np.array(list(traces)),
        moments=np.array([len(trace.E) for trace in every]),
        joints=np.array([trace.commanded.shape[1] for trace in every]),
        commanded=np.concatenate([trace.commanded.ravel() for trace in every]),
        status=np.concatenate([trace.status for trace in every]),
        E=np.concatenate([trace.E for trace in every]),
        expected_error=np.array([trace.expected_error for trace in every]),
    )


def read(path: Path = RECORDING) -> tuple[dict[str, Trace], bool]:
    """Every recorded run by its name, and whether arithmetic was the same as it is here."""
    with np.load(path) as kept:
        moments, joints = kept["moments"], kept["joints"]
        ends = np.cumsum(moments)[:-1]
        commanded = np.split(kept["commanded"], np.cumsum(moments * joints)[:-1])
        rows = zip(commanded, joints, np.split(kept["status"], ends), np.split(kept["E"], ends), kept["expected_error"])
        traces = [Trace(one.reshape(-1, m), _today(status), E, float(expected)) for one, m, status, E, expected in rows]
        return dict(zip(kept["name"].tolist(), traces)), str(kept["arithmetic"]) == arithmetic()


def _today(words: NDArray) -> NDArray:
    """Statuses in today's words, of recorded ones."""
    return np.array([str(ServoStatus(word)) for word in words.tolist()])


SEVEN = {
    "joints": (1, 2, 3, 4, 5, 6, 7),
    "points": 16,
    "demonstrator_deg": (10, 40, -10, -80, 15, 100, 30),
    "start_deg": (-10, 25, 10, -50, -15, 75, 60),
}
TWO_REHEARSED = tuple((first, second) for first in (5.0, 35.0, 65.0) for second in (-150.0, -105.0, -60.0, -15.0))
FAR = """extends = "panda"
[head]
gaze_demonstrator = [6.0, 0.69, 1.015]
[demonstrator]
position = [5.9, 0.7, 0.4]
"""
DISTORTED = """extends = "panda"
[head]
undistort = [-0.09, 0.0]
[head.left]
distortion = [-0.1, 0.01]
[head.right]
distortion = [-0.1, 0.01]
"""
NEAR = {"start_deg": (25, -45)}
OWN = {"demonstrator_deg": (30, -45, 80)}
FLAT = "E is flat about its least, so that rounding errors move the end farther"
ROUND = tuple((8 + k, (45 + 2.0 * k, -90 + 3.0 * k)) for k in range(12))  # a motion of the demonstrator for each motion


def _own(name: str, arm: Mapping[str, Any] | None = None, **settings: Any) -> Run:
    return Run(name, settings, OWN | (arm or {}))


def _paper(servo: str, transfer: str, **settings: Any) -> Mapping[str, Any]:
    return {"servo": servo, "transfer": transfer, "frames": 1, **settings}


RUNS = (
    # The default method from several starts, with noise
    Run("default", {}),
    Run("noise 0.5 px, 25 frames", {"noise_px": 0.5, "seed": 3}),
    # What spoils images and motions
    Run("missing 40 %, 1 frame: points half seen", {"points": 16, "missing": 0.4, "frames": 1, "seed": 2}),
    Run("outliers 5 %, noise", {"points": 16, "outliers": 0.05, "noise_px": 0.25, "frames": 1, "seed": 7}),
    Run("swapped pairs, noise", {"points": 16, "swapped": 0.25, "noise_px": 0.25, "seed": 9}),
    Run("steps of 0.5°", {"encoder_step_deg": 0.5, "noise_px": 0.1}, elsewhere=3e-5, why=FLAT),
    # Scenes
    Run("toed-in, noise", {"scene": "panda-toed", "noise_px": 0.25, **NEAR}),
    Run(
        "forearm only",
        {"scene": "panda-forearm"},
        elsewhere=1e-3,
        why="the points tell nothing of the first joint: E is the same wherever that is, and rounding errors move it",
    ),
    Run("far demonstrator", {"scene": FAR, "noise_px": 0.1}),
    Run("distorted lenses", {"scene": DISTORTED}),
    Run("seven joints, noise", SEVEN | {"noise_px": 0.25}),
    # Transfers and servos
    Run("rank 3, likelihood", {"transfer": "rank3", "noise_px": 0.1}, elsewhere=3e-5, why=FLAT),
    Run("epipolar, gradient", _paper("gradient", "epipolar", start_deg=(30, -60))),
    Run("linear, Broyden, noise, seen in part", _paper("broyden", "linear", noise_px=0.3, missing=0.1, seed=3)),
    Run("rank 3, Kalman, noise", _paper("kalman", "rank3", noise_px=0.25)),
    Run("projective, Gauss-Newton, noise", _paper("gauss-newton", "projective", noise_px=0.25)),
    # Limits, a demonstrator that moves, and a rehearsed body
    Run("demonstrator keeps moving", {"noise_px": 0.1}, shown_deg=ROUND),
    Run("rehearsed", {"noise_px": 0.1}, rehearsed_deg=TWO_REHEARSED),
    # Arms and eyes of one's own
    _own("own arm, whole pixels", {"grid_px": 1.0, "offset_deg": 0.5}, frames=1),
    _own(
        "own arm, half-seen points, late, workspace",
        {"noise_added_px": 0.1, "half_seen": 0.6, "late": 1},
        workspace_deg=((-50, 50), (-60, 10), (20, 100)),
    ),
)
