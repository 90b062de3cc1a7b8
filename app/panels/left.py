"""Preset, its lesson, and the buttons that move the learner; which motion is shown, and the speed."""

from collections.abc import Sequence

from viser import Icon

from viewimit.drawing.glossary import key_of
from viewimit.drawing.svg import number
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.settings import MAX_SEED, given
from viewimit.servo import SERVOS

from ..drawing.overlays import beside, draw_learner
from ..model import choices
from ..model.editing import Rehearsal
from ..model.page_model import PageModel
from .panel import SLOW, JointSliders, Layout, Look, put, put_html, put_max

MOTIONS = {"Step": "step", "Undo": "undo", "Reset": "reset"}  # commands
PLAY, PAUSE = ("Play", Icon.PLAYER_PLAY), ("Pause", Icon.PLAYER_PAUSE)
FOLLOWING = "Following · pause", Icon.PLAYER_PAUSE


def situation(layout: Layout, model: PageModel) -> None:
    """The preset, with a sentence on what it shows."""
    gui = layout.gui
    gui.add_html('<span class="vi-situation"></span>')
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
    layout.html(lambda model: f'<div class="vi-lesson">{model.preset.says}</div>')


def copy(layout: Layout, model: PageModel) -> None:
    """The buttons that move the learner."""
    gui = layout.gui
    with layout.named["tray"]:
        gui.add_html('<h2 class="vi-part"><b>2</b> Let the learner copy it</h2>')
        gui.add_html('<span class="vi-play-row"></span>')
        layout.button(_play_look, "play")
    gui.add_html('<span class="vi-steps-row"></span>')
    motion = gui.add_button_group("Motion", list(MOTIONS))

    @motion.on_click
    async def call_chosen(event) -> None:
        if event.target.value in MOTIONS:
            layout.queue.call(MOTIONS[event.target.value])


def _play_look(model: PageModel) -> Look:
    """A learner that rests while the page plays goes on as soon as the demonstrator moves."""
    if not model.player.playing:
        return PLAY
    return FOLLOWING if model.snapshot.status.is_at_rest and not model.snapshot.servo.slow else PAUSE


def history(layout: Layout, model: PageModel) -> None:
    count = layout.gui.add_html("")
    slider = layout.slider("History", 0, 1, 1, lambda model: model.player.cursor, "moment", period=SLOW)

    def show_length(model: PageModel) -> None:
        cursor, last = model.player.cursor, model.player.last
        put_max(slider, max(last, 1))
        put(slider, cursor)
        step = f"Step {cursor} of {last}"
        put_html(count, f'<div class="vi-count"><span>{step}</span></div>')

    layout.drawing(lambda model: (model.player.cursor, model.player.last), show_length, period=SLOW)
    # of a speed that only links have, the nearest
    speed = lambda model: min(choices.SPEEDS, key=lambda name: abs(choices.SPEEDS[name] - model.player.speed))
    layout.dropdown("Speed", list(choices.SPEEDS), speed, "speed", period=SLOW)


def _name(model: PageModel) -> str:
    """The preset, as the list has it."""
    return choices.modified(model.preset.name) if model.modified else model.preset.name


WATCH, STOP = ("Watch yourself first", Icon.EYE), ("Stop", Icon.PLAYER_STOP)
FORGET = "Forget", Icon.ERASER
MANY = 4  # joints, whose angles are too long for a folder's name
HINT = f"The learner goes through {DEFAULT_POSTURES} poses, with nobody to imitate, and needs no test steps then."


def demonstrator(layout: Layout, model: PageModel) -> None:
    """First of what stays in sight on every window: in a folder without a frame, which `copy` goes on with."""
    layout.named["tray"] = layout.gui.add_folder("Pose and play")
    with layout.named["tray"]:
        layout.gui.add_html('<h2 class="vi-part vi-tray"><b>1</b> Pose the demonstrator</h2>')
        inside = layout.gui.add_folder(None)
        layout.gui.add_html('<div class="vi-or">… or drag the arrows at its hand</div>')
    sliders = JointSliders(layout, inside, "{joint}", "pose_joint")

    show = lambda model: sliders.show(model, given(model.settings.demonstrator_deg))
    show(model)
    layout.drawing(lambda model: (model.generation, model.settings.demonstrator_deg, model.inputs), show)


