"""Fig. 7: E over the learner's postures, its minima and curvature, and their bias for other demonstrators."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_at, grid_axes, landscape_over, seen_from
from ...analysis.minima import MAX_RELATIVE_ERROR, RADII_DEG, Conflict, Convexity, Minima, convexity, local_minima
from ...drawing import svg
from ...drawing.labels import CHARACTER
from ...drawing.plots import Axes, decade_ticks, decades, figure, log10, sentence, style_of
from ...drawing.posture_plane import PosturePlane
from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import Settings, given
from ...simulation.scene import Scene
from ..experiment import Tables, joint_columns, stacked
from .common import (
    PAPER_DEMONSTRATOR_DEG,
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

PAPER_MINIMUM_DEG = (41.0, -90.0)
PAPER_RANGE_DEG2 = 90.0 * 180.0
STUDY = (6, 5)  # demonstrators for each joint, evenly spaced over its range
MARGIN_DEG = 10.0  # of the range that is left out at both ends

SENTENCE = "Maps E over all postures: is there one valley, and does it end at the demonstrator's posture?"
MAP_WIDTH, MAP_HIGH, MAP_TOP = 270, 118, 19  # px; the plane's own margins are inside
BIAS_BOX, VALIDITY_BOX = (322, 27, 420, 101), (322, 147, 420, 197)  # left, top, right, bottom px of the plots
MIN_BIAS_DEG, PERCENT = 5.0, (1.0, 100.0)  # ranges that the plots show at least
CROSS, DOT = 6.0, 1.8  # px
TITLE_OUTDENT = 32  # px from a title to its plot, left of it


@dataclass(frozen=True)
class Surface:
    """E of one transfer over the grid."""

    landscape: Landscape
    minima: Minima  # between the grid's points
    basin: float  # share of the postures from which descent ends at the lowest minimum
    E_demo: float  # px², in the demonstrator's posture
    convexity: Convexity | None  # at the lowest minimum


@dataclass(frozen=True)
class Study:
    """Minima of one transfer for K other demonstrators."""

    demonstrator_deg: NDArray[np.float64]  # (K, 2)
    minima: NDArray[np.int_]  # (K,) number of minima between the grid's points
    on_limit: NDArray[np.int_]  # (K,) of these, at the edge of the range
    on_grid: NDArray[np.int_]  # (K,) number of minima on the grid
    basin: NDArray[np.float64]  # (K,) as of a `Surface`
    bias_deg: NDArray[np.float64]  # (K, 2) from the demonstrator to the lowest minimum


@dataclass(frozen=True)
class Fig7:
    """The result. A study that is still being made has fewer rows."""

    settings: Settings
    demonstrator_deg: tuple[float, ...]
    joints: tuple[int, ...]
    surfaces: dict[str, Surface]  # by transfer
    studies: dict[str, Study]  # by transfer

    @property
    def bias_deg(self) -> NDArray[np.float64]:
        """(0 or 1, 2) from the demonstrator to the lowest minimum, with the transfer of the settings."""
        surface = self.surfaces.get(self.settings.transfer)
        if surface is None or not len(surface.minima):
            return np.empty((0, 2))
        return np.degrees(surface.minima.theta[:1]) - self.demonstrator_deg

    @property
    def claims(self) -> Claims:
        """What the paper says beside the result."""
        claims = Claims(self.settings)
        surface = self.surfaces.get(self.settings.transfer)
        if surface is None or not len(surface.minima):
            return claims
        here = np.degrees(surface.minima.theta[0])
        off, form = float(np.abs(here - self.demonstrator_deg).max()), "{:g}° of demonstrator"
        place = "the place of smallest E"
        claims.judge("Fig. 7: smallest E", "(41°, −90°)", in_degrees(here), "minimum", off, form, place)
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
        study = self.studies.get(self.settings.transfer)
        if study is not None:
            inside = study.minima - study.on_limit
            here = f"{(inside == 1).sum()} of {len(inside)}"
            claims.add("Other demonstrators: one minimum inside", "–", here)
            mean, most = np.abs(study.bias_deg).mean(0), np.abs(study.bias_deg).max(0)
            here = f"mean {mean[0]:.1f}°/{mean[1]:.1f}°, most {most[0]:.1f}°/{most[1]:.1f}°"
            claims.add("Other demonstrators: bias of the minimum", "4°/0° for one", here)
        return claims

    @property
    def tables(self) -> Tables:
        """The numbers."""
        axes = next(iter(self.surfaces.values())).landscape.axes
        postures = np.degrees(grid_rows(*axes))
        surface = joint_columns(self.joints, "theta", postures)
        for transfer, each in self.surfaces.items():
            surface[f"E_{transfer}_px2"] = each.landscape.E.ravel()
        minima, curves, studies = [], [], []
        for transfer, each in self.surfaces.items():
            place = joint_columns(self.joints, "theta", np.degrees(each.minima.theta))
            minima.append({"transfer": transfer, **place, "E_px2": each.minima.E, "on_limit": each.minima.on_limit})
            if each.convexity is not None:
                curved = each.convexity
                error = {"error_median": curved.error, "error_worst": curved.worst}
                curves.append({"transfer": transfer, "radius_deg": curved.radius_deg, **error})
        for transfer, study in self.studies.items():
            counts = {name: getattr(study, name) for name in ("minima", "on_limit", "on_grid", "basin")}
            demonstrator = joint_columns(self.joints, "demonstrator", study.demonstrator_deg)
            bias = joint_columns(self.joints, "bias", study.bias_deg)
            studies.append({"transfer": transfer, **demonstrator, **counts, **bias})
        return {
            "surface": surface,
            "minima": stacked(minima),
            "convexity": stacked(curves),
            "demonstrators": stacked(studies),
        }


def run(
    settings: Settings, progress: Progress = no_progress, step_deg: float | None = None, study: tuple[int, int] = STUDY
) -> Fig7:
    """Compute E, its minima and the study for every transfer. Raises ValueError unless two joints move.

    step_deg: of the grid, by default 1° for the paper's ranges, and coarser for larger ones. study: demonstrators for
    each joint.
    """
    session = Session(settings)
    coarser = float(np.sqrt(np.prod(np.diff(session.scene.range_deg)) / PAPER_RANGE_DEG2))
    axes = grid_axes(session.world, step_deg or max(1.0, coarser))
    demo_deg, joints = given(session.settings.demonstrator_deg), session.scene.moving_joints
    found = Fig7(session.settings, demo_deg, joints, {}, {})
    others = _demonstrators(axes, study)
    total, done = len(TRANSFERS) * (1 + len(others)), 0
    for transfer in TRANSFERS:
        surface = _surface(session, transfer, axes)
        found, done = replace(found, surfaces={**found.surfaces, transfer: surface}), done + 1
        progress(done / total, found)
    for transfer in TRANSFERS:
        rows = []
        for theta_demo in others:
            session.pose(theta_demo)
            rows.append(_study_row(session, transfer, axes))
            study_so_far = Study(*map(np.array, zip(*rows)))
            found, done = replace(found, studies={**found.studies, transfer: study_so_far}), done + 1
            progress(done / total, found)
    return found


def _minima(session: Session, transfer: str, axes: tuple[NDArray, NDArray]) -> tuple[Conflict, Landscape, Minima]:
    """E as a function, on the grid, and its minima, for the demonstrator as the learner has seen it."""
    seen = seen_from(session.world, session.snapshot, transfer)
    E_at = lambda theta: conflict_at(*seen, theta)[0]
    found = landscape_over(*seen, axes)
    return E_at, found, local_minima(found, E_at)


def _surface(session: Session, transfer: str, axes: tuple[NDArray, NDArray]) -> Surface:
    E_at, found, minima = _minima(session, transfer, axes)
    bounds = np.array([[axis.min(), axis.max()] for axis in axes])
    curved = convexity(E_at, minima.theta[0], bounds) if len(minima) else None
    E_demo = float(E_at(session.snapshot.theta_demo[:, None])[0])
    return Surface(found, minima, found.basin_fraction(), E_demo, curved)


def _study_row(session: Session, transfer: str, axes: tuple[NDArray, NDArray]) -> tuple:
    _, found, minima = _minima(session, transfer, axes)
    demo_deg = np.array(session.settings.demonstrator_deg)
    bias = np.degrees(minima.theta[0]) - demo_deg if len(minima) else np.full(2, np.nan)
    return demo_deg, len(minima), int(minima.on_limit.sum()), len(found.local_minima()), found.basin_fraction(), bias


def _demonstrators(axes: tuple[NDArray, NDArray], counts: tuple[int, int]) -> NDArray:
    """(K, 2) rad"""
    margin = np.radians(MARGIN_DEG)
    spread = [np.linspace(axis.min() + margin, axis.max() - margin, n) for axis, n in zip(axes, counts)]
    return grid_rows(*spread)


def draw(scene: Scene, found: Fig7 | None = None) -> str:
    """Draw a whole or partial result: E with its parabola, the bias of its minimum, and how far the parabola holds."""
    parts = [_map(scene, found), _biases(scene, found), _validity(found), _legend(found)]
    return figure(found.settings if found else None, "".join(parts))


def _map(scene: Scene, found: Fig7 | None) -> str:
    plane = PosturePlane(scene, MAP_WIDTH, MAP_HIGH)
    surface = found.surfaces.get(found.settings.transfer) if found else None
    if not plane.has_plane:
        inside = plane.message("two joints must move")
    elif found is None:
        x, y, w, h = plane.box
        inside = sentence(wrap(SENTENCE, int((w - 12) / CHARACTER)), x + w / 2, y + h / 2)
    elif surface is None:
        inside = plane.message("computing …")
    elif np.isnan(surface.landscape.E).all():
        inside = plane.message("nowhere are five points seen")
    else:
        inside = _relief(plane, found, surface)
    return f'<g transform="translate(0 {MAP_TOP - 7})">{plane.frame("vi-plane")}{inside}{plane.axes()}</g>'


def _relief(plane: PosturePlane, found: Fig7, surface: Surface) -> str:
    demo = plane.place(np.array(found.demonstrator_deg))
    minima = plane.place(np.degrees(surface.minima.theta))
    lowest = minima[0] if len(minima) else demo
    drawn = draw_surface(plane, surface.landscape, plane.labels, np.stack([demo, *minima]), lowest)
    parts = [drawn, _ellipse(plane, surface), demonstrator_mark(demo)]
    parts += [svg.cross(place, CROSS if k == 0 else CROSS / 2) for k, place in enumerate(minima)]
    return "".join(parts)


def _ellipse(plane: PosturePlane, surface: Surface) -> str:
    """The level curve of δθᵀQδθ up to which it holds."""
    ring = surface.convexity.ring_deg() if surface.convexity else None
    if ring is None:
        return ""
    return f'<path class="vi-x-ellipse" d="{svg.path(plane.place(np.degrees(surface.minima.theta[0]) + ring))}"/>'


def _biases(scene: Scene, found: Fig7 | None) -> str:
    """Smallest E minus the demonstrator's posture: of this one, of others, and the paper's."""
    studies = found.studies if found else {}
    largest = [np.nanmax(np.abs(study.bias_deg), initial=0) for study in studies.values()]
    here = found.bias_deg if found else np.empty((0, 2))
    most = float(np.ceil(max([MIN_BIAS_DEG, *largest, *np.abs(here).ravel()])))
    left, top, right, bottom = BIAS_BOX
    wide = most * (right - left) / (bottom - top)
    plot = Axes(*BIAS_BOX, (-wide, wide), (-most, most))
    shown = 5.0 * max(1, most // 10)
    ticks = [(angle, svg.number(angle, 0) + "°") for angle in (-shown, 0, shown)]
    parts = [plot.frame("Minimum − demonstrator", "", ticks, ticks, TITLE_OUTDENT)]
    names = [svg.joint_symbol(joint) for joint in scene.moving_joints]
    parts.append(f'<path class="vi-rule" d="M{(left + right) / 2:.1f} {top}V{bottom}"/>')
    parts.append(svg.text((left + right) / 2 + 4, top + 9, names[0], "vi-2nd"))
    parts.append(svg.text(right, (top + bottom) / 2 - 4, names[-1], "vi-2nd vi-end"))
    for transfer, study in reversed(studies.items()):
        style = style_of(transfer, _transfers(found))
        parts.append(style.marks(plot.place(study.bias_deg[:, 1], study.bias_deg[:, 0]), DOT))
    parts += [svg.cross(plot.place(*bias[::-1]), CROSS) for bias in here]
    if found is None or found.demonstrator_deg == PAPER_DEMONSTRATOR_DEG:
        paper = np.subtract(PAPER_MINIMUM_DEG, PAPER_DEMONSTRATOR_DEG)
        parts.append(svg.saltire(plot.place(*paper[::-1])))
    return "".join(parts)


def _validity(found: Fig7 | None) -> str:
    """How far E is off its parabola, over the distance from the minimum."""
    curves = {name: each.convexity for name, each in found.surfaces.items() if each.convexity} if found else {}
    worst = np.concatenate([*(100 * curved.worst for curved in curves.values()), np.empty(0)])
    x, y = (float(RADII_DEG[0]), float(RADII_DEG[-1])), (decades(worst, *PERCENT)[0], np.nanmax([*worst, PERCENT[1]]))
    plot = Axes(*VALIDITY_BOX, x, y, log10, log10)
    ticks = [(value, f"{words} %") for value, words in decade_ticks(*y, 3)]
    degrees = [(radius, f"{radius}°") for radius in (1, 3, 10, 30)]
    parts = [plot.frame("E − δθᵀQδθ, relative", "", degrees, ticks, TITLE_OUTDENT)]
    parts.append(plot.level(100 * MAX_RELATIVE_ERROR, "vi-cursor"))
    for name, curved in reversed(curves.items()):
        style = style_of(name, _transfers(found))
        parts.append(plot.line(curved.radius_deg, 100 * curved.worst, style.line))
    return "".join(parts)


def _legend(found: Fig7 | None) -> str:
    """The meaning of the marks, in two columns below the map."""
    here, transfers = found.bias_deg if found else np.empty((0, 2)), _transfers(found)
    entries = legend_marks(CROSS)
    if len(here):
        entries[1] = entries[1][0], f"smallest E ({svg.number(here[0, 0])}°, {svg.number(here[0, 1])}°) off"
    entries.append(('<ellipse class="vi-x-ellipse" cx="8" cy="0" rx="8" ry="4"/>', "δθᵀQδθ, where it holds"))
    places = [(2, 175), (122, 175), (2, 191), (122, 191)]
    parts = [legend_entry(*place, *entry) for place, entry in zip(places, entries)]
    x = 2.0
    for name in transfers:
        parts.append(legend_entry(x, 207, style_of(name, transfers).sample(-2, 0), name))
        x += 36 + CHARACTER * len(name)
    return "".join(parts)


def _transfers(found: Fig7 | None) -> Sequence[str]:
    """The one of the settings first."""
    own = found.settings.transfer if found else next(iter(TRANSFERS))
    return [own, *(name for name in TRANSFERS if name != own)]
