"""Fig. 7: E over the postures of the learner, its minima, its curvature, and a study over other demonstrators."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_at, grid_axes, landscape_over
from ...analysis.minima import Conflict, Convexity, Minima, convexity, local_minima
from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import Settings, given
from ..experiment import Tables, joint_columns, stacked
from .claims import Claims, in_degrees

PAPER_MINIMUM_DEG = (41.0, -90.0)
PAPER_RANGE_DEG2 = 90.0 * 180.0
STUDY = (6, 5)  # demonstrators a joint, spread evenly over the middle of its range
MARGIN_DEG = 10.0


@dataclass(frozen=True)
class Surface:
    """E of one transfer over the grid. minima: between the grid's points; convexity: at the lowest, None without it."""

    landscape: Landscape
    minima: Minima
    basin: float
    E_demo: float
    convexity: Convexity | None


@dataclass(frozen=True)
class Study:
    """A row a demonstrator: demonstrator_deg (K, 2); minima, on_limit, on_grid: (K,) counts between the grid's points,
    those of them at the edge of the range, and on the grid; basin: (K,); bias_deg: (K, 2), of the lowest minimum."""

    demonstrator_deg: NDArray
    minima: NDArray
    on_limit: NDArray
    on_grid: NDArray
    basin: NDArray
    bias_deg: NDArray


@dataclass(frozen=True)
class Fig7:
    """surfaces, studies: by transfer. A study that is still being made has fewer rows."""

    settings: Settings
    demonstrator_deg: tuple[float, ...]
    joints: tuple[int, ...]
    surfaces: dict[str, Surface]
    studies: dict[str, Study]

    @property
    def claims(self) -> Claims:
        return _claims(self)

    @property
    def tables(self) -> Tables:
        return _tables(self)


def run(
    settings: Settings,
    tell: Callable[[float, Fig7 | None], None] = lambda share, partial: None,
    step_deg: float | None = None,
    study: tuple[int, int] = STUDY,
) -> Fig7:
    """For every transfer. tell(share done, what is there so far). Raises ValueError unless two joints move.

    step_deg: of the grid; if None 1°, as for the paper's ranges, and coarser for larger ones.
    """
    session = Session(settings)
    axes = grid_axes(session.world, step_deg or grid_step_deg(session))
    demo_deg, joints = given(session.settings.demonstrator_deg), session.scene.moving_joints
    found = Fig7(session.settings, demo_deg, joints, {}, {})
    others = _demonstrators(axes, study)
    total, done = len(TRANSFERS) * (1 + len(others)), 0
    for transfer in TRANSFERS:
        surface = _surface(session, transfer, axes)
        found, done = replace(found, surfaces={**found.surfaces, transfer: surface}), done + 1
        tell(done / total, found)
    for transfer in TRANSFERS:
        rows = []
        for theta_demo in others:
            session.pose(theta_demo)
            rows.append(_study_row(session, transfer, axes))
            study_so_far = Study(*map(np.array, zip(*rows)))
            found, done = replace(found, studies={**found.studies, transfer: study_so_far}), done + 1
            tell(done / total, found)
    return found


def grid_step_deg(session: Session) -> float:
    """As many postures as the paper's ranges have at 1°, or fewer."""
    return max(1.0, float(np.sqrt(np.prod(np.diff(session.scene.range_deg)) / PAPER_RANGE_DEG2)))


def conflict_of(session: Session, transfer: str) -> Conflict:
    """E_at(θ): of the demonstrator as the learner has seen it, at any of the learner's postures."""
    views, fit, world = session.snapshot.views, partial(session.snapshot.fit, by=transfer), session.world
    return lambda theta: conflict_at(world, fit, views.demo, views.visible[:, :2], theta)[0]


def over_grid(session: Session, transfer: str, axes: tuple[NDArray, NDArray]) -> Landscape:
    views, fit = session.snapshot.views, partial(session.snapshot.fit, by=transfer)
    return landscape_over(session.world, fit, views.demo, views.visible[:, :2], axes)


def _surface(session: Session, transfer: str, axes: tuple[NDArray, NDArray]) -> Surface:
    E_at, found = conflict_of(session, transfer), over_grid(session, transfer, axes)
    minima = local_minima(found, E_at)
    bounds = np.array([[axis.min(), axis.max()] for axis in axes])
    curved = convexity(E_at, minima.theta[0], bounds) if len(minima) else None
    E_demo = float(E_at(session.snapshot.theta_demo[:, None])[0])
    return Surface(found, minima, found.basin_fraction(), E_demo, curved)


