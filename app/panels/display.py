"""How the page shows the session: a chosen point, layout, camera images, switches, colours, the default camera; and
what a small window shows of it."""

import html

from viser import Icon

from viewimit.drawing.export.perspective import draw_space
from viewimit.drawing.svg import count_points
from viewimit.simulation.eyes import require_eyes

from ..drawing.overlays import LESS, MORE, draw_body_points, link
from ..model.choices import LARGE, NO_POINT, chosen_layout, layout_choices
from ..model.page_model import PageModel
from .panel import SLOWEST, Layout, put, put_html, put_properties

SWITCHES = (
    ("Goal in L and R", "goal"),
    ("Rays", "rays"),
    ("Residuals, 3-D", "residuals"),
    ("Hand gizmo", "gizmo"),
    ("Whole frames", "whole_frames"),
    ("Raw, rectified", "rectified"),
    ("Shadows", "shadows"),
    ("Details", "details"),
    ("Still picture", "flat"),
    ("Dark", "dark"),
)
ICONS = {  # 24 x 24, strokes
    "images": '<path d="M4 4h6v16H4zM14 4h6v16h-6z"/>',
    "landscape": '<ellipse cx="12" cy="12" rx="9" ry="8"/><ellipse cx="12" cy="12" rx="4.5" ry="3.5"/>',
    "controls": '<path d="M3 8h12M19 8h2M3 16h2M9 16h12"/><circle cx="17" cy="8" r="2"/><circle cx="7" cy="16" r="2"/>',
    "scene": '<path d="M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9"/>',
}
VIEWS = {"images": "Images", "landscape": "Landscape", "controls": "Controls", "scene": "3-D"}


def display(layout: Layout, model: PageModel) -> None:
    gui, queue = layout.gui, layout.queue
    with layout.folder("Display"):
        chosen = gui.add_dropdown("Point", [NO_POINT], initial_value=NO_POINT)
        points = gui.add_dropdown("Layout", [count_points(10)])
        rectify = gui.add_checkbox("Rectify", True, hint="the pictures, where their matched points ask for it")
        camera = layout.checkbox("Camera pictures", lambda model: model.settings.sensor == "rendered", "camera")
        why_not = gui.add_html("", visible=False)
        shows = lambda name: lambda model: model.view.on(name)
        for label, name in SWITCHES:
            layout.checkbox(label, shows(name), "switch", name)
        layout.button(("Fit view", None), "fit_view")
    queue.on_value(chosen, "choose_point")
    queue.on_value(points, "points")
    layout.value(rectify, lambda model: model.settings.rectify == "auto", "rectify")
    layout.named["camera"] = camera

    def offer(model: PageModel) -> None:
        """The choices that depend on the scene and its images."""
        pictured = model.settings.sensor == "rendered"  # which show the markers that the robot wears, in one layout
        count = len(model.session.world.body)
        why = ""
        try:
            require_eyes("rendered", model.session.scene)
        except ValueError as reason:  # no camera images can be had of this scene here
            why = f'<div class="vi-why">{html.escape(str(reason))}</div>'
        put_properties(camera, disabled=bool(why))
        put_html(why_not, why)
        put_properties(why_not, visible=bool(why))
        points.options = [_count_markers(count)] if pictured else list(layout_choices(model.settings))
        points.disabled = pictured
        chosen.options = [NO_POINT, *(str(i) for i in range(count))]
        show(model)

    def show(model: PageModel) -> None:
        pictured, count = model.settings.sensor == "rendered", len(model.session.world.body)
        put(chosen, NO_POINT if model.view.chosen is None else str(model.view.chosen))
        put(points, _count_markers(count) if pictured else chosen_layout(model.settings))

    def set_theme(dark: bool) -> None:
        if layout.named.get("dark", False) != dark:
            layout.named["dark"] = dark
            gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)

    layout.drawing(lambda model: (model.generation,), offer)
    layout.drawing(lambda model: (model.view.chosen, model.settings, model.inputs), show)
    layout.bind(lambda model: model.view.on("dark"), set_theme)


def _count_markers(count: int) -> str:
    return f"{count} marker{'' if count == 1 else 's'}"


