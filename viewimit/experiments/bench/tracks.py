"""How `evaluate` does with tracks of real stereo rigs: whether it rectifies, and how far transfers are off elsewhere.

A rig as of the KITTI data set (Geiger et al. 2012), 0.54 m between cameras of 1241 x 376 px, sees a rigid scene, moves,
and sees it again: [l r] and [L R]. Its rectification leaves what that of KITTI's public pairs leaves: in the right
image's rows a keystone, which a fundamental matrix fits well, and by which its rectification makes predictions worse.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.leave_one_out import leave_one_out
from ...estimation.outliers import find_outliers, select_matches
from ...estimation.rectification import fit_transfer
from ...estimation.transfers import TRANSFERS
from ...estimation.views import FourViews
from ...geometry.rectification import Rectification, fit_rectification
from ...geometry.rigid import rigid_transform, rotation_about_axis
from ...simulation.camera import Camera, Cameras, Lens
from ..executors.study import Study, each
from .success import Share

WIDTH, HEIGHT, FOCAL_PX, BASELINE_M = 1241, 376, 718.0, 0.54
NEAR_M, FAR_M = 5.0, 60.0  # depths of points, evenly drawn
FORWARD_M, TURN_DEG = (0.5, 1.5), (0.3, 1.0, 0.3)  # by how much the rig moves; standard deviations about x, y, z
RESIDUAL_DEG = 0.02  # standard deviation of what rectification leaves, about each axis of each camera
KEYSTONE_PX = 1.6  # in the corners, of rectified pairs
NOISE_PX, FREEDOM = (0.2, 0.5), 4  # standard deviation of a coordinate; of Student's t, whose tails are heavy
BOARD, SQUARE_M, BOARD_M, TILT_DEG = (9, 6), 0.15, (2.5, 4.0), 30.0  # a chessboard's corners, and where it is held
BOARD_FRAMES = 5
ELSEWHERE = 200  # points that are held out


@dataclass(frozen=True)
class Case:
    """points: that are tracked; toe_in_deg: angle between the optical axes.

    board: whether they lie on a chessboard, held elsewhere in each of BOARD_FRAMES frames. Scenes have one frame.
    """

    points: int
    toe_in_deg: float = 0.0
    board: bool = False

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
    """rectified: whether `evaluate` does; asked: whether the matches alone would ask for it. By transfer px rms of
    points that are held out, without noise: error_px, as `evaluate` leaves the images; raw_px, always_px: of the
    images as they are, and rectified as matches ask, or as they are where these ask for nothing."""

    rectified: bool
    asked: bool
    error_px: dict[str, float]
    raw_px: dict[str, float]
    always_px: dict[str, float]


@dataclass(frozen=True)
class Outcome:
    """Of a case: shares of runs, and medians over them, as of a `Run`."""

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
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Outcome]:
    """Every case. tell(share done)."""
    tasks = [(case.points, case.toe_in_deg, case.board, [seed, k]) for case in cases for k in range(runs)]
    found: list[Run] = []
    for one in each(run_once, tasks, workers):
        found.append(one)
        tell(len(found) / len(tasks))
    return [_outcome(case, found[k * runs : (k + 1) * runs]) for k, case in enumerate(cases)]


def run_once(points: int, toe_in_deg: float, board: bool, seed: list[int]) -> Run:
    """One draw of a case."""
    seen, elsewhere = draw(Case(points, toe_in_deg, board), np.random.default_rng(seed))
    right = find_outliers(seen).corrected(seen)
    chosen = leave_one_out(right).rectification
    by_matches = fit_rectification(*np.split(select_matches(seen), 2, axis=1))
    error_px, raw_px, always_px = (_errors(seen, elsewhere, by) for by in (chosen, None, by_matches))
    return Run(chosen is not None, by_matches is not None, error_px, raw_px, always_px)


def draw(case: Case, rng: np.random.Generator) -> tuple[FourViews, FourViews]:
    """What is tracked, with noise, (frames, N, …), and images of other points, without, (frames, N', …)."""
    cameras = Cameras([_camera(side, case.toe_in_deg, rng) for side in (-0.5, 0.5)])
    if case.board:
        images = np.stack([_board(cameras, rng) for _ in range(BOARD_FRAMES)], 1)
    else:
        images = _scene(cameras, case.points + ELSEWHERE, rng)[:, None]
    if not case.toe_in_deg:
        x, y = np.moveaxis(images[1::2] / (WIDTH / 2, HEIGHT / 2) - 1, -1, 0)
        images[1::2, ..., 1] += KEYSTONE_PX * x * y
    seen, elsewhere = np.split(images[:, :, rng.permutation(images.shape[2])], [case.points], axis=2)
    noise_px = rng.uniform(*NOISE_PX) * np.sqrt((FREEDOM - 2) / FREEDOM)
    seen = seen + noise_px * rng.standard_t(FREEDOM, seen.shape)
    return FourViews.from_images(*seen), FourViews.from_images(*elsewhere)


def _camera(side: float, toe_in_deg: float, rng: np.random.Generator) -> Camera:
    """In the rig's frame. side: -0.5 for the left one, 0.5."""
    turned = rotation_about_axis([0, 1, 0], -side * np.radians(toe_in_deg)) @ _turn((RESIDUAL_DEG,) * 3, rng)
    lens = Lens((FOCAL_PX, FOCAL_PX), (WIDTH / 2, HEIGHT / 2))
    return Camera(WIDTH, HEIGHT, lens, rigid_transform(turned, (side * BASELINE_M, 0, 0)))


def _scene(cameras: Cameras, count: int, rng: np.random.Generator) -> NDArray:
    """Images (4, count, 2) px of points that all see, before the rig moves and after."""
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
    """Images (4, corners, 2) px of a chessboard that is held at two places, seen whole."""
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


def _errors(seen: FourViews, elsewhere: FourViews, by: Rectification | None) -> dict[str, float]:
    """px rms, by transfer, of points that it was not fitted to."""
    fitted = {name: fit_transfer(method, seen, by) for name, method in TRANSFERS.items()}
    off = {name: one.recover(elsewhere.demo_left, elsewhere.demo_right) - elsewhere.own for name, one in fitted.items()}
    return {name: float(np.sqrt(np.square(px).sum(-1).mean() / 2)) for name, px in off.items()}


def _outcome(case: Case, found: Sequence[Run]) -> Outcome:
    medians = (
        {name: float(np.median([errors[name] for errors in of])) for name in TRANSFERS}
        for of in zip(*((one.error_px, one.raw_px, one.always_px) for one in found))
    )
    rectified, asked = Share.of(one.rectified for one in found), Share.of(one.asked for one in found)
    return Outcome(case.name, rectified, asked, *medians)
