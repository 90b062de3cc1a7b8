"""The demonstrator's joints, and the learner's: their sliders, bars, and what the learner has seen of itself before."""

from collections.abc import Sequence

from viser import Icon

from viewimit.drawing.svg import number
from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.settings import given

from ..drawing.joint_bars import draw_learner
from ..model.displayed import rehearsal_of
from ..model.page_model import PageModel
from .panel import SLOW, JointSliders, Layout, Look, put_html

WATCH, STOP, FORGET = ("Watch yourself first", Icon.EYE), ("Stop", Icon.PLAYER_STOP), ("Forget", Icon.ERASER)
MANY = 4  # joints, whose angles are too long for a folder's name
HINT = f"the learner goes through {DEFAULT_POSTURES} postures, with nobody to imitate, and needs no probes then"


def demonstrator(layout: Layout, model: PageModel) -> None:
    """First of what stays in sight on every window: in a folder without a frame, which `playback.copy` goes on with."""
    layout.named["tray"] = layout.gui.add_folder("Pose and play")
    with layout.named["tray"]:
        layout.gui.add_html('<h3 class="vi-part vi-tray"><b>1</b> Pose the demonstrator</h3>')
        inside = layout.gui.add_folder(None)
        layout.gui.add_html('<div class="vi-or">… or drag its hand in the scene</div>')
    sliders = JointSliders(layout, inside, "{}", "pose_joint")

    def show(model: PageModel) -> None:
        sliders.show(model, given(model.settings.demonstrator_deg))

    show(model)
    layout.drawing(lambda model: (model.generation, model.settings.demonstrator_deg, model.inputs), show)


def learner(layout: Layout, model: PageModel) -> None:
    """Bars beside the demonstrator's."""
    layout.gui.add_html(
        '<h3 class="vi-part">Learner <span>(<i class="vi-is-now"></i> now, <i class="vi-is-goal vi-tells"></i>'
        '<span class="vi-tells"> goal</span>)</span></h3>'
    )
    bars = layout.gui.add_html("")

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

    layout.drawing(bars_key, draw_bars, bars_period)


def start(layout: Layout, model: PageModel) -> None:
    """Where the learner starts: a slider a joint, which asks for the same as a click on the landscape; and what it has
    seen of itself before."""
    folder = layout.folder("Start", lambda model: _angles(given(model.settings.start_deg)))
    with folder:
        with layout.row(quiet=True):
            layout.button(
                _rehearsal_look, "rehearsal", hint=HINT, enabled=lambda model: rehearsal_of(model.session).offered
            )
            layout.html(lambda model: f'<div class="vi-remembers">{rehearsal_of(model.session).words}</div>')
        inside = layout.gui.add_folder(None)
    sliders = JointSliders(layout, inside, "Start {}", "start_joint", "the learner begins anew there")

    def show_start(model: PageModel) -> None:
        sliders.show(model, given(model.settings.start_deg))

    layout.drawing(lambda model: (model.generation, model.settings.start_deg, model.inputs), show_start)


def _angles(angles_deg: Sequence[float]) -> str:
    return ", ".join(f"{number(angle, 0)}°" for angle in angles_deg) if len(angles_deg) < MANY else "own"


def _rehearsal_look(model: PageModel) -> Look:
    rehearsal = rehearsal_of(model.session)
    return STOP if rehearsal.to_go else FORGET if rehearsal.held else WATCH
