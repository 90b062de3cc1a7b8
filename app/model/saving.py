"""What a page hands its visitor as files: a replay of its session, and pictures of its panels, made beside it."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from viewimit.drawing.curves import draw_curves
from viewimit.drawing.equations import equations_of
from viewimit.drawing.export.citation import Citation, cite, cite_both, cite_experiment
from viewimit.drawing.export.figures import (
    INSTALL,
    RENDERER,
    TYPESETTER,
    Figure,
    append_below,
    can_render,
    can_typeset,
    draw_claims,
    encode,
    four_images,
    overlay,
    require_typesetter,
    stack,
    typeset_equations,
)
from viewimit.drawing.export.perspective import Viewpoint, draw_space
from viewimit.drawing.export.replay import replay
from viewimit.drawing.images.rectified import draw_rectified
from viewimit.drawing.svg import count_motions
from viewimit.drawing.theme import DRAWING_CSS
from viewimit.experiments import EXPERIMENTS
from viewimit.loop.session import Session

from ..drawing.duel import draw_errors_alone, draw_race
from ..jobs.landscapes import LandscapeWorker
from ..jobs.png_child import render
from .images import draw_shown
from .queue import CommandQueue
from .state import PageState

FORMATS = ("SVG", "PNG")
SPACE = "3-D view"


class Saved(NamedTuple):
    """A file for the visitor."""

    name: str
    data: bytes


class Picture(NamedTuple):
    """draw(): beside the page; citation: None for that of the page's session."""

    draw: Callable[[], Figure]
    citation: Citation | None = None

    @classmethod
    def of(cls, figure: Figure, citation: Citation | None = None) -> "Picture":
        """That is drawn already."""
        return cls(lambda: figure, citation)


class Saving:
    """send(name, data): a file for the visitor."""

    def __init__(self, page_id: int, worker: LandscapeWorker, queue: CommandQueue, send: Callable[[str, bytes], None]):
        self._page_id, self._worker, self._queue, self._send = page_id, worker, queue, send

    def replay(self, session: Session, chosen: int | None) -> None:
        """Of all moments that the session has now."""
        copied = session.copy()
        self._make("replay", lambda: Saved("viewimit-replay.html", replay(copied, chosen=chosen).html.encode()))

    def picture(self, what: str, form: str, state: PageState, eye: Viewpoint | None) -> None:
        """what: of FIGURES or SPACE; eye: that looks at the 3-D scene. Raises ValueError for a panel that is empty, and
        for a PNG without what makes it."""
        session = state.session.copy()
        name = f"viewimit-{what.split(' ')[0].lower()}.{form.lower()}"
        if what == SPACE:
            picture = Picture(partial(draw_space, session.world, state.shown, eye, state.view.rays))
        else:
            picture = FIGURES[what](state)
        require_form(form)
        citation = picture.citation or cite(session, state.present.motion)
        self._make("picture", partial(_saved, name, form, picture.draw, citation))

    def _make(self, kind: str, make: Callable[[], Saved]) -> None:
        self._worker.ask(self._page_id, make, self._queue.taker(("saved", kind), self._take), kind=kind)

    def _take(self, made: Saved | Exception) -> None:
        if isinstance(made, Exception):
            raise ValueError(f"it could not be saved: {made}")
        self._send(made.name, made.data)


def lacking() -> str:
    """Which pictures cannot be made here, and what they need; "" where all can."""
    render, typeset = can_render(), can_typeset()
    if render and typeset:
        return ""
    if typeset:
        return f"PNG needs {RENDERER}: {INSTALL}; SVG does not"
    if render:
        return f"Equations need {TYPESETTER}: {INSTALL}; other pictures do not"
    return f"PNG needs {RENDERER}, Equations need {TYPESETTER}: {INSTALL}; other pictures, as SVG, need neither"


def require_form(form: str) -> None:
    """Raises ValueError for a PNG that cannot be made here."""
    if form == "PNG" and not can_render():
        encode("", ".png")


def _saved(name: str, form: str, draw: Callable[[], Figure], citation: Citation) -> Saved:
    picture = draw().captioned(citation, DRAWING_CSS)
    return Saved(name, encode(picture, f".{form.lower()}", render))


def _images(state: PageState) -> Picture:
    moment, made = state.looked, f"after {count_motions(state.looked.motion)}"
    if state.view.rectified:
        bodies, _ = state.arms_in_images
        return Picture.of(stack([draw_rectified(moment, bodies, True)], f"The images as seen and as rectified, {made}"))
    return Picture.of(four_images(draw_shown(state, print_size=True), f"The learner’s four images {made}"))


def _landscape(state: PageState) -> Picture:
    if state.transfers is not None:
        return Picture.of(stack([state.transfers], "E over the postures of the learner, by all transfers"))
    if state.landscape is None:
        raise ValueError("the landscape is not there yet")
    picture, session = state.landscape.picture, state.session
    path = picture.draw_path(session.history, session.cursor)
    title = "E over the postures of the learner, and its path"
    if len(session.scene.moving_joints) != 2:
        title = "What a pixel of noise costs at each joint"
    return Picture.of(overlay([picture.html, path], f"{title} over {count_motions(session.cursor)}"))


def _curves(state: PageState) -> Picture:
    session, made = state.session, state.landscape
    E_true = None if made is None else made.E_true
    joints = session.scene.moving_joints
    drawn = draw_curves(session.history, session.cursor, E_true, joints, errors_deg=state.errors_deg)
    return Picture.of(stack([drawn], f"Conflict E and joint angles over {count_motions(session.cursor)}"))


def _equations(state: PageState) -> Picture:
    require_typesetter()
    told = equations_of(state.present, state.view.chosen)
    return Picture(
        partial(
            typeset_equations, told, f"The equations with their numbers after {count_motions(state.present.motion)}"
        )
    )


def _duel(state: PageState) -> Picture:
    duel, opponent, scene = state.duel, state.duel.opponent, state.session.scene
    if opponent is None:
        raise ValueError("there is no duel: begin one in its tab")
    standings = duel.standings
    cited = cite_both(state.session, opponent)
    race = draw_race(scene, (state.session, opponent), standings)
    figure = overlay([state.ground, race], f"A duel after {count_motions(state.present.motion)}: {cited.title}")
    if len(scene.moving_joints) == 2:
        figure = append_below(figure, draw_errors_alone(standings))
    return Picture.of(figure, cited)


def _experiment(state: PageState) -> Picture:
    run = state.experiments.shown
    if run is None or run.request is None or not run.claims:
        raise ValueError("the experiment is not done yet: run it in its tab")
    figure, asked = stack([run.figure], EXPERIMENTS[run.name].title), run.request
    told = draw_claims(run.claims)
    cited = cite_experiment(run.name, asked.settings, asked.options.get("motion"))
    return Picture.of(append_below(figure, told) if told else figure, cited)


FIGURES: Mapping[str, Callable[[PageState], Picture]] = {
    "Images": _images,
    "Landscape": _landscape,
    "Curves": _curves,
    "Equations": _equations,
    "Duel": _duel,
    "Experiments": _experiment,
}
PICTURES = (*FIGURES, SPACE)
