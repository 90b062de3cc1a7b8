"""A page's session and what goes with it, and all that changes it: what a change loses, Undo brings back."""

from collections.abc import Callable

import msgspec
from numpy.typing import NDArray

from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.session import Session
from viewimit.loop.settings import BodyPoint, Settings

from ..jobs.camera_images import Cameras
from ..jobs.session_eyes import SessionEyes
from .displayed import require_use
from .duel import Duel
from .past import Left, Past
from .player import DENSE, Player
from .presets import Preset, Presets

METHOD = {"transfer", "servo"}


class UndoableSession:
    """settings: what it begins with; in_new_world(): the world has become another, or the session has begun anew."""

    def __init__(self, settings: Settings, camera: Cameras, in_new_world: Callable[[], None]):
        self._eyes, self._opponents_eyes = SessionEyes(camera), SessionEyes(camera)
        self._in_new_world = in_new_world
        self.session = Session(settings, open_eyes=self._eyes, dense=DENSE)
        self.player = Player(self.session)
        self.duel = Duel(self.session, self.player, self._opponents_eyes)
        self.presets = Presets(settings)
        self.past = Past(self.player, self.presets)

    def pose(self, theta: NDArray) -> None:
        """Move the demonstrator to theta, (m,) rad; what is lost by that, Undo brings back."""
        with self.past.kept():
            self.session.pose(theta)
        self.duel.follow()
        self.player.wake()

    def change(self, **fields) -> None:
        """Some of the settings."""
        world = self.session.world
        with self.past.kept():
            self.session.change(**fields)
        self.player.wake()
        if self.session.world is not world:
            self.begin_anew()
        elif self.duel.opponent is not None and not METHOD.isdisjoint(fields):
            self.duel.begin_again()
        else:
            self.duel.follow()

    def lay_points(self, points: tuple[BodyPoint, ...]) -> None:
        """Begin anew with these body points on both arms. Raises ValueError, with all as it is, if they cannot be."""
        self.player.pause()
        with self.past.kept(whole=True):
            self.session.change(body_points=points)
        self.begin_anew()

    def start_at(self, angles_deg: tuple[float, ...]) -> None:
        """The learner begins anew at a posture, (m,)."""
        self.player.pause()
        self.change(start_deg=angles_deg)
        self.player.settle()

    def rehearse(self) -> None:
        """The learner watches itself in its next motions, and then imitates. Raises ValueError, with all as it is,
        where its servo would make no use of that."""
        require_use(self.session.settings.servo)
        with self.past.kept():
            postures = self.session.calibration_postures(DEFAULT_POSTURES, self.session.settings.seed)
            self.session.begin_calibration(postures)
            self.duel.rehearse(DEFAULT_POSTURES)
        self.player.play()

    def forget_rehearsal(self) -> None:
        """What the learner has seen of itself, or what is left to be watched."""
        with self.past.kept():
            self.session.use_calibration(None)
            self.duel.remember_alike()
        self.player.wake()

    def begin_preset(self, preset: Preset) -> None:
        self.player.pause()
        with self.past.kept(whole=True):
            self.session.begin(preset.settings)
        self.player.speed = preset.motions_per_second
        self.presets.chosen = preset
        self.begin_anew()

    def begin_like(self, settings: Settings) -> None:
        """With projected points; nothing of what was here is kept."""
        self.session.begin(msgspec.structs.replace(settings, sensor="projected"))

    def leave_pictures(self) -> None:
        """Begin anew with projected points."""
        self.player.pause()
        self.begin_like(self.session.settings)
        self.begin_anew()

    def reset(self) -> None:
        """Back to the start."""
        self.player.pause()
        with self.past.kept():
            self.session.reset()
        self.duel.begin()

    def bring_back(self, left: Left) -> None:
        """As it was. Raises ValueError, with all as it is, if that cannot be any more."""
        self.go_on_with(left)
        self.past.forget_newest()

    def go_on_with(self, left: Left) -> None:
        """As `bring_back`, for what the past does not hold."""
        world = self.session.world
        for session, (moments, cursor, log) in zip(self.player.sessions, left.runs):
            session.resume(moments, cursor, log)
        self.presets.chosen, self.player.speed = left.preset, left.speed
        self.player.settle()
        if self.session.world is not world:
            self._in_new_world()

    def begin_anew(self) -> None:
        """The session has begun anew, in a world of its own."""
        self.duel.begin()
        self._in_new_world()

    def close(self) -> None:
        """Give the eyes back."""
        self._eyes.close()
        self._opponents_eyes.close()
