"""Fig. 8: E over a coarse grid of postures that the learner's motors reach, with all points detected in pictures."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_of_images
from ...drawing import svg
from ...drawing.plots import WIDTH, figure
from ...drawing.posture_plane import PosturePlane
from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import Settings
from ...simulation.scene import Scene
from ..experiment import Tables, joint_columns, stacked
from .common import (
    Claims,
    Progress,
    demonstrator_mark,
    draw_surface,
    grid_rows,
    in_degrees,
    legend_entry,
    legend_marks,
    no_progress,
)

PAPER_MINIMUM_DEG = (45.0, -86.0)
STEP_DEG = 10.0  # of θ2 in the paper; that of θ4 is not printed
PAPER_GRID_DEG = (np.arange(25.0, 80.0, STEP_DEG), np.arange(-135.0, -20.0, STEP_DEG))  # Sec. 5.2


COLUMN, GAP = 207, 10  # px: the width of a panel, between two
MARGINS = (31, 3, 0, 14)  # px around a plot: left, right, top, bottom
TITLE, TOP, MAX_HIGH, BELOW = 34, 6, 110, 34  # px: of the caption, from a row's title to its plots, of these, beneath
MIN_OPACITY = 0.25  # of the cell with the fewest points
CROSS = 5.5  # px


@dataclass(frozen=True)
class Surface:
    """E of one transfer over the commanded postures."""

    landscape: Landscape
    E_demo: float  # px², in the demonstrator's posture
    fitted: NDArray[np.float64]  # of `fitted_minimum`


@dataclass(frozen=True)
class Fig8:
    """The result, over a grid of (n, m) postures."""

    settings: Settings
    joints: tuple[int, ...]
    demonstrator_deg: NDArray[np.float64]  # as reached
    usable: NDArray[np.int_]  # (n, m) points seen in all four pictures
    sag_deg: NDArray[np.float64]  # (n, m, 2) from the commanded to the reached postures
    surfaces: dict[str, Surface]  # by transfer

    @property
    def claims(self) -> Claims:
        """What the paper says beside the result."""
        claims = Claims(self.settings)
        for name, surface in self.surfaces.items():
            E, grid = surface.landscape.E, np.degrees(surface.landscape.minimum)
            off = float(np.abs(grid - self.demonstrator_deg).max())
            paper = "(45°, −86°)" if name == self.settings.transfer else "–"
            line = f"Fig. 8: {name}, smallest E on the grid"
            if name == self.settings.transfer:
                claims.judge(line, paper, in_degrees(grid), "minimum on pictures", off, "{:g}° of demonstrator")
            else:
                claims.add(line, paper, in_degrees(grid))
            fitted = in_degrees(np.degrees(surface.fitted)) if np.isfinite(surface.fitted).all() else "none"
            claims.add(f"Fig. 8: {name}, parabola's minimum", paper, fitted)
            count, basin = len(surface.landscape.local_minima()), surface.landscape.basin_fraction()
            one = "1" if paper != "–" else "–"
            claims.add(f"Fig. 8: {name}, local minima on the grid", one, f"{count}, basin {basin:.0%}")
            here = f"{np.nanmin(E):.3g} … {np.nanmax(E):.3g} px², {surface.E_demo:.3g} in demonstrator's posture"
            claims.add(f"Fig. 8: {name}, E", "–", here)
        here = f"median {np.median(self.usable):.0f}, fewest {self.usable.min()}"
        claims.add("Fig. 8: points seen in all four pictures", "–", here)
        claims.add("Fig. 8: sag of the arm", "–", f"{np.abs(self.sag_deg).max():.2f}° at most")
        return claims

    @property
    def tables(self) -> Tables:
        """The numbers."""
        axes = next(iter(self.surfaces.values())).landscape.axes
        postures = np.degrees(grid_rows(*axes))
        surface = joint_columns(self.joints, "commanded", postures)
        surface |= joint_columns(self.joints, "reached", postures + self.sag_deg.reshape(-1, 2))
        surface["usable"] = self.usable.ravel()
        for name, each in self.surfaces.items():
            surface[f"E_{name}_px2"] = each.landscape.E.ravel()
        minima = []
        for name, each in self.surfaces.items():
            on_grid = joint_columns(self.joints, "grid", np.degrees(each.landscape.minimum)[None])
            fitted = joint_columns(self.joints, "fitted", np.degrees(each.fitted)[None])
            minima.append({"transfer": name, **on_grid, **fitted, "E_demonstrator_px2": each.E_demo})
        return {"surface": surface, "minima": stacked(minima)}


def run(
    settings: Settings, progress: Progress = no_progress, grid_deg: tuple[NDArray, NDArray] = PAPER_GRID_DEG
) -> Fig8:
    """Compute E for every transfer, from the same pictures.

    Raises ValueError unless two joints move, or if the grid is beyond their limits.
    """
    session = Session(settings)
    scene = session.scene
    if len(scene.moving_joints) != 2:
        raise ValueError(f"a landscape needs two moving joints, this scene has {len(scene.moving_joints)}")
    axes = np.radians(grid_deg[0]), np.radians(grid_deg[1])
    commanded = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    reached, own, visible = _pictures(session, commanded, progress)
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


def _pictures(session: Session, commanded: NDArray, progress: Progress) -> tuple[NDArray, NDArray, NDArray]:
    """Drive from posture to posture, (n, m, 2) rad. Return the postures reached, and images and visibility there."""
    now, found = session.snapshot, []
    theta, sent = now.theta, now.commanded
    for target in commanded.reshape(-1, 2):
        goal = session.scene.require_posture(target, "learner's")
        theta, sent = session.embodiment.drive(session.settings, theta, sent, goal), target
        found.append((theta, *session.eyes.own_images(theta)))
        progress(len(found) / (commanded.size // 2), None)
    reached, own, visible = (np.array(each).reshape(commanded.shape[:2] + each[0].shape) for each in zip(*found))
    return reached, own, visible


def fitted_minimum(axes: tuple[NDArray, NDArray], E: NDArray) -> NDArray:
    """Fit a parabola to the smallest E of a grid and its neighbours, and return its minimum, (2,) rad.

    NaN if the parabola opens downwards, or its minimum is not between the neighbours.
    """
    if np.isnan(E).all():
        return np.full(2, np.nan)
    i, j = np.unravel_index(np.nanargmin(E), E.shape)
    rows, columns = (slice(max(k - 1, 0), k + 2) for k in (i, j))
    a, b = np.meshgrid(axes[0][rows] - axes[0][i], axes[1][columns] - axes[1][j], indexing="ij")
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], -1)[np.isfinite(E[rows, columns])]
    if len(terms) < terms.shape[1]:
        return np.full(2, np.nan)
    __, da, db, aa, ab, bb = np.linalg.lstsq(terms, E[rows, columns][np.isfinite(E[rows, columns])], rcond=None)[0]
    Q = np.array([[2 * aa, ab], [ab, 2 * bb]])
    if np.linalg.eigvalsh(Q)[0] <= 0:
        return np.full(2, np.nan)
    step = -np.linalg.solve(Q, [da, db])
    inside = (np.abs(step) <= [np.abs(a).max(), np.abs(b).max()]).all()
    return np.array([axes[0][i], axes[1][j]]) + step if inside else np.full(2, np.nan)


def draw(scene: Scene, found: Fig8) -> str:
    """Draw E over the grid, a panel for each transfer, and the number of points that the four pictures share."""
    axes = next(iter(found.surfaces.values())).landscape.axes
    first, second = (np.degrees(axis) for axis in axes)
    half = [(axis[1] - axis[0]) / 2 if len(axis) > 1 else 5.0 for axis in (first, second)]
    ranges = [(float(axis.min() - h), float(axis.max() + h)) for axis, h in zip((first, second), half)]
    plane = PosturePlane(scene, COLUMN, MAX_HIGH, MARGINS, ranges)
    names = list(found.surfaces)
    panels = [_panel(plane, found, name) for name in names] + [_points(plane, found, half)]
    row = TOP + plane.box[3] + BELOW
    parts = []
    for k, (title, note, inside) in enumerate(panels):
        x, y = k % 2 * (COLUMN + GAP), TITLE + k // 2 * row
        parts.append(
            f'<g transform="translate({x} {y:.1f})"><text x="{plane.box[0]:.1f}" y="0"><tspan class="vi-b">'
            f'{svg.escape(title)}</tspan><tspan class="vi-2nd" dx="5">{svg.escape(note)}</tspan></text>'
            f'<g transform="translate(0 {TOP})">{inside}{plane.ends()}</g></g>'
        )
    bottom = TITLE + -(-len(panels) // 2) * row
    count = found.usable.size
    extra = f"{count} posture{'s' * (count != 1)}"
    return figure(found.settings, "".join(parts) + _legend(bottom), extra, bottom + 14)


def _panel(plane: PosturePlane, found: Fig8, name: str) -> tuple[str, str, str]:
    """Title, note and drawing of one transfer's surface."""
    surface = found.surfaces[name]
    E, background = surface.landscape.E, plane.frame("vi-plane")
    if np.isnan(E).all():
        return name, "", background + plane.message("nowhere are five points seen")
    lowest, demo = plane.place(np.degrees(surface.landscape.minimum)), plane.place(found.demonstrator_deg)
    drawn = draw_surface(plane, surface.landscape, plane.labels.copy(), np.stack([lowest, demo]), lowest)
    paper = svg.saltire(plane.place(np.array(PAPER_MINIMUM_DEG)))
    note = f"E {svg.short(np.nanmin(E), 10)} … {svg.short(np.nanmax(E), 10)} px²"
    return name, note, background + drawn + demonstrator_mark(demo) + svg.cross(lowest, CROSS) + paper


