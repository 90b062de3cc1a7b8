"""Preset, its lesson, and the buttons that move the learner; which motion is shown, and the speed."""

from viser import Icon

from ..model.choices import SPEEDS, modified
from ..model.page_model import PageModel
from .panel import SLOW, Layout, Look, put, put_html, put_max

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
    layout.html(lambda model: f'<div class="vi-lesson">{model.preset.lesson}</div>')


def copy(layout: Layout, model: PageModel) -> None:
    """The buttons that move the learner."""
    gui = layout.gui
    with layout.named["tray"]:
        gui.add_html('<h3 class="vi-part"><b>2</b> Let the learner copy it</h3>')
        gui.add_html('<span class="vi-play-row"></span>')
        layout.button(_play_look, "play")
    gui.add_html('<span class="vi-steps-row"></span>')
    motion = gui.add_button_group("Motion", list(MOTIONS))

    @motion.on_click
    async def _(event) -> None:
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
        put_html(count, f'<div class="vi-count"><span>Motion {cursor} of {last}</span></div>')

    layout.drawing(lambda model: (model.player.cursor, model.player.last), show_length, period=SLOW)
    layout.dropdown("Speed", list(SPEEDS), _speed, "speed", period=SLOW)


def _name(model: PageModel) -> str:
    """The preset, as the list has it."""
    return modified(model.preset.name) if model.modified else model.preset.name


def _speed(model: PageModel) -> str:
    return next(name for name, value in SPEEDS.items() if value == model.player.speed)
