"""Tracks of stereo rigs: whether `evaluate` rectifies them, and how well transfers predict other points.

    python studies/tracks.py

A rig as of the KITTI data set (Geiger et al. 2012), with 0.54 m between cameras of 1241 x 376 px, sees a rigid scene,
moves, and sees it again: [l r] and [L R]. Its rectification leaves the errors of KITTI's public pairs: a keystone in
the right image's rows. A fundamental matrix fits it well, and yet its rectification makes predictions worse.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.leave_one_out import leave_one_out
from viewimit.estimation.outliers import find_outliers, select_matches
from viewimit.estimation.rectification import fit_transfer
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews
from viewimit.experiments.bench.engine import chosen
from viewimit.experiments.bench.intervals import Share
from viewimit.experiments.executors import Study
from viewimit.geometry.rectification import Rectification, fit_rectification
from viewimit.geometry.rigid import rigid_transform, rotation_about_axis
from viewimit.simulation.camera import Camera, Cameras, Lens

WIDTH, HEIGHT, FOCAL_PX, BASELINE_M = 1241, 376, 718.0, 0.54
NEAR_M, FAR_M = 5.0, 60.0  # depths of points, uniform
FORWARD_M, TURN_DEG = (0.5, 1.5), (0.3, 1.0, 0.3)  # motion of the rig; standard deviations about x, y, z
RESIDUAL_DEG = 0.02  # standard deviation of each camera's rotation error about each axis
KEYSTONE_PX = 1.6  # in the corners, of rectified pairs
NOISE_PX, T_DEGREES_OF_FREEDOM = (0.2, 0.5), 4  # standard deviation of a coordinate; of Student's t distribution
BOARD, SQUARE_M, BOARD_M, TILT_DEG = (9, 6), 0.15, (2.5, 4.0), 30.0  # corners of a chessboard; its distance and tilt
BOARD_FRAMES = 5
TEST_POINTS = 200  # that are held out


@dataclass(frozen=True)
class Case:
    """A rig and the points that it tracks."""

    points: int
    toe_in_deg: float = 0.0  # angle between the optical axes
    board: bool = False  # a chessboard, moved between BOARD_FRAMES frames, instead of a scene with one frame

    @property
    def name(self) -> str:
        kind = f"toed in by {self.toe_in_deg:g}°" if self.toe_in_deg else "rectified"
        return f"{kind}{', chessboard' if self.board else ''}, {self.points} points"


CASES = (
    *(Case(points) for points in (12, 20, 40)),
    Case(20, board=True),
    *(Case(points, toe_in_deg) for toe_in_deg in (2.0, 5.0, 20.0) for points in (12, 20, 40)),
    Case(20, 10.0, board=True),
)


@dataclass(frozen=True)
class Run:
    """One draw. Errors are px rms of held-out points without noise, by transfer."""

    rectified: bool  # whether `evaluate` rectifies
    asked: bool  # whether the matches alone would ask for it
    error_px: dict[str, float]  # as `evaluate` leaves the images
    raw_px: dict[str, float]  # of the images as they are
    always_px: dict[str, float]  # rectified if the matches ask for it


@dataclass(frozen=True)
class Outcome:
    """The draws of one case: shares, and medians of errors."""

    case: str
    rectified: Share
    asked: Share
    error_px: dict[str, float]
    raw_px: dict[str, float]
    always_px: dict[str, float]


def run(
    runs: int,
    seed: int = 0,
    cases: Sequence[Case] = CASES,
    study: Study | None = None,
) -> list[Outcome]:
    """Evaluate draws of every case."""
    tasks = [(case.points, case.toe_in_deg, case.board, [seed, k]) for case in cases for k in range(runs)]
    found = iter((study or Study()).map(run_once, tasks))
    return [_outcome(case, list(islice(found, runs))) for case in cases]


def run_once(points: int, toe_in_deg: float, board: bool, seed: list[int]) -> Run:
    """Evaluate one draw of a case."""
    tracked, test = draw(Case(points, toe_in_deg, board), np.random.default_rng(seed))
    inliers = find_outliers(tracked).corrected(tracked)
    chosen = leave_one_out(inliers).rectification
    by_matches = fit_rectification(*np.split(select_matches(tracked), 2, axis=1))
    error_px, raw_px, always_px = (_errors(tracked, test, by) for by in (chosen, None, by_matches))
    return Run(chosen is not None, by_matches is not None, error_px, raw_px, always_px)


def draw(case: Case, rng: np.random.Generator) -> tuple[FourViews, FourViews]:
    """Draw tracks with noise, (frames, N, …), and noise-free images of other points, (frames, N', …)."""
    cameras = Cameras([_camera(side, case.toe_in_deg, rng) for side in (-0.5, 0.5)])
    if case.board:
        images = np.stack([_board(cameras, rng) for _ in range(BOARD_FRAMES)], 1)
    else:
        images = _scene(cameras, case.points + TEST_POINTS, rng)[:, None]
    if not case.toe_in_deg:
        x, y = np.moveaxis(images[1::2] / (WIDTH / 2, HEIGHT / 2) - 1, -1, 0)
        images[1::2, ..., 1] += KEYSTONE_PX * x * y
    tracked, test = np.split(images[:, :, rng.permutation(images.shape[2])], [case.points], axis=2)
    noise_px = rng.uniform(*NOISE_PX) * np.sqrt((T_DEGREES_OF_FREEDOM - 2) / T_DEGREES_OF_FREEDOM)
    tracked = tracked + noise_px * rng.standard_t(T_DEGREES_OF_FREEDOM, tracked.shape)
    return FourViews.from_images(*tracked), FourViews.from_images(*test)


def _camera(side: float, toe_in_deg: float, rng: np.random.Generator) -> Camera:
    """A camera in the rig's frame. side: -0.5 for the left one, 0.5 for the right one."""
    turned = rotation_about_axis([0, 1, 0], -side * np.radians(toe_in_deg)) @ _turn((RESIDUAL_DEG,) * 3, rng)
    lens = Lens((FOCAL_PX, FOCAL_PX), (WIDTH / 2, HEIGHT / 2))
    return Camera(WIDTH, HEIGHT, lens, rigid_transform(turned, (side * BASELINE_M, 0, 0)))


def _scene(cameras: Cameras, count: int, rng: np.random.Generator) -> NDArray:
    """Images (4, count, 2) px of points that all cameras see, before the rig moves and after."""
    move = rigid_transform(_turn(TURN_DEG, rng), (0.05, 0.02, rng.uniform(*FORWARD_M)))
    found: list[NDArray] = []
    while sum(map(len, found)) < count:
        depth = rng.uniform(NEAR_M, FAR_M, 1000)
        across = rng.uniform(-0.5, 0.5, (1000, 2)) * (WIDTH, HEIGHT) / FOCAL_PX * depth[:, None]
        points = np.column_stack([across, depth])
        before, after = cameras.project(points), cameras.project((points - move[:3, 3]) @ move[:3, :3])
        images, seen = (np.concatenate(both) for both in zip(before, after))
        found.append(images[:, seen.all(0)].swapaxes(0, 1))
    return np.concatenate(found)[:count].swapaxes(0, 1)


def _board(cameras: Cameras, rng: np.random.Generator) -> NDArray:
    """Images (4, corners, 2) px of a chessboard at two places, all of it visible."""
    corners = np.stack([*np.meshgrid(*map(np.arange, BOARD), indexing="ij"), np.zeros(BOARD)], -1).reshape(-1, 3)
    corners = SQUARE_M * (corners - corners.mean(0))
    found: list[NDArray] = []
    while len(found) < 2:
        place = np.array([*rng.uniform(-0.3, 0.3, 2), rng.uniform(*BOARD_M)])
        images, seen = cameras.project(corners @ _turn((TILT_DEG,) * 3, rng).T + place)
        if seen.all():
            found.append(images)
    return np.concatenate(found)


def _turn(deg: Sequence[float], rng: np.random.Generator) -> NDArray:
    """A random small rotation, (3, 3). deg: standard deviations about x, y, z."""
    vector = np.radians(deg) * rng.standard_normal(3)
    return rotation_about_axis(vector, float(np.linalg.norm(vector)))


def _errors(tracked: FourViews, test: FourViews, by: Rectification | None) -> dict[str, float]:
    """By transfer, px rms of points that it was not fitted to."""
    fitted = {name: fit_transfer(method, tracked, by) for name, method in TRANSFERS.items()}
    errors = {name: one.recover(test.demo_left, test.demo_right) - test.own for name, one in fitted.items()}
    return {name: float(np.sqrt(np.square(px).sum(-1).mean() / 2)) for name, px in errors.items()}


def _outcome(case: Case, found: Sequence[Run]) -> Outcome:
    medians = (
        {name: float(np.median([errors[name] for errors in of])) for name in TRANSFERS}
        for of in zip(*((one.error_px, one.raw_px, one.always_px) for one in found))
    )
    rectified, asked = Share.of(one.rectified for one in found), Share.of(one.asked for one in found)
    return Outcome(case.name, rectified, asked, *medians)


def table(outcomes: Sequence[Outcome]) -> str:
    """Lay out the outcomes for people: a block for each case, a row for each transfer."""
    lines = ["median px rms of points held out: as `evaluate` leaves the images; as they are; rectified as matches ask"]
    for o in outcomes:
        lines.append(f"{o.case}: rectified {o.rectified}, matches alone would {o.asked}")
        rows = zip(o.error_px, o.error_px.values(), o.raw_px.values(), o.always_px.values())
        lines += [f"  {name:<11}" + "".join(f"{px:10.2f}" for px in errors) for name, *errors in rows]
    return "\n".join(lines)


def main(words: list[str] | None = None) -> None:
    """Print the outcomes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--case", help="those whose names contain it")
    asked = parser.parse_args(words)
    print(f"{asked.runs} random tracks of a stereo rig a case, seed {asked.seed}")
    print(table(run(asked.runs, asked.seed, chosen(CASES, asked.case), Study(None))))


if __name__ == "__main__":
    main()