def _study_row(session: Session, transfer: str, axes: tuple[NDArray, NDArray]) -> tuple:
    found = over_grid(session, transfer, axes)
    minima = local_minima(found, conflict_of(session, transfer))
    demo_deg = np.array(session.settings.demonstrator_deg)
    bias = np.degrees(minima.theta[0]) - demo_deg if len(minima) else np.full(2, np.nan)
    return demo_deg, len(minima), int(minima.on_limit.sum()), len(found.local_minima()), found.basin_fraction(), bias


def _demonstrators(axes: tuple[NDArray, NDArray], counts: tuple[int, int]) -> NDArray:
    """(K, 2) rad"""
    margin = np.radians(MARGIN_DEG)
    spread = [np.linspace(axis.min() + margin, axis.max() - margin, n) for axis, n in zip(axes, counts)]
    return np.stack(np.meshgrid(*spread, indexing="ij"), -1).reshape(-1, 2)


def _claims(found: Fig7) -> Claims:
    claims = Claims(found.settings)
    surface = found.surfaces.get(found.settings.transfer)
    if surface is None or not len(surface.minima):
        return claims
    here = np.degrees(surface.minima.theta[0])
    off = float(np.abs(here - found.demonstrator_deg).max())
    form = "{:g}° of demonstrator"
    claims.judge("Fig. 7: smallest E", "(41°, −90°)", in_degrees(here), "minimum", off, form, "the place of smallest E")
    count = len(surface.minima)
    claims.judge("Fig. 7: local minima", "1", str(count), "minima", count, "{:g}", "a single minimum")
    reached = f"{surface.basin:.1%}"
    claims.judge("Fig. 7: descents that reach it", "all", reached, "basin", surface.basin, "≥ {:.0%}")
    if (curved := surface.convexity) is not None:
        low, high = curved.eigenvalues
        definite = curved.positive_definite
        claims.add("Eq. (11): Q positive definite", "yes", f"{low:.4f}, {high:.4f} px²/°²", "both > 0", definite)
        claims.add("Eq. (11): E ≈ δθᵀQδθ within 25 %", "nearby", f"to {curved.holds_to_deg:g}° around")
        claims.add("Eq. (11): E convex", "nearby", f"to {curved.convex_radius_deg:g}° around")
    study = found.studies.get(found.settings.transfer)
    if study is not None:
        inside = study.minima - study.on_limit
        claims.add("Other demonstrators: one minimum inside", "–", f"{(inside == 1).sum()} of {len(inside)}")
        mean, most = np.abs(study.bias_deg).mean(0), np.abs(study.bias_deg).max(0)
        here = f"mean {mean[0]:.1f}°/{mean[1]:.1f}°, most {most[0]:.1f}°/{most[1]:.1f}°"
        claims.add("Other demonstrators: bias of the minimum", "4°/0° for one", here)
    return claims


def _tables(found: Fig7) -> Tables:
    axes = next(iter(found.surfaces.values())).landscape.axes
    postures = np.degrees(np.stack(np.meshgrid(*axes, indexing="ij"), -1)).reshape(-1, 2)
    surface = joint_columns(found.joints, "theta", postures)
    for transfer, each in found.surfaces.items():
        surface[f"E_{transfer}_px2"] = each.landscape.E.ravel()
    minima, curves, studies = [], [], []
    for transfer, each in found.surfaces.items():
        place = joint_columns(found.joints, "theta", np.degrees(each.minima.theta))
        minima.append({"transfer": transfer, **place, "E_px2": each.minima.E, "on_limit": each.minima.on_limit})
        if each.convexity is not None:
            curved = each.convexity
            error = {"error_median": curved.error, "error_worst": curved.worst}
            curves.append({"transfer": transfer, "radius_deg": curved.radius_deg, **error})
    for transfer, study in found.studies.items():
        counts = {"minima": study.minima, "on_limit": study.on_limit, "on_grid": study.on_grid, "basin": study.basin}
        demonstrator = joint_columns(found.joints, "demonstrator", study.demonstrator_deg)
        bias = joint_columns(found.joints, "bias", study.bias_deg)
        studies.append({"transfer": transfer, **demonstrator, **counts, **bias})
    return {
        "surface": surface,
        "minima": stacked(minima),
        "convexity": stacked(curves),
        "demonstrators": stacked(studies),
    }
