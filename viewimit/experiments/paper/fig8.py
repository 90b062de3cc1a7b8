"""Fig. 8: E over a coarse grid of the learner's postures, each driven to by its motors, all points from pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_of_images
from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import Settings
from ..experiment import Tables, joint_columns, stacked
from .claims import Claims, in_degrees

PAPER_MINIMUM_DEG = (45.0, -86.0)
STEP_DEG = 10.0  # of θ2 in the paper; that of θ4 is not printed
PAPER_GRID_DEG = (np.arange(25.0, 80.0, STEP_DEG), np.arange(-135.0, -20.0, STEP_DEG))  # Sec. 5.2


@dataclass(frozen=True)
class Surface:
    """E of one transfer over the postures commanded; E_demo: in the demonstrator's; fitted: see `fitted_minimum`."""

    landscape: Landscape
    E_demo: float
    fitted: NDArray


@dataclass(frozen=True)
class Fig8:
    """usable: (n, m) points seen in all four pictures; sag_deg: (n, m, 2) from the commanded to the reached postures;
    demonstrator_deg: as reached."""

    settings: Settings
    joints: tuple[int, ...]
    demonstrator_deg: NDArray
    usable: NDArray
    sag_deg: NDArray
    surfaces: dict[str, Surface]

    @property
    def claims(self) -> Claims:
        return _claims(self)

    @property
    def tables(self) -> Tables:
        return _tables(self)


def run(
    settings: Settings,
    tell: Callable[[float, Fig8 | None], None] = lambda share, partial: None,
    grid_deg: tuple[NDArray, NDArray] = PAPER_GRID_DEG,
) -> Fig8:
    """For every transfer, of the same pictures. Raises ValueError unless two joints move, or the grid is beyond their
    limits. tell(share done, None)."""
    session = Session(settings)
    scene = session.scene
    if len(scene.moving_joints) != 2:
        raise ValueError(f"a landscape needs two moving joints, this scene has {len(scene.moving_joints)}")
    axes = np.radians(grid_deg[0]), np.radians(grid_deg[1])
    commanded = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    reached, own, visible = _pictures(session, commanded, tell)
    now = session.snapshot
    demo, demo_visible = now.views.demo, now.views.visible[:, :2]
    there = session.eyes.own_images(now.theta_demo)
    surfaces = {}
    for name in TRANSFERS:
        fit = partial(now.fit, by=name)
        E = conflict_of_images(fit, demo, demo_visible, own, visible)[0]
        (E_demo,) = conflict_of_images(fit, demo, demo_visible, *there)
        surfaces[name] = Surface(Landscape(axes, E), float(E_demo), fitted_minimum(axes, E))
    usable = (visible.all(-1) & demo_visible.all(-1)).sum(-1)
    sag, demonstrator = np.degrees(reached - commanded), np.degrees(now.theta_demo)
    return Fig8(session.settings, scene.moving_joints, demonstrator, usable, sag, surfaces)


def _pictures(
    session: Session, commanded: NDArray, tell: Callable[[float, None], None]
) -> tuple[NDArray, NDArray, NDArray]:
    """Drive from posture to posture, (n, m, 2) rad → where the arm came to rest, and what was seen there."""
    now, found = session.snapshot, []
    theta, sent = now.theta, now.commanded
    for target in commanded.reshape(-1, 2):
        theta = session.eyes.drive(session.settings, theta, sent, session.scene.require_posture(target, "learner's"))
        sent = target
        found.append((theta, *session.eyes.own_images(theta)))
        tell(len(found) / (commanded.size // 2), None)
    reached, own, visible = (np.array(each).reshape(commanded.shape[:2] + each[0].shape) for each in zip(*found))
    return reached, own, visible


def fitted_minimum(axes: tuple[NDArray, NDArray], E: NDArray) -> NDArray:
    """(2,) rad: of the parabola through the smallest E of a grid and its neighbours; NaN if it opens downwards there or
    leads out of them."""
    if np.isnan(E).all():
        return np.full(2, np.nan)
    i, j = np.unravel_index(np.nanargmin(E), E.shape)
    rows, columns = (slice(max(k - 1, 0), k + 2) for k in (i, j))
    a, b = np.meshgrid(axes[0][rows] - axes[0][i], axes[1][columns] - axes[1][j], indexing="ij")
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], -1)[np.isfinite(E[rows, columns])]
    if len(terms) < terms.shape[1]:
        return np.full(2, np.nan)
    _, da, db, aa, ab, bb = np.linalg.lstsq(terms, E[rows, columns][np.isfinite(E[rows, columns])], rcond=None)[0]
    Q = np.array([[2 * aa, ab], [ab, 2 * bb]])
    if np.linalg.eigvalsh(Q)[0] <= 0:
        return np.full(2, np.nan)
    step = -np.linalg.solve(Q, [da, db])
    inside = (np.abs(step) <= [np.abs(a).max(), np.abs(b).max()]).all()
    return np.array([axes[0][i], axes[1][j]]) + step if inside else np.full(2, np.nan)


def _claims(found: Fig8) -> Claims:
    claims = Claims(found.settings)
    for name, surface in found.surfaces.items():
        E, grid = surface.landscape.E, np.degrees(surface.landscape.minimum)
        off = float(np.abs(grid - found.demonstrator_deg).max())
        paper = "(45°, −86°)" if name == found.settings.transfer else "–"
        line = f"Fig. 8: {name}, smallest E on the grid"
        if name == found.settings.transfer:
            claims.judge(line, paper, in_degrees(grid), "minimum on pictures", off, "{:g}° of demonstrator")
        else:
            claims.add(line, paper, in_degrees(grid))
        fitted = in_degrees(np.degrees(surface.fitted)) if np.isfinite(surface.fitted).all() else "none"
        claims.add(f"Fig. 8: {name}, parabola's minimum", paper, fitted)
        count, basin = len(surface.landscape.local_minima()), surface.landscape.basin_fraction()
        claims.add(
            f"Fig. 8: {name}, local minima on the grid", "1" if paper != "–" else "–", f"{count}, basin {basin:.0%}"
        )
        least, largest = np.nanmin(E), np.nanmax(E)
        claims.add(
            f"Fig. 8: {name}, E",
            "–",
            f"{least:.3g} … {largest:.3g} px², {surface.E_demo:.3g} in demonstrator's posture",
        )
    few, many = found.usable.min(), np.median(found.usable)
    claims.add("Fig. 8: points seen in all four pictures", "–", f"median {many:.0f}, fewest {few}")
    claims.add("Fig. 8: sag of the arm", "–", f"{np.abs(found.sag_deg).max():.2f}° at most")
    return claims


def _tables(found: Fig8) -> Tables:
    axes = next(iter(found.surfaces.values())).landscape.axes
    postures = np.degrees(np.stack(np.meshgrid(*axes, indexing="ij"), -1)).reshape(-1, 2)
    surface = joint_columns(found.joints, "commanded", postures)
    surface |= joint_columns(found.joints, "reached", postures + found.sag_deg.reshape(-1, 2))
    surface["usable"] = found.usable.ravel()
    for name, each in found.surfaces.items():
        surface[f"E_{name}_px2"] = each.landscape.E.ravel()
    minima = []
    for name, each in found.surfaces.items():
        on_grid = joint_columns(found.joints, "grid", np.degrees(each.landscape.minimum)[None])
        fitted = joint_columns(found.joints, "fitted", np.degrees(each.fitted)[None])
        minima.append({"transfer": name, **on_grid, **fitted, "E_demonstrator_px2": each.E_demo})
    return {"surface": surface, "minima": stacked(minima)}
