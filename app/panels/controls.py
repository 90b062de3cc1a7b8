"""The left panel: every control. What a person does with them goes into the inbox."""

import numpy as np
from viser import ClientHandle

from viewimit.drawing.learner_bars import draw_learner
from viewimit.servo import SERVOS
from viewimit.session import Session
from viewimit.settings import MOST_SEED, Settings
from viewimit.simulation.scene import Scene
from viewimit.transfer import TRANSFERS

from ..control.disturbances import DISTURBANCES
from ..control.inbox import Inbox, on_click, on_value, put, put_html, put_label
from ..control.joints import chosen_joints, joint_choices
from ..control.presets import Preset

SPEEDS = {
    "1 in 2 s": 0.5,
    "1 a second": 1.0,
    "2 a second": 2.0,
    "4 a second": 4.0,
    "10 a second": 10.0,
    "all it can": 0.0,
}
NO_POINT = "none"
MOTIONS = {"Step": "step", "Undo": "undo", "Reset": "reset"}
HINTED = ("space", "→", "H")  # keys named in the panel; the help names all
KEYS = (
    ("space", "play"),
    ("→", "step"),
    ("←", "undo"),
    ("R", "reset"),
    ("N", "next point"),
    ("V", "view"),
    ("H", "help"),
)


class Controls:
    """Builds the panel in __init__; `show` writes a session's state back into it."""

    def __init__(self, client: ClientHandle, inbox: Inbox, presets: dict[str, Preset], session: Session):
        self._client, self._inbox = client, inbox
        settings = session.settings
        gui = client.gui
        begun = next(iter(presets.values()))
        self.preset = self._dropdown("Preset", list(presets), begun.name, "preset")
        self.lesson = gui.add_html(lesson(begun.lesson))
        self.play = gui.add_button("Play", icon="player-play")
        on_click(self.play, inbox, "play")
        motion = gui.add_button_group("Motion", list(MOTIONS))

        @motion.on_click
        async def _(event) -> None:
            if event.target.value in MOTIONS:
                inbox.act(MOTIONS[event.target.value])

        self.history = gui.add_slider("History", 0, 1, 1, 0)
        on_value(self.history, inbox, "history")
        self.speed = self._dropdown("Speed", list(SPEEDS), "2 a second", "speed")
        with gui.add_folder("Demonstrator"):
            gui.add_html('<span class="vi-demonstrator-folder"></span>')
            self._sliders_at = gui.add_folder(None)
        with gui.add_folder("Learner"):
            self.learner = gui.add_html("")
        with gui.add_folder("Method"):
            transfers = [method.title for method in TRANSFERS.values()]
            servos = [servo.title for servo in SERVOS.values()]
            self.transfer = self._dropdown("Transfer", transfers, TRANSFERS[settings.transfer].title, "transfer")
            self.servo = self._dropdown("Servo", servos, SERVOS[settings.servo].title, "servo")
            self.joints = self._dropdown("Joints", ["–"], "–", "joints")
        with gui.add_folder("Disturbances"):
            self._build_disturbances(settings)
        with gui.add_folder("Display", expand_by_default=False):
            self._build_display()
        gui.add_html(key_hints())
        self.sliders: list = []
        self.build_sliders(session)
        self._hotkeys()

    def build_sliders(self, session: Session) -> None:
        """One slider a moving joint, and the choices that depend on the scene and on what is seen of it."""
        scene, settings, count = session.scene, session.settings, len(session.world.body)
        for slider in self.sliders:
            slider.remove()
        self.sliders = []
        with self._sliders_at:
            for k, (joint, (low, high)) in enumerate(zip(scene.moving_joints, scene.range_deg)):
                slider = self._client.gui.add_slider(
                    joint_symbol(joint), low, high, 0.5, settings.demonstrator_deg[k], hint="degrees"
                )
                on_value(slider, self._inbox, f"joint{k}")
                self.sliders.append(slider)
        self._joint_choices = joint_choices(settings)
        self.joints.options = list(self._joint_choices)
        pictured = settings.camera == "rendered"  # which show the markers that the robot wears, in one layout
        self._markers = f"{count} markers" if pictured else ""
        self.points.options = [self._markers] if pictured else [f"{layout} points" for layout in scene.points]
        self.points.disabled = pictured
        self.chosen.options = [NO_POINT, *(str(i) for i in range(count))]
        self.show(settings)

    def show(self, settings: Settings) -> None:
        """Set every control to what the session has; callbacks tell such writes from a person's."""
        for slider, angle in zip(self.sliders, settings.demonstrator_deg):
            put(slider, float(np.round(angle, 1)))
        put(self.transfer, TRANSFERS[settings.transfer].title)
        put(self.servo, SERVOS[settings.servo].title)
        put(self.joints, chosen_joints(settings, self._joint_choices))
        for name, handle in self.disturbances.items():
            put(handle, DISTURBANCES[name].shown(settings))
        put(self.seed, settings.seed)
        put(self.points, self._markers or f"{settings.points} points")
        put(self.camera, settings.camera == "rendered")

    def show_preset(self, preset: Preset) -> None:
        """The lesson and the speed of a preset; `show` does its settings."""
        self.lesson.content = lesson(preset.lesson)
        self.show_speed(preset.motions_per_second)
        put(self.preset, preset.name)

    def show_speed(self, motions_per_second: float) -> None:
        put(self.speed, next(name for name, value in SPEEDS.items() if value == motions_per_second))

    def show_switches(self, on: dict[str, bool]) -> None:
        """The switches of the folder Display, by their names in the inbox."""
        for name, value in on.items():
            put(self.switches[name], value)

    def show_chosen(self, point: int | None) -> None:
        put(self.chosen, NO_POINT if point is None else str(point))

    def show_history(self, cursor: int, last: int) -> None:
        """The history slider: which motion the page shows, out of those up to `last`."""
        last = max(last, 1)
        if self.history.max != last:
            self.history.max = last
        put(self.history, cursor)

    def show_playing(self, playing: bool) -> None:
        put_label(self.play, *(("Pause", "player-pause") if playing else ("Play", "player-play")))

    def show_learner(self, scene: Scene, theta, theta_demo) -> None:
        put_html(self.learner, draw_learner(scene, theta, theta_demo))

    def _build_disturbances(self, settings: Settings) -> None:
        """Sliders, the less frequent ones folded; they reach farther if they are asked to begin there."""
        gui, self.disturbances = self._client.gui, {}
        for name in ("noise_px", "missing", "outliers", "frames"):
            self._add_disturbance(name, settings)
        with gui.add_folder("Arm and chance", expand_by_default=False):
            for name in ("gain_error", "quantum_deg"):
                self._add_disturbance(name, settings)
            self.seed = gui.add_number("Seed", settings.seed, min=0, max=MOST_SEED, step=1)
            on_value(self.seed, self._inbox, "seed")

    def _add_disturbance(self, name: str, settings: Settings) -> None:
        asked, begun = DISTURBANCES[name], DISTURBANCES[name].shown(settings)
        low, high = min(asked.low, begun), max(asked.high, begun)
        handle = self._client.gui.add_slider(asked.label, low, high, asked.step, asked.low, hint=asked.hint)
        on_value(handle, self._inbox, name)
        self.disturbances[name] = handle

    def _build_display(self) -> None:
        gui = self._client.gui
        self.chosen = self._dropdown("Point", [NO_POINT], NO_POINT, "chosen")
        self.points = self._dropdown("Layout", ["10 points"], "10 points", "points")
        self.camera = gui.add_checkbox("Camera images", False)
        on_value(self.camera, self._inbox, "camera")
        self.switches: dict = {}
        for label, name, value in (
            ("Rays", "rays", False),
            ("Residuals, 3-D", "residuals", True),
            ("Hand gizmo", "gizmo", True),
            ("Whole frames", "whole_frames", False),
            ("Dark", "dark", False),
        ):
            self.switches[name] = gui.add_checkbox(label, value)
            on_value(self.switches[name], self._inbox, name)
        fit = gui.add_button("Fit view")
        on_click(fit, self._inbox, "view")

    def _dropdown(self, label: str, options: list[str], value: str, name: str):
        handle = self._client.gui.add_dropdown(label, options, initial_value=value)
        on_value(handle, self._inbox, name)
        return handle

    def _hotkeys(self) -> None:
        for label, hotkey, action in (
            ("Play or pause", "space", "play"),
            ("Step: one motion", "arrowright", "step"),
            ("Undo: one motion back", "arrowleft", "undo"),
            ("Reset to the start", "R", "reset"),
            ("Choose the next point", "N", "next point"),
            ("Fit the view", "V", "view"),
            ("Help", "H", "help"),
        ):
            command = self._client.gui.add_command(label, hotkey=hotkey)

            @command.on_trigger
            async def _(_event, action=action) -> None:
                self._inbox.act(action)


def joint_symbol(joint: int) -> str:
    """θ with a subscript"""
    return "θ" + "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(joint))


def lesson(text: str) -> str:
    return f'<div class="vi-lesson">{text}</div>'


def key_hints() -> str:
    keys = "".join(f"<span><kbd>{key}</kbd> {action}</span> " for key, action in KEYS if key in HINTED)
    return f'<div class="vi-keys">{keys}</div>'
