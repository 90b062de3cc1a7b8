"""What stands over and beside the library's drawings: links, whose action the page's script sends; bars of joints."""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.observability import PointInformation, Proposal, unobservable_joints
from viewimit.analysis.self_assessment import Assessment
from viewimit.drawing import svg
from viewimit.drawing.curves import arrange_plots, plot_box
from viewimit.drawing.glossary import ask, cards, describe_entry, glossary
from viewimit.drawing.images.panel import HEADINGS
from viewimit.drawing.images.planes import SIZES, Window, Windows, image_points, placed
from viewimit.drawing.landscape import HINT, HINT_PLACE, describe_costs, draw_bars
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.estimation.transfers.transfer import FLATNESS
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import MIN_POINTS
from viewimit.loop.snapshot import Snapshot
from viewimit.servo.certificate import MAX_STD_PER_PX
from viewimit.simulation.scene import Scene
from viewimit.wording import sentences

from ..model.choices import joint_name


def link(what: str, name: str, inside: str, stop: bool = True) -> str:
    """Build one link. what: the action, as control/value; name: what a screen reader says; inside: HTML or SVG of the
    link; stop: whether the Tab key stops there."""
    more = f' aria-label="{svg.escape(name)}"' if stop else ' tabindex="-1" aria-hidden="true"'
    return f'<a href="#" data-do="{what}"{more}>{inside}</a>'


def button(what: str, name: str, inside: str) -> str:
    """Build a link that a screen reader announces as a button."""
    return link(what, name, inside).replace("<a ", '<a role="button" ', 1)


# Layers over the library's drawings: links on image points, postures and motions, and marks of previewed postures.
# A layer stays while the drawing below it changes, so that a click is not lost when the arm moves. A style moves its
# parts to the present places.

MORE, LESS = "M1-4h3v3M-1 4h-3v-3M4-4l-3 3M-4 4l3-3", "M4-1h-3v-3M-4 1h3v3M1-1l3-3M-1 1l-3 3"  # icons, 12 px
SQUARE = '<rect x="-8" y="-8" width="16" height="16" rx="3"/>'  # around an icon
HIT, HALO = 12, 11  # px, radii of a point's link and of its mark
MIN_HIT = 1.5  # px, radius of the link of a crowded point
FIRST_IMAGE = 2  # among the panels that can be enlarged: the images follow two others
PROPOSED = 4.5  # px, radius
NUMBER_DROP = 4  # px from a point's centre down to the foot of its number
CURVES_WIDTH = 424  # px
AIM, ARM = 8, 13  # px, cross hair: radius of its ring, length of its lines


def point_links(count: int, whole: bool) -> str:
    """Build links over the four images, whole or not. Tab stops at the points of L, as the other images repeat them.
    Each point has two links: a circle of radius HIT, and above all of these the part where it is the nearest point."""
    if not count:
        return ""
    inside = {}
    for k, (view, size) in enumerate(SIZES[whole].items()):
        around = "".join(_link(view, i, "vi-around") for i in range(count))
        nearest = "".join(_link(view, i, "vi-nearest", stop=view == "L") for i in range(count))
        icon = f'<g class="vi-larger" transform="translate({size[0] / 2:g} 10)">{SQUARE}<path d="{MORE}"/></g>'
        large = link(f"large/{FIRST_IMAGE + k}", f"Enlarge picture {view}", icon)
        inside[view] = around + nearest + large
    construct = link("construction/0", "Build up how the point is transferred", "▸ Build it up <kbd>C</kbd>")
    return _over_images(inside, construct, whole, " vi-links", ' role="group" aria-label="Points to choose"')


def proposed_marks(views: FourViews, windows: Windows, whole: bool) -> str:
    """Draw a ring in each of the four images where a proposed point would be. views: of this one point."""
    rings = {}
    for view, (x, y) in zip("lrLR", placed(image_points(views), windows[whole], "lrLR")[:, 0].tolist()):
        ring = f'<circle class="vi-proposed" cx="{x:.1f}" cy="{y:.1f}" r="{PROPOSED}"/>'
        rings[view] = ring if views.usable[0] else ""
    return _over_images(rings, "", whole)


def _over_images(inside: Mapping[str, str], how: str, whole: bool, classes: str = "", attributes: str = "") -> str:
    """Wrap drawings by view in the panel's arrangement, so that each lies over its image. how: HTML of its sentence."""
    drawings = [f'<div class="vi-heading vi-over-{pair}" aria-hidden="true"></div>' for pair in HEADINGS]
    drawings += [  # only their links receive clicks
        f'<svg class="vi vi-at-{view}" viewBox="0 0 {width} {height}">{inside[view]}</svg>'
        for view, (width, height) in SIZES[whole].items()
    ]
    drawings.append(f'<p class="vi-how">{how}</p>')
    kind = f"vi-images{' vi-whole' if whole else ''}"
    return (
        f'<div class="vi-above{classes}"><div class="vi-panel vi-four"><div class="{kind}"{attributes}>'
        f"{''.join(drawings)}</div></div></div>"
    )


