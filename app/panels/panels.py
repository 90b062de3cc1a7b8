"""The right panels and the overlays: where the drawings go; only what changed is sent."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

from viewimit.analysis.joint_errors import recent_errors_deg
from viewimit.analysis.landscape import conflict_at
from viewimit.analysis.observability import joint_uncertainty
from viewimit.drawing.curves import draw_curves, following
from viewimit.drawing.equations import draw_conflict, draw_equations, draw_law
from viewimit.drawing.image_planes import holds, image_windows
from viewimit.drawing.images import NO_PICTURES, draw_images
from viewimit.drawing.landscape import LandscapePicture
from viewimit.drawing.status import describe, draw_status
from viewimit.session import Session
from viewimit.simulation.appearance import Silhouettes, places, reach
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS

from ..control.inbox import Inbox, on_click, put_html, put_label
from ..jobs import landscapes
from ..scene import meshes
from .help import help_html

WIDTHS = {False: 440, True: 560}  # px of the right panels, in a wide window or not
TOO_FEW = "fewer than five points are seen in all four images"
CARD_WIDTH, TAB_WIDTH = 860, 424  # px of the curves: a card over the scene of a wide window, or a tab
COMPARE, ALONE = ("Compare all transfers", "layout-grid"), ("This transfer alone", "square")  # what the button does


@dataclass(frozen=True, eq=False)
class MadeLandscape:
    """What the worker hands over. E_true: px², with the learner in the demonstrator's posture."""

    world: World
    picture: LandscapePicture
    E_true: float | None


class Panels:
    """Builds the panels in __init__; every draw_… writes into its element what is new. lower: takes further tabs.

    In a wide window the curves stand over the scene instead of in a tab, and Eq. (6) and the servo's law under
    the drawings that they belong to.
    """

    def __init__(self, client: ClientHandle, inbox: Inbox, wide: bool):
        self._client, self._inbox, self._wide = client, inbox, wide
        self._help = None  # the open modal
        gui = client.gui
        self._status = gui.add_html("")
        upper, lower = gui.add_panel(), gui.add_panel()
        self.lower = lower
        with upper.add_tab("Images"):
            self._images = gui.add_html("")
            self._conflict = gui.add_html("", visible=wide)
        with lower.add_tab("Landscape"):
            self._landscape, self._path = gui.add_html(""), gui.add_html("")
            self._transfers = gui.add_html("", visible=False)
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row vi-quiet"></span>')
                self._compare = gui.add_button(COMPARE[0], icon=COMPARE[1])
            on_click(self._compare, inbox, "transfers")
            self._law = gui.add_html("", visible=wide)
        if wide:
            self._curves = gui.add_html("")
        else:
            with lower.add_tab("Curves"):
                self._curves = gui.add_html("")
        with lower.add_tab("Equations"):
            self._equations = gui.add_html("")
        upper.dock_right()
        upper.set_width(WIDTHS[wide])
        lower.dock_below(upper)

    def set_world(self, world: World, snapshot: Snapshot) -> None:
        """Prepare for another scene: silhouettes, windows of the images, an empty landscape."""
        loaded = meshes.link_meshes(world.scene.robot)
        self._world, self._begun = world, snapshot
        self._silhouettes = Silhouettes({link: mesh.vertices for link, mesh in loaded.items()}, world)
        self._held = [snapshot.theta, snapshot.theta_demo]  # postures that the windows are to show
        self._windows = image_windows(reach(world, self._held), world.scene.head.image)
        self.show_landscape(MadeLandscape(world, LandscapePicture(None, world.scene, snapshot), None))

    def draw_images(
        self, snapshot: Snapshot, chosen: int | None, whole_frames: bool, pictures: Mapping[str, bytes] = NO_PICTURES
    ) -> None:
        if len(snapshot.theta) > 2 and not holds(self._windows, places(self._world, snapshot)):
            self._held += [snapshot.theta, snapshot.theta_demo]
            self._windows = image_windows(reach(self._world, self._held), self._world.scene.head.image)
        bodies = self._silhouettes.bodies(snapshot)
        drawn = draw_images(snapshot, bodies, self._windows, chosen, whole_frames, wide=self._wide, pictures=pictures)
        put_html(self._images, drawn)

    def draw_path(self, session: Session, theta: NDArray | None) -> None:
        """theta: (m,) rad, where the arm is seen while it moves; None at rest."""
        put_html(self._path, self.landscape.picture.draw_path(session.history, session.cursor, theta))

    def draw_curves(self, session: Session) -> None:
        shown = session.history, session.cursor, self.landscape.E_true, session.scene.moving_joints
        errors_deg = recent_errors_deg(session.history, session.cursor)
        drawn = draw_curves(*shown, CARD_WIDTH if self._wide else TAB_WIDTH, errors_deg)
        put_html(self._curves, f'<div class="vi-card">{drawn}</div>' if self._wide else drawn)

    def draw_equations(self, session: Session, chosen: int | None) -> None:
        put_html(self._equations, draw_equations(session.snapshot, chosen))
        if self._wide:
            put_html(self._conflict, draw_conflict(session.snapshot))
            put_html(self._law, draw_law(session.snapshot))

    def draw_status(self, session: Session, playing: bool) -> None:
        before = session.history[max(session.cursor - 5, 0) : session.cursor]
        put_html(self._status, draw_status(*describe(session.snapshot, before, playing)))

    def draw_following(self, session: Session, state: str, sentence: str) -> None:
        """What is recorded or replayed, and how far the learner is off it."""
        off = following(recent_errors_deg(session.history, session.cursor))
        self.draw_state(state, sentence.rstrip(".") + f"; learner {off}." if off else sentence)

    def draw_state(self, state: str, sentence: str) -> None:
        put_html(self._status, draw_status(state, sentence))

    def make_landscape(self, world: World, snapshot: Snapshot) -> MadeLandscape:
        """E over all postures, and its picture. Runs in the worker's thread."""
        made = landscapes.compute(world, snapshot)
        views, theta = snapshot.views, snapshot.theta_demo
        seen = world, TRANSFERS[snapshot.settings.transfer], views.demo, views.visible[:, :2]
        E_true = float(conflict_at(*seen, theta[:, None])[0, 0])
        spread = joint_uncertainty(*seen, theta)
        picture = LandscapePicture(made, world.scene, snapshot, TOO_FEW, spread)
        return MadeLandscape(world, picture, E_true if np.isfinite(E_true) else None)

    def show_landscape(self, made: MadeLandscape | Exception) -> None:
        """Take over a landscape, unless the scene has changed meanwhile."""
        if isinstance(made, Exception):
            picture = LandscapePicture(None, self._world.scene, self._begun, f"no landscape: {made}"[:60])
            made = MadeLandscape(self._world, picture, None)
        if made.world is self._world:
            self.landscape = made
            put_html(self._landscape, made.picture.html)

    def show_transfers(self, html: str | None) -> None:
        """All transfers' landscapes in place of the one that is used; None shows that again."""
        alone = html is None
        put_html(self._transfers, html or "")
        for handle, visible in ((self._landscape, alone), (self._path, alone), (self._transfers, not alone)):
            if handle.visible != visible:
                handle.visible = visible
        put_label(self._compare, *(COMPARE if alone else ALONE))

    def show_help(self) -> None:
        """Open the help, or close it."""
        if self._help is not None:
            self._help.close()
            self._help = None
            return
        self._help = self._client.gui.add_modal("viewimit: what is seen here")
        with self._help:
            self._client.gui.add_html(help_html())
            done = self._client.gui.add_button("Close")

        on_click(done, self._inbox, "help")
