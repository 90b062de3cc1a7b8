"""Preset, its lesson, and the buttons that move the learner; which motion is shown, and the speed."""

from viser import Icon

from viewimit.drawing.glossary import key_of
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.settings import MAX_SEED, given
from viewimit.servo import SERVOS

from ..drawing.joint_bars import draw_learner
from ..drawing.overlays import beside
from ..model.choices import (
    OF_ARMS,
    OF_IMAGES,
    SPEEDS,
    Amount,
    chosen_joints,
    joint_choices,
    modified,
    servo_names,
    transfer_names,
)
from ..model.displayed import rehearsal_of
from ..model.page_model import PageModel
from .panel import SLOW, JointSliders, Layout, Look, put, put_html, put_max

MOTIONS = {"Step": "step", "Undo": "undo", "Reset": "reset"}  # commands
LONG = 1000  # motions, whose number leaves no room for another beside the slider


def playback(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    preset = gui.add_dropdown("Preset", list(model.presets.offered), initial_value=model.preset.name)
    layout.queue.on_value(preset, "preset")
    more: tuple[str, ...] = ()  # options besides the presets

    def show_preset(model: PageModel) -> None:
        """One that was changed is an entry of its own, so that the preset itself can be chosen again, and so is one
        that is not of the list."""
        nonlocal more
        offered, names = model.presets.offered, (model.preset.name, _name(model))
        if more != (now := tuple(name for name in dict.fromkeys(names) if name not in offered)):
            more = now
            preset.options = (*offered, *more)
        put(preset, _name(model))

    layout.drawing(lambda model: (_name(model), model.preset.name, model.inputs), show_preset)
    layout.html(lambda model: f'<div class="vi-lesson">{model.preset.lesson}</div>')
    gui.add_html('<span class="vi-play-row"></span>')
    layout.button(
        lambda model: ("Pause", Icon.PLAYER_PAUSE) if model.player.playing else ("Play", Icon.PLAYER_PLAY), "play"
    )
    motion = gui.add_button_group("Motion", list(MOTIONS))

    @motion.on_click
    async def _(event) -> None:
        if event.target.value in MOTIONS:
            layout.queue.call(MOTIONS[event.target.value])


def history(layout: Layout, model: PageModel) -> None:
    count = layout.gui.add_html("")
    slider = layout.slider("History", 0, 1, 1, lambda model: model.player.cursor, "moment", period=SLOW)

    def show_length(model: PageModel) -> None:
        cursor, last = model.player.cursor, model.player.last
        at = f"{cursor} " if last < LONG else ""  # it stands in the slider's box too
        put_max(slider, max(last, 1))
        put(slider, cursor)
        put_html(count, f'<div class="vi-count"><span>{at}of {last}</span></div>')

    layout.drawing(lambda model: (model.player.cursor, model.player.last), show_length, period=SLOW)
    layout.dropdown("Speed", list(SPEEDS), _speed, "speed", period=SLOW)


def _name(model: PageModel) -> str:
    """The preset, as the list has it."""
    return modified(model.preset.name) if model.modified else model.preset.name


def _speed(model: PageModel) -> str:
    return next(name for name, value in SPEEDS.items() if value == model.player.speed)


# The demonstrator's joints, and the learner's: their sliders, bars, and what the learner has seen of itself before.

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


# Transfer, servo, and the joints that imitate; and what makes it harder, the less frequent disturbances folded.


def method(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    with gui.add_folder("Method"):
        gui.add_html(beside("transfer"))
        transfers, servos = list(transfer_names().values()), list(servo_names().values())
        layout.dropdown("Transfer", transfers, lambda model: TRANSFERS[model.settings.transfer].title, "transfer")
        gui.add_html(beside("servo"))
        layout.dropdown("Servo", servos, lambda model: SERVOS[model.settings.servo].title, "servo")
        joints = gui.add_dropdown("Joints", ["–"], initial_value="–")
        layout.queue.on_value(joints, "joints")
    offered: list[str] = []

    def show_joints(model: PageModel) -> None:
        nonlocal offered
        choices = joint_choices(model.settings)
        if offered != list(choices):
            offered = joints.options = list(choices)
        put(joints, chosen_joints(model.settings, choices))

    layout.drawing(lambda model: (model.generation, model.settings.joints, model.inputs), show_joints)


def disturbances(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    with gui.add_folder("Disturbances"):
        for amount in OF_IMAGES:
            _add_amount(layout, amount, model)
        with gui.add_folder("Arm and chance", expand_by_default=False):
            for amount in OF_ARMS:
                _add_amount(layout, amount, model)
            seed = gui.add_number("Seed", model.settings.seed, min=0, max=MAX_SEED, step=1)
            layout.value(seed, lambda model: model.settings.seed, "seed")


def _add_amount(layout: Layout, amount: Amount, model: PageModel) -> None:
    """A slider, which reaches farther if the page is asked to begin there."""
    begun = amount.shown(model.settings)
    low, high = min(amount.low, begun), max(amount.high, begun)
    if (key := key_of(amount.label)) is not None:
        layout.gui.add_html(beside(key))
    shown = lambda model: amount.shown(model.settings)
    layout.slider(amount.label, low, high, amount.step, shown, "disturbance", amount.name, hint=amount.hint)
