"""The demonstrator's joints, and the learner's: their sliders, bars, and what the learner has seen of itself before."""

from viser import Icon

from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.settings import given

from ..drawing.joint_bars import draw_learner
from ..model.displayed import rehearsal_of
from ..model.page_model import PageModel
from .panel import SLOW, JointSliders, Layout, Look, put_html

WATCH, STOP, FORGET = ("Watch yourself first", Icon.EYE), ("Stop", Icon.PLAYER_STOP), ("Forget", Icon.ERASER)
HINT = f"the learner goes through {DEFAULT_POSTURES} postures, with nobody to imitate, and needs no probes then"


def demonstrator(layout: Layout, model: PageModel) -> None:
    with layout.gui.add_folder("Demonstrator"):
        layout.gui.add_html('<span class="vi-demonstrator-folder"></span>')
        inside = layout.gui.add_folder(None)
    sliders = JointSliders(layout, inside, "{}", "pose_joint")

    def show(model: PageModel) -> None:
        sliders.show(model, given(model.settings.demonstrator_deg))

    show(model)
    layout.drawing(lambda model: (model.generation, model.settings.demonstrator_deg, model.inputs), show)


def learner(layout: Layout, model: PageModel) -> None:
    """Bars beside the demonstrator's, and where it starts, folded: a slider a joint, which asks for the same as a click
    on the landscape."""
    with layout.gui.add_folder("Learner"):
        bars = layout.gui.add_html("")
        with layout.row(quiet=True):
            layout.button(
                _rehearsal_look, "rehearsal", hint=HINT, enabled=lambda model: rehearsal_of(model.session).offered
            )
            layout.html(lambda model: f'<div class="vi-remembers">{rehearsal_of(model.session).words}</div>')
        inside = layout.gui.add_folder("Start", expand_by_default=False)
    start = JointSliders(layout, inside, "Start {}", "start_joint", "degrees; the learner begins anew there")

    def bars_key(model: PageModel) -> tuple:
        shown = model.displayed
        arms = shown.learner_theta.tobytes(), shown.snapshot.theta_demo.tobytes()
        return model.generation, *arms, model.snapshot.status, shown.playback is None, shown.playing

    def draw_bars(model: PageModel) -> None:
        shown = model.displayed
        assessment = shown.assessment if shown.playback is None else None  # which is of the session's snapshot
        put_html(bars, draw_learner(model.session.scene, shown.learner_theta, shown.snapshot.theta_demo, assessment))

    def bars_period(model: PageModel) -> float:
        """They move along with the arm; numbers that change with every motion nobody reads faster."""
        return 0.0 if model.displayed.interpolated_theta is not None else SLOW

    def show_start(model: PageModel) -> None:
        start.show(model, given(model.settings.start_deg))

    layout.drawing(bars_key, draw_bars, bars_period)
    layout.drawing(lambda model: (model.generation, model.settings.start_deg, model.inputs), show_start)


def _rehearsal_look(model: PageModel) -> Look:
    rehearsal = rehearsal_of(model.session)
    return STOP if rehearsal.to_go else FORGET if rehearsal.held else WATCH