def learner(layout: Layout, model: PageModel) -> None:
    """Bars beside the demonstrator's."""
    layout.gui.add_html(
        '<h2 class="vi-part">Learner <span>(<i class="vi-is-now"></i> now, '
        '<i class="vi-is-goal vi-tells"></i><span class="vi-tells"> goal</span>)</span></h2>'
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

    # they move along with the arm; numbers that change with every motion nobody reads faster
    layout.drawing(bars_key, draw_bars, lambda model: SLOW if model.displayed.interpolated_theta is None else 0.0)


def start(layout: Layout, model: PageModel) -> None:
    """Where the learner starts: a slider a joint, which asks for the same as a click on the landscape; and what it has
    seen of itself before."""
    folder = layout.folder("Start", lambda model: _angles(given(model.settings.start_deg)))
    with folder:
        with layout.row(quiet=True):
            seen = lambda model: Rehearsal(model.session)
            look = lambda model: STOP if seen(model).to_go else FORGET if seen(model).held else WATCH
            layout.button(look, "rehearsal", lambda model: seen(model).offered, hint=HINT)
            layout.html(lambda model: f'<div class="vi-remembers">{seen(model).words}</div>')
        inside = layout.gui.add_folder(None)
    sliders = JointSliders(layout, inside, "Start {joint}", "start_joint", "The learner starts again there.")

    show = lambda model: sliders.show(model, given(model.settings.start_deg))
    layout.drawing(lambda model: (model.generation, model.settings.start_deg, model.inputs), show)


def _angles(angles_deg: Sequence[float]) -> str:
    return ", ".join(f"{number(angle, 0)}°" for angle in angles_deg) if len(angles_deg) < MANY else "own"


def method(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    with layout.folder("Method", _method):
        gui.add_html(beside("transfer"))
        transfers, servos = ([one.title for one in those.values()] for those in (TRANSFERS, SERVOS))
        layout.dropdown("Transfer", transfers, lambda model: TRANSFERS[model.settings.transfer].title, "transfer")
        gui.add_html(beside("servo"))
        layout.dropdown("Servo", servos, lambda model: SERVOS[model.settings.servo].title, "servo")
        joints = gui.add_dropdown("Joints", ["–"], initial_value="–")
        layout.queue.on_value(joints, "joints")
    offered: list[str] = []

    def show_joints(model: PageModel) -> None:
        nonlocal offered
        names = choices.joint_choices(model.settings)
        if offered != list(names):
            offered = joints.options = list(names)
        put(joints, choices.chosen_joints(model.settings, names))

    layout.drawing(lambda model: (model.generation, model.settings.joints, model.inputs), show_joints)


def disturbances(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    with layout.folder("Disturbances", _disturbances):
        for amount in choices.OF_IMAGES:
            _add_amount(layout, amount, model)
        with gui.add_folder("Actuator errors, random seed", expand_by_default=False):
            for amount in choices.OF_ARMS:
                _add_amount(layout, amount, model)
            seed = gui.add_number("Seed", model.settings.seed, min=0, max=MAX_SEED, step=1)
            layout.value(seed, lambda model: model.settings.seed, "seed")


def _method(model: PageModel) -> str:
    """Transfer and servo, by the first words of their titles."""
    transfer, servo = TRANSFERS[model.settings.transfer].title, SERVOS[model.settings.servo].title
    return f"{transfer.split()[0].lower()}, {servo.split(' on ')[0].split(' (')[0]}"


def _disturbances(model: PageModel) -> str:
    """The first two, by their names."""
    amounts = {amount.label: amount.shown(model.settings) for amount in (*choices.OF_IMAGES, *choices.OF_ARMS)}
    there = [label for label, shown in amounts.items() if shown > (label == choices.FRAMES.label) or shown < 0]
    return (", ".join(there[:2]).lower() + (" …" if len(there) > 2 else "")) or "none"


def _add_amount(layout: Layout, amount: choices.Amount, model: PageModel) -> None:
    """A slider, which reaches farther if the page is asked to begin there."""
    begun = amount.shown(model.settings)
    low, high = min(amount.low, begun), max(amount.high, begun)
    if (key := key_of(amount.label)) is not None:
        layout.gui.add_html(beside(key))
    shown = lambda model: amount.shown(model.settings)
    layout.slider(amount.label, low, high, amount.step, shown, "disturbance", amount.name, hint=amount.hint)