def _link(view: str, i: int, kind: str, stop: bool = False) -> str:
    name = str(i)
    shown = f'<circle class="vi-touched" r="{HALO}"/><text class="vi-b vi-mid" y="{NUMBER_DROP}">{name}</text>'
    inside = f'<g class="vi-at-{view}{i}"><circle class="{kind}" r="{HIT}"/>{shown}</g>'
    return link(f"point/{i}", f"point {name}", inside, stop)


def point_places(
    demo: NDArray[np.float64], own: NDArray[np.float64], visible: NDArray[np.bool_], windows: Windows, whole: bool
) -> str:
    """Build a style that moves links to their points and hides those of invisible ones. Arrays as in `FourViews`."""
    shown = windows[whole]
    rules = _resting_rules(demo.tobytes(), visible[:, :2].tobytes(), (shown["l"], shown["r"]), whole)
    return f"<style>{rules}{_rules(own, visible[:, 2:], shown, whole, 'LR')}</style>"


@lru_cache(64)  # the demonstrator mostly rests while the learner moves
def _resting_rules(demo: bytes, visible: bytes, windows: tuple[Window, Window], whole: bool) -> str:
    points, seen = np.frombuffer(demo).reshape(-1, 4), np.frombuffer(visible, bool).reshape(-1, 2)
    return _rules(points, seen, dict(zip("lr", windows)), whole, "lr")


def _rules(
    images: NDArray[np.float64], visible: NDArray[np.bool_], windows: Mapping[str, Window], whole: bool, pair: str
) -> str:
    """Write the rules of a body's points in a pair of views. images: (N, 4) px; visible: (N, 2)."""
    points = placed(images.reshape(-1, 2, 2).transpose(1, 0, 2), windows, pair)
    inside = ((points >= 0) & (points <= _SIZES[whole, pair])).all(-1) & visible.T
    numbers, hidden = np.concatenate([points, _free_radii(points, inside)[..., None]], -1), ""
    if not inside.all():
        numbers[~inside] = 0
        hidden = "".join([f".vi-at-{pair[k]}{i}{{display:none}}" for k, i in np.argwhere(~inside).tolist()])
    return svg.filled(_form(len(images), pair), numbers) + hidden


_SIZES = {
    (whole, pair): np.array([sizes[view] for view in pair])[:, None]
    for whole, sizes in SIZES.items()
    for pair in ("lr", "LR")
}


@lru_cache(16)
def _form(count: int, pair: str) -> str:
    """Write the rules of `count` points with a %s for each x, y and radius; one format is faster than many."""
    rule = ".vi-at-{0}{1}{{transform:translate(%spx,%spx)}}.vi-at-{0}{1} .vi-nearest{{r:%spx}}"
    return "".join(rule.format(view, i) for view in pair for i in range(count))