def still(layout: Layout, model: PageModel) -> None:
    """What takes the place of the 3-D view in a browser without WebGL, or too slow for it, or where it is chosen."""
    picture = layout.gui.add_html("")

    def key(model: PageModel) -> tuple:
        return (model.displayed.scene_snapshot, model.view.truth, model.view.rays) if model.view.flat else (None,)

    def draw(model: PageModel) -> None:
        if not model.view.flat:
            return put_html(picture, "")
        view, moment = model.view, model.displayed.scene_snapshot
        drawn = draw_space(model.session.world, moment, None, view.rays, True, view.truth)
        box = f'viewBox="0 0 {drawn.width} {drawn.height:.0f}" role="img" aria-label="{drawn.title}"'
        put_html(picture, f'<div class="vi-flat"><svg class="vi" {box}>{drawn.inside}</svg></div>')

    layout.drawing(key, draw, period=SLOWEST)


def views(layout: Layout, model: PageModel) -> None:
    """The tabs of a window that is too small for all at once: layout.css shows the chosen one."""
    tabs = "".join(
        f'<input type="radio" name="vi-view" id="vi-view-{name}"{" checked" if name == "images" else ""}>'
        f'<label for="vi-view-{name}"><svg viewBox="0 0 24 24" aria-hidden="true">{ICONS[name]}</svg>{label}</label>'
        for name, label in VIEWS.items()
    )
    layout.gui.add_html(f'<div class="vi-views" role="radiogroup" aria-label="View">{tabs}</div>')


def enlarge(layout: Layout, model: PageModel) -> None:
    """Declare the large panel, and the links that enlarge one, in every tab of the upper panel. A browser has only the
    open tab's widgets. To be built after all tabs."""
    for tab in layout.upper_tabs.values():
        with tab:
            layout.html(lambda model: _enlarge_links(model.view.large, model.view.details))


def _enlarge_links(large: str | None, details: bool) -> str:
    """Links that enlarge the panels, and which of them or of the images is large, and whether details are shown:
    layout.css does it."""
    icon = f'<svg viewBox="-6 -6 12 12" aria-hidden="true"><path d="{LESS if large else MORE}"/></svg>'
    links = "".join(
        f'<div class="vi-enlarge vi-enlarge-{what}">{link(f"large/{LARGE.index(shown)}", name, icon)}</div>'
        for what, shown, name in (
            ("images", large if large not in (None, "figures") else "images", "Pictures, large or not"),
            ("figures", "figures", "Figures, large or not"),
        )
    )
    mark = f'<i class="vi-large vi-large-{large}"></i>' if large else ""
    mark += '<i class="vi-details"></i>' if details else ""
    return f'<div class="vi-larger-links">{links}</div>{mark}'


EDIT, DONE = ("Edit points", Icon.POINT), ("Done", Icon.CHECK)
PROPOSE, TAKE = ("Best next", Icon.BULB), ("Take it", Icon.BULB)
ABOUT = "Mark both arms yourself: click an arm to place a point, or a point to choose it."


def points(layout: Layout, model: PageModel) -> None:
    with layout.folder("Points", lambda model: str(len(model.session.world.body))), layout.row(quiet=True):
        layout.button(lambda model: DONE if model.edited.on else EDIT, "edit_points", hint="on both arms, by clicks; E")
        layout.button(("Save scene", Icon.DOWNLOAD), "scene", hint="as a file for viewimit imitate --scene")
        look = lambda model: PROPOSE if model.edited.proposal is None else TAKE
        waits = lambda model: model.edited.on and not model.edited.searching
        layout.button(look, "best", hint="the point that would help most; B", enabled=waits)
        has_chosen = lambda model: model.edited.on and model.view.chosen is not None
        layout.button(("Remove", Icon.TRASH), "remove", hint="the chosen point; Delete", enabled=has_chosen)
        status = layout.gui.add_html("")

    def draw(model: PageModel) -> None:
        points, joints = model.edited, model.session.scene.moving_joints
        content = ABOUT
        if points.information is not None:
            content = draw_body_points(joints, points.information, points.proposal, points.searching)
        put_html(status, f'<div class="vi-edited">{content}</div>')

    layout.drawing(lambda model: (model.edited, model.generation), draw)
