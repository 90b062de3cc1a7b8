"""The images, and the plots: E over postures with the learner's path, or of all transfers; curves; equations; duel."""

from functools import partial
from typing import Any

from viser import Icon

from viewimit.drawing.curves import axis_end, draw_curves
from viewimit.drawing.equations import draw_equations
from viewimit.drawing.export.panels import MadeLandscape
from viewimit.drawing.glossary import ask
from viewimit.drawing.images.rectified import draw_rectified
from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..drawing import duel as drawing
from ..drawing import overlays
from ..model.page_model import PageModel
from .panel import SLOW, SLOWEST, Layout, put_html, put_properties

COMPARE, ALONE = ("Compare all transfers", Icon.LAYOUT_GRID), ("This transfer alone", Icon.SQUARE)
WORDS = overlays.asks(("bias", "basin"))  # in the lines under all transfers' landscapes
FROM_STARTS = "Try 20 starts", Icon.CHART_DOTS
CANCEL, HIDE = ("Cancel", Icon.PLAYER_STOP), ("Hide the starts", Icon.EYE_OFF)
STARTS = "Twenty learners, at most 300 steps each: where they end, within 2°, and whether they claim to have converged."
WAITING = '<div class="vi-basin">Twenty learners set out …</div>'
LOOK_ONLY = "Click a pose: a ghost arm shows it, and nothing moves. Otherwise the learner starts there."


def images(layout: Layout, model: PageModel) -> None:
    with layout.upper_tab("Images"):
        shown, links, proposed = (layout.gui.add_html("") for k in range(3))
        layout.named["images"] = shown
        layout.drawing(_images_key, partial(_draw_images, shown, proposed))
        layout.drawing(_links_key, lambda model: put_html(links, overlays.point_links(*_links_key(model))))


def _images_key(model: PageModel) -> tuple:
    view, displayed = model.view, model.displayed
    switches = view.goal, view.truth, view.chosen, view.whole_frames, view.rectified, displayed.stage
    snapshots = displayed.image_snapshot, displayed.preview
    return model.generation, *snapshots, model.edited, *switches, *displayed.pictures.values()


def _draw_images(shown: Any, proposed: Any, model: PageModel) -> None:
    view, displayed = model.view, model.displayed
    (bodies, windows), now = displayed.arms_in_images, displayed.image_snapshot
    if view.rectified:
        put_html(shown, draw_rectified(now, bodies))
        put_html(proposed, "")
        return
    marks = model.edited.proposed_in
    put_html(proposed, "" if marks is None else overlays.proposed_marks(marks, windows, view.whole_frames))
    standing = None if displayed.preview is None else displayed.look_at(model.snapshot)[0]
    seen = now.views
    places = overlays.point_places(seen.demo, seen.own, seen.visible, windows, view.whole_frames)
    put_html(shown, displayed.draw_images(displayed.stage, standing) + places)


def _links_key(model: PageModel) -> tuple:
    """What links depend on: a click on one is not lost while the arm moves."""
    points = len(model.displayed.image_snapshot.views.demo)
    return 0 if model.view.rectified else points, model.view.whole_frames


def landscape(layout: Layout, model: PageModel) -> None:
    """A click chooses a posture."""
    gui = layout.gui
    with layout.tab("Landscape"):
        ground, path = gui.add_html(""), gui.add_html("")
        preview, links = gui.add_html(""), gui.add_html("")
        cost = gui.add_html(f'<div class="vi-corner">{ask("cost")}</div>')
        run = lambda model: model.basins.run
        basin = layout.html(lambda model: "" if run(model) is None else run(model).figure or WAITING)
        layout.html(lambda model: model.comparison.html or "", visible=_compares)
        layout.html(WORDS, visible=_compares)
        with layout.row(quiet=True):
            layout.button(lambda model: ALONE if _compares(model) else COMPARE, "compare")
            layout.button(_starts_look, "starts", hint=STARTS)
            looks = lambda model: model.view.look_only
            offered = lambda model: model.view.details or model.view.look_only
            layout.checkbox("Preview the pose", looks, "switch", "look_only", hint=LOOK_ONLY, visible=offered)

        def show_own(shown: bool) -> None:
            for over in (ground, path, preview, links, cost, basin):
                put_properties(over, visible=shown)

        layout.bind(lambda model: not _compares(model), show_own)
        own_path = OwnPath(ground, path)
        layout.drawing(own_path.key, own_path.draw, own_path.period)

        def draw_preview(model: PageModel) -> None:
            moment = model.displayed.preview
            put_html(preview, "" if moment is None else overlays.draw_see_through(model.session.scene, moment))

        layout.drawing(lambda model: (model.displayed.preview, model.generation), draw_preview)
        draw_links = lambda model: put_html(links, overlays.posture_field(model.session.scene))
        layout.drawing(lambda model: (model.generation,), draw_links)