def _free_radii(points: NDArray[np.float64], there: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return half the distance to the nearest other visible point, so that no circles meet. (2, N, 2) → (2, N) px."""
    places = points.view(complex)[..., 0]
    distance = np.abs(places[:, :, None] - places[:, None]) + _to_itself(points.shape[1])
    if not there.all():
        distance = np.where(there[:, None], distance, np.inf)
    return np.minimum(np.maximum(distance.min(-1, initial=np.inf) / 2, MIN_HIT), HIT)


@lru_cache(16)
def _to_itself(count: int) -> NDArray[np.float64]:
    """Return a (count, count) matrix whose diagonal is infinite: no point is its own neighbour."""
    return np.diag(np.full(count, np.inf))


# Fields, in which a click stands for the values at its place: the page's script works them out. Keys have sliders.


def field(control: str, box: tuple[float, float, float, float], *values: float) -> str:
    """Build a field. box: left, top, width and height, px; values: at its left and right, and at its bottom and top."""
    left, top, width, height = box
    place = f'x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f'<rect class="vi-field" {place} data-field="{control}" data-values="{",".join(f"{v:g}" for v in values)}"/>'


def posture_field(scene: Scene) -> str:
    """Build the field over a landscape; "" without two moving joints."""
    plane = PosturePlane(scene)
    if not plane.has_plane:
        return ""
    left, top, *__ = plane.box
    hint = svg.text(left + HINT_PLACE[0], top + HINT_PLACE[1], HINT, "vi-2nd vi-halo vi-hint")
    up, across = scene.range_deg
    return plane.wrap(hint + field("posture", plane.box, *across, *up), "vi-over vi-links")


def motion_field(end: int) -> str:
    """Build a field over each plot of the curves. end: of their axis, motions."""
    left, top, right, bottom = plot_box(CURVES_WIDTH)
    shown = field("moment", (left, top, right - left, bottom - top), 0, end)
    hint = svg.text(CURVES_WIDTH, 12, "click: go back to that step", "vi-2nd vi-end vi-hint")
    return f'<div class="vi-panel vi-links">{arrange_plots(CURVES_WIDTH, hint + shown, shown)}</div>'


def draw_see_through(scene: Scene, moment: Snapshot) -> str:
    """Draw a cross hair on the landscape at a previewed posture."""
    plane = PosturePlane(scene)
    if not plane.has_plane:
        return ""
    x, y = plane.place(np.degrees(moment.theta)).tolist()
    hair = (
        f"M{x - ARM:.1f} {y:.1f}h{ARM - 3}m6 0h{ARM - 3}M{x:.1f} {y - ARM:.1f}v{ARM - 3}m0 6v{ARM - 3}"
        + svg.circles(np.array([[x, y]]), AIM)
    )
    return plane.wrap(f'<path class="vi-aim-case" d="{hair}"/><path class="vi-aim" d="{hair}"/>', "vi-over")


def describe_see_through(scene: Scene, moment: Snapshot) -> str:
    """Describe a previewed posture, and that the arm has not moved."""
    posture = ", ".join(svg.degrees(angle) for angle in moment.theta) if len(moment.theta) < 4 else "this pose"
    if not np.isfinite(moment.E):
        return f"At ({posture}) too few points are visible for an E. The arm has not moved."
    return f"At ({posture}) E would be {svg.short(moment.E)} px². The arm has not moved."


# The glossary on the page: every "?", the cards with links to examples, and the numbers' values on their scales.


def asks(keys: Iterable[str]) -> str:
    """Build a line of symbols, each with its "?"."""
    items = "".join(f"<span>{svg.escape(glossary()[key].symbol)} {ask(key)}</span>" for key in keys)
    return f'<div class="vi-asked">{items}</div>'


def beside(key: str) -> str:
    """Build a "?" at the label of the control that follows, where it takes no room."""
    return f'<div class="vi-at-label">{ask(key)}</div>'


def linked_cards() -> str:
    """Build all cards with links to their examples."""
    return cards(_show)


def listed() -> str:
    """Build all entries for the help, with links to their examples."""
    return "".join(
        f'<div class="vi-entry">{_show(key)}{describe_entry(entry)}</div>' for key, entry in glossary().items()
    )


def current_values(values: Mapping[str, float]) -> str:
    """Build a style that marks the present values on the cards' scales, so that open cards stay as they are. values: by
    key; NaN is left out."""
    rules = []
    for key, value in values.items():
        scale = glossary()[key].scale
        if scale is not None and math.isfinite(value):
            number = str(value) if isinstance(value, int) else svg.short(value)  # a count has no decimals
            words = f'"now {number}{scale.unit}"'
            rules.append(f"#vi-word-{key}{{--now:{100 * scale.share(value):.1f}%;--words:{words}}}")
    return f"<style>{''.join(rules)}</style>"


def _show(key: str) -> str:
    """Build the link to an entry's example."""
    entry = glossary()[key]
    words = "Show me a bad one" if entry.bad else "Show me"
    return f'<span class="vi-show">{link(f"show/{key}", f"{words}: {entry.symbol}", words)}</span>'


# Bars of joints beside the sliders: the learner's posture, and what body points tell about each joint.

WIDTH, NARROW, HEIGHT, INSET = 150, 74, 22, 8  # px of a posture bar, in one column and in two
MIN_IN_COLUMNS = 4  # joints that stand in two columns, so that they fit beside the demonstrator's sliders
POINTS_WIDTH, ROW = 250, 19  # px of the drawing of body points, and per joint
MAX_NAMED = 3  # joints of which a sentence names all


def draw_learner(
    scene: Scene, theta: NDArray[np.float64], theta_demo: NDArray[np.float64], assessment: Assessment | None = None
) -> str:
    """Draw a bar per joint with the learner's angle, the demonstrator's mark and the gap. theta, theta_demo: (m,) rad;
    assessment: what the learner knows of its joints: an unobservable one has a hatched band."""
    rows, columns = [], len(theta) >= MIN_IN_COLUMNS
    band = np.zeros(len(theta))
    if assessment is not None:
        band[assessment.unobservable] = np.maximum(assessment.std_per_px[assessment.unobservable], MAX_STD_PER_PX)
    width = NARROW if columns else WIDTH
    limits = zip(scene.lower.tolist(), scene.upper.tolist())
    each = zip(scene.moving_joints, theta.tolist(), theta_demo.tolist(), limits)
    for k, (joint, own, demo, (low, high)) in enumerate(each):
        place = lambda angle, low=low, high=high: INSET + (width - 2 * INSET) * (angle - low) / (high - low)
        x, mark, y = place(own), place(demo), HEIGHT / 2
        name = svg.joint_symbol(joint) if columns else joint_name(scene, joint)
        rows.append(
            f'<div class="vi-bar"><span>{name}</span><svg viewBox="0 0 {width} {HEIGHT}">'
            f'<line x1="{INSET}" x2="{width - INSET}" y1="{y}" y2="{y}" class="vi-bar-rail"/>'
            f"{_band(place(max(own - band[k], low)), place(min(own + band[k], high))) if band[k] else ''}"
            f'<line x1="{x:.1f}" x2="{mark:.1f}" y1="{y}" y2="{y}" class="vi-bar-gap"/>'
            f'<path d="M{mark:.1f} {y - 5.5}l5.5 5.5l-5.5 5.5l-5.5 -5.5z" class="vi-bar-demonstrator"/>'
            f'<circle cx="{x:.1f}" cy="{y}" r="5" class="vi-bar-learner"/></svg><b>{svg.degrees(own)}</b></div>'
        )
    return f'<div class="vi-bars{" vi-many" if columns else ""}">{"".join(rows)}</div>'


def _band(left: float, right: float) -> str:
    """Draw a hatched band between two px, by strokes, because a pattern would need an id of its own on the page."""
    strokes = "".join(f"M{x:.1f} {HEIGHT - 4}l4-14" for x in np.arange(left, right - 4, 5))
    edge = f'<rect x="{left:.1f}" y="3.5" width="{right - left:.1f}" height="{HEIGHT - 7}" rx="3"/>'
    return f'<g class="vi-bar-unobservable">{edge}<path d="{strokes}"/></g>'


def draw_body_points(
    joints: Sequence[int], information: PointInformation, proposal: Proposal | None, searching: bool
) -> str:
    """Draw what the body points tell, while they are edited: their number, flatness, and a bar per joint. joints:
    numbers of the moving ones, from 1; information: what the present points tell; proposal: the best further point, if
    it is known; searching: whether it is being computed."""
    lines = [f"<b>{_count(information)}</b>{_flatness(information)}"]
    spread = information.std_per_px
    if spread is not None:
        box, bars = f"0 0 {POINTS_WIDTH} {ROW * len(joints)}", draw_bars(joints, spread, POINTS_WIDTH, ROW)
        lines.append(f'Joint error per pixel of noise<svg class="vi" viewBox="{box}">{bars}</svg>')
    words = _next_point(joints, proposal, searching)
    return "".join(f"<div>{line}</div>" for line in (*lines, svg.escape(words)) if line)


def describe_body_points(
    joints: Sequence[int], information: PointInformation, proposal: Proposal | None, searching: bool
) -> str:
    """Say the same in a sentence or two; parameters as for `draw_body_points`."""
    spread = information.std_per_px
    costs = f"a transfer needs {MIN_POINTS}" if spread is None else _worst_costs(joints, spread)
    words = "; ".join(filter(None, (_count(information), costs, _flatness(information))))
    return sentences(words, _next_point(joints, proposal, searching) or "Click an arm to place one.")


def _count(information: PointInformation) -> str:
    count, seen = information.count, information.visible
    return svg.count_points(count) + ("" if seen == count else f", {seen} in all pictures")


def _flatness(information: PointInformation) -> str:
    if information.std_per_px is None or not np.isfinite(information.flatness):
        return ""
    return f"{FLATNESS} {svg.number(information.flatness, 0)}"


def _next_point(joints: Sequence[int], proposal: Proposal | None, searching: bool) -> str:
    if searching:
        return "Looking for the best next point …"
    if proposal is None:
        return ""
    after = proposal.after.std_per_px
    return f"The hollow point would help most{'' if after is None else f': {_worst_costs(joints, after)}'}."


def _worst_costs(joints: Sequence[int], spread: NDArray[np.float64]) -> str:
    """Describe all of few joints; of many, the costliest and the unobservable ones. spread: (m,) rad/px."""
    if len(joints) <= MAX_NAMED:
        return describe_costs(joints, spread)
    unobservable = unobservable_joints(spread)
    worst = [k for k in np.argsort(-spread) if k not in unobservable][:1]
    chosen = [*worst, *sorted(unobservable)]
    return describe_costs([joints[k] for k in chosen], spread[chosen], are_worst=True)
