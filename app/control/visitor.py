"""What a visitor did, carried out on the session. Values come from a browser: each is checked here."""

from collections.abc import Callable
from dataclasses import dataclass, field

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.servo import SERVOS
from viewimit.session import Session
from viewimit.settings import Settings
from viewimit.simulation.kinematics import pose_for_hand
from viewimit.transfer import TRANSFERS

from ..panels.controls import NO_POINT, SPEEDS, Controls
from .checks import choice, named, number, switch
from .disturbances import DISTURBANCES
from .duel import Duel
from .joints import Freedom, joint_choices
from .player import Pace
from .presets import Preset

METHOD = {"transfer", "servo"}
CAMERA = {False: "points", True: "rendered"}


MOVING = {"play", "step", "undo", "reset", "history", "hand", "preset"}


@dataclass
class View:
    """How the page shows a session. chosen: a point or None; show: the switches of the folder Display."""

    chosen: int | None = None
    show: dict[str, bool] = field(
        default_factory=lambda: {"rays": False, "residuals": True, "gizmo": True, "whole_frames": False}
    )


class Visitor:
    """`set` takes a control's newest value, `act` a key or button. Both raise ValueError for what cannot be.

    on_world(): the scene has changed, draw anew; elsewhere: actions of the page itself, by name.
    """

    def __init__(
        self,
        session: Session,
        pace: Pace,
        controls: Controls,
        view: View,
        presets: dict[str, Preset],
        duel: Duel,
        on_world: Callable[[], None],
        elsewhere: dict[str, Callable],
    ):
        self._session, self._pace, self._controls, self._view = session, pace, controls, view
        self._presets, self._duel, self._on_world, self._elsewhere = presets, duel, on_world, elsewhere
        self._freedom = Freedom()

    @staticmethod
    def moves(name: str) -> bool:
        """Whether what has this name in the inbox moves, poses or looks, which takes long with pictures."""
        return name in MOVING or name in SETTERS or name.startswith("joint")

    def takes_pictures(self, name: str, value) -> bool:
        """Whether this asks for pictures."""
        if name == "preset":
            return isinstance(value, str) and value in self._presets and _pictured(self._presets[value].settings)
        return name == "camera" and value is True

    def act(self, action: str, now: float) -> None:
        session, pace = self._session, self._pace
        if action == "play":
            self._duel.follow()
            pace.toggle()
        elif action == "step":
            pace.pause()
            self._duel.follow()
            pace.step(now)
        elif action == "undo":
            pace.pause()
            pace.undo(now)
            self._controls.show(session.settings)
        elif action == "reset":
            pace.pause()
            session.reset()
            self._duel.begin()
            self._controls.show(session.settings)
        elif action == "next point":
            count = len(session.world.body)
            self._choose(0 if self._view.chosen is None else (self._view.chosen + 1) % count)
        else:
            self._elsewhere[action]()

    def set(self, name: str, value) -> None:
        if name == "joints":
            self._free(value)
        elif name.startswith("joint"):
            self._set_joint(int(name.removeprefix("joint")), value)
        elif name in SETTERS:
            self._change(**SETTERS[name](value))
        elif name == "hand":
            self.pose(pose_for_hand(self._session.world, value, self._session.snapshot.theta_demo))
        elif name == "preset":
            self._begin(choice(value, self._presets, "preset"))
        elif name == "speed":
            self._pace.speed = choice(value, SPEEDS, "speed")
        elif name == "history":
            self._pace.pause()
            self._pace.scrub(round(number(value)))
            self._controls.show(self._session.settings)
        elif name == "chosen":
            self._choose(None if value == NO_POINT else round(number(value)))
        elif name in self._view.show:
            self._view.show[name] = bool(value)
        else:
            self._elsewhere[name](value)

    def _free(self, value) -> None:
        """Let other joints move. What the page has now may be meant by it, which changes nothing."""
        settings = self._session.settings
        joints = choice(value, joint_choices(settings), "joints")
        if joints != settings.joints:
            self._change(**self._freedom.fields(settings, self._session.scene, joints))

    def _set_joint(self, k: int, value) -> None:
        theta = self._session.snapshot.theta_demo.copy()
        if k < len(theta):  # a slider of the scene before may still have sent
            theta[k] = np.radians(number(value))
            self._pose(theta)

    def pose(self, theta: NDArray) -> None:
        """Move the demonstrator to theta, (m,) rad; its sliders follow."""
        self._pose(theta)
        self._controls.show(self._session.settings)

    def _pose(self, theta: NDArray) -> None:
        self._session.pose(theta)
        self._duel.follow()
        self._pace.wake()

    def _change(self, **fields) -> None:
        world = self._session.world
        self._session.change(**fields)
        self._pace.wake()
        if self._session.world is not world:
            self.draw_anew()
        elif self._duel.opponent is not None and not METHOD.isdisjoint(fields):
            self._duel.begin_again()
        else:
            self._duel.follow()

    def _begin(self, preset) -> None:
        self._pace.pause()
        self._session.begin(preset.settings)
        self._pace.speed = preset.motions_per_second
        self._controls.show_preset(preset)
        self.draw_anew()

    def leave_pictures(self) -> None:
        """Begin anew with projected points."""
        self._pace.pause()
        self._session.begin(msgspec.structs.replace(self._session.settings, camera="points"))
        self.draw_anew()

    def draw_anew(self) -> None:
        """The session has begun anew, in a world of its own."""
        self._duel.begin()
        if self._view.chosen is not None and self._view.chosen >= len(self._session.world.body):
            self._view.chosen = None
        self._controls.build_sliders(self._session)
        self._controls.show_chosen(self._view.chosen)
        self._on_world()

    def _choose(self, point: int | None) -> None:
        if point is not None and not 0 <= point < len(self._session.world.body):
            raise ValueError(f"no point {point}; there are {len(self._session.world.body)}")
        self._view.chosen = point
        self._controls.show_chosen(point)


def _pictured(settings: Settings) -> bool:
    return settings.camera == "rendered"


SETTERS: dict[str, Callable[[object], dict]] = {
    "transfer": lambda value: {"transfer": named(value, TRANSFERS, "transfer")},
    "servo": lambda value: {"servo": named(value, SERVOS, "servo")},
    **{name: amount.asked for name, amount in DISTURBANCES.items()},
    "camera": lambda value: {"camera": CAMERA[switch(value)]},
    "seed": lambda value: {"seed": round(number(value))},
    "points": lambda value: {"points": round(number(str(value).split()[0]))},
}