class OwnPath:
    """The landscape of the session's own transfer, and the learner's path on it."""

    def __init__(self, ground: Any, path: Any):
        self._ground, self._path = ground, path
        self._drawn: MadeLandscape | None = None

    def key(self, model: PageModel) -> tuple:
        on_its_way = model.displayed.interpolated_theta
        theta = model.snapshot.theta if on_its_way is None else on_its_way
        return model.landscape.made, model.snapshot, theta.tobytes()

    def period(self, model: PageModel) -> float:
        """Return 0 s, as for the images, while the arm moves or after a new landscape; else the period of plots."""
        at_once = model.displayed.interpolated_theta is not None or model.landscape.made is not self._drawn
        return 0.0 if at_once else SLOW

    def draw(self, model: PageModel) -> None:
        self._drawn, session = model.landscape.made, model.session
        if self._drawn is not None:
            put_html(self._ground, self._drawn.picture.html)
            on_its_way = model.displayed.interpolated_theta
            put_html(self._path, self._drawn.picture.draw_path(session.history, session.cursor, on_its_way))


def _compares(model: PageModel) -> bool:
    """Whether the landscapes of all transfers are shown."""
    return model.comparison.html is not None


def _starts_look(model: PageModel) -> tuple:
    run = model.basins.run
    return FROM_STARTS if run is None or model.comparison.on else CANCEL if run.goes_on else HIDE


def curves(layout: Layout, model: PageModel) -> None:
    """E and the joint errors of each motion. A click goes to a motion."""
    with layout.tab("Curves"):
        shown, over = layout.gui.add_html(""), layout.gui.add_html("")

        def draw(model: PageModel) -> None:
            session, made = model.session, model.landscape.made
            E_true, joints = None if made is None else made.E_true, session.scene.moving_joints
            drawn = draw_curves(session.history, session.cursor, E_true, joints, errors_deg=model.displayed.errors_deg)
            put_html(shown, drawn)

        layout.drawing(lambda model: (model.snapshot, len(model.session.history), model.landscape.made), draw, SLOW)
        draw_field = lambda end: put_html(over, f'<div class="vi-over">{overlays.motion_field(end)}</div>')
        layout.bind(lambda model: axis_end(len(model.session.history) - 1), draw_field)


def equations(layout: Layout, model: PageModel) -> None:
    """The paper's equations with their present numbers."""
    with layout.tab("Equations"):
        shown = layout.gui.add_html("")
        layout.gui.add_html(overlays.asks(("lambda", "rho", "D")))
        key = lambda model: (model.displayed.snapshot, model.view.chosen)
        layout.drawing(key, lambda model: put_html(shown, draw_equations(*key(model))), period=SLOWEST)


BEGIN, END = ("Begin duel", Icon.SWORDS), ("End duel", Icon.PLAYER_STOP)


def duel(layout: Layout, model: PageModel) -> None:
    transfers, servos = ([one.title for one in those.values()] for those in (TRANSFERS, SERVOS))
    with layout.tab("Duel"):
        with layout.row():
            transfer = lambda model: TRANSFERS[model.duel.transfer].title
            layout.dropdown("Opponent's transfer", transfers, transfer, "opponent_transfer")
            layout.dropdown("Opponent's servo", servos, lambda model: SERVOS[model.duel.servo].title, "opponent_servo")
            layout.button(lambda model: BEGIN if model.duel.opponent is None else END, "duel")
        layout.html(lambda model: model.duel_landscapes.html)
        race, errors = layout.gui.add_html(""), layout.gui.add_html("")

        def key(model: PageModel) -> tuple:
            opponent = model.duel.opponent
            both = (None, None) if opponent is None else (model.snapshot, opponent.snapshot)
            return *both, model.player.playing

        def draw(model: PageModel) -> None:
            opponent, scene = model.duel.opponent, model.session.scene
            paths = plot = ""
            if opponent is not None:
                standings = model.duel.standings
                paths = drawing.draw_race(scene, (model.session, opponent), standings, model.player.playing)
                if len(scene.moving_joints) == 2:
                    plot = drawing.draw_errors_alone(standings)
            put_html(race, paths)
            put_html(errors, plot)

        layout.drawing(key, draw)