def _points(plane: PosturePlane, found: Fig8, half: list[float]) -> tuple[str, str, str]:
    """Title, note and drawing of the number of points in all four pictures, a cell for each posture."""
    axes = next(iter(found.surfaces.values())).landscape.axes
    x, y = plane.grid(axes)
    wide, high = 2 * half[1] * plane.scale, 2 * half[0] * plane.scale
    most, parts = max(int(found.usable.max()), 1), []
    for (i, j), count in np.ndenumerate(found.usable):
        opacity = MIN_OPACITY + (1 - MIN_OPACITY) * count / most
        parts.append(
            f'<rect class="vi-bar-cost" x="{x[j] - wide / 2:.1f}" y="{y[i] - high / 2:.1f}" width="{wide:.1f}"'
            f' height="{high:.1f}" opacity="{opacity:.2f}"/>'
        )
        if len(str(count)) * 7 < wide and high > 11:
            parts.append(svg.text(float(x[j]), float(y[i]) + 4, str(count), "vi-mid"))
    note = f"in all four pictures: {found.usable.min()} … {most}"
    return "points", note, "".join(parts)


def _legend(y: float) -> str:
    left, spacing, y = MARGINS[0], (WIDTH - 60) / 3, round(float(y), 1)
    return "".join(legend_entry(left + k * spacing, y, *entry, gap=20) for k, entry in enumerate(legend_marks(CROSS)))
