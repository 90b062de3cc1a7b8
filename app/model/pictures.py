"""What a page hands its visitor as files: a replay of its session, and pictures of its panels, made beside it."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from viewimit.drawing.curves import draw_curves
from viewimit.drawing.equations import equations_of
from viewimit.drawing.export import figures
from viewimit.drawing.export.citation import Citation, cite, cite_both, cite_experiment
from viewimit.drawing.export.perspective import draw_space
from viewimit.drawing.images.rectified import draw_rectified
from viewimit.drawing.svg import count_motions
from viewimit.drawing.theme import DRAWING_CSS
from viewimit.experiments import EXPERIMENTS

from ..drawing.duel import draw_errors_alone, draw_race
from ..jobs.child import render
from ..lab.replay import replay
from .page_model import PageModel, Saved

FORMATS = ("SVG", "PNG")
SPACE = "3-D view"  # as FIGURES


class Picture(NamedTuple):
    """draw(): beside the page; citation: None for that of the page's session."""

    draw: Callable[[], figures.Figure]
    citation: Citation | None = None

    @classmethod
    def of(cls, figure: figures.Figure, citation: Citation | None = None) -> "Picture":
        """Return a picture that is drawn already."""
        return cls(lambda: figure, citation)


def save_replay(model: PageModel) -> None:
    """Send the visitor all motions that the session has now, as one page."""
    copied, chosen = model.session.copy(), model.view.chosen
    model.send_made("replay", lambda: Saved("viewimit-replay.html", replay(copied, chosen=chosen).html.encode()))


def save_picture(model: PageModel, now: float) -> None:
    """Send a picture of the chosen panel. Raises ValueError for an empty panel, or a PNG that cannot be made here."""
    model.refresh(now)
    what, form, session = model.view.picture, model.view.picture_as, model.session.copy()
    name = f"viewimit-{what.split(' ')[0].lower()}.{form.lower()}"
    if what == SPACE:
        shown = model.displayed.scene_snapshot
        picture = Picture(partial(draw_space, session.world, shown, model.eye(), model.view.rays))
    else:
        picture = FIGURES[what](model)
    if form == "PNG" and not figures.can_render():
        raise ValueError(figures.NO_PNG)
    citation = picture.citation or cite(session, model.snapshot.motion)
    model.send_made("picture", partial(_saved, name, form, picture.draw, citation))


def lacking() -> str:
    """Which pictures cannot be made here, and what they need; "" where all can."""
    render, typeset = figures.can_render(), figures.can_typeset()
    if typeset:
        return "" if render else figures.NO_PNG
    if render:
        return f"Equations need {figures.TYPESETTER}: {figures.INSTALL}; other pictures do not"
    needs = f"PNG needs {figures.RENDERER}, Equations need {figures.TYPESETTER}: {figures.INSTALL}"
    return f"{needs}; other pictures, as SVG, need neither"


def _saved(name: str, form: str, draw: Callable[[], figures.Figure], citation: Citation) -> Saved:
    picture = draw().captioned(citation, DRAWING_CSS)
    return Saved(name, render(picture) if form == "PNG" else picture.encode())


def _images(model: PageModel) -> Picture:
    moment = model.displayed.image_snapshot
    after = f"after {count_motions(moment.motion)}"
    if model.view.rectified:
        drawn = draw_rectified(moment, model.displayed.arms_in_images[0], True)
        return Picture.of(figures.stack([drawn], f"The pictures as seen and as rectified, {after}"))
    drawn = model.displayed.draw_images(print_size=True)
    return Picture.of(figures.four_images(drawn, f"The learner’s four pictures {after}"))


def _landscape(model: PageModel) -> Picture:
    if model.comparison.html is not None:
        return Picture.of(figures.stack([model.comparison.html], "E over the poses of the learner, by all transfers"))
    if model.landscape.made is None:
        raise ValueError("the landscape is not there yet")
    picture, session = model.landscape.made.picture, model.session
    path, over = picture.draw_path(session.history, session.cursor), f"over {count_motions(session.cursor)}"
    is_map = len(session.scene.moving_joints) == 2
    title = "E over the poses of the learner, and its path" if is_map else "Joint error per pixel of noise,"
    return Picture.of(figures.overlay([picture.html, path], f"{title} {over}"))


def _curves(model: PageModel) -> Picture:
    session, made = model.session, model.landscape.made
    E_true, joints = None if made is None else made.E_true, session.scene.moving_joints
    drawn = draw_curves(session.history, session.cursor, E_true, joints, errors_deg=model.displayed.errors_deg)
    return Picture.of(figures.stack([drawn], f"Conflict E and joint angles over {count_motions(session.cursor)}"))


def _equations(model: PageModel) -> Picture:
    if not figures.can_typeset():
        raise ValueError(f"a picture of equations needs {figures.TYPESETTER}: {figures.INSTALL}")
    text = equations_of(model.snapshot, model.view.chosen)
    title = f"The equations with their numbers after {count_motions(model.snapshot.motion)}"
    return Picture(partial(figures.typeset_equations, text, title))


def _duel(model: PageModel) -> Picture:
    duel, opponent, scene = model.duel, model.duel.opponent, model.session.scene
    if opponent is None:
        raise ValueError("there is no duel: begin one in its tab")
    cited, standings = cite_both(model.session, opponent), duel.standings
    race = draw_race(scene, (model.session, opponent), standings)
    title = f"A duel after {count_motions(model.snapshot.motion)}: {cited.title}"
    figure = figures.overlay([model.duel_landscapes.html, race], title)
    if len(scene.moving_joints) == 2:
        figure = figures.append_below(figure, draw_errors_alone(standings))
    return Picture.of(figure, cited)


def _experiment(model: PageModel) -> Picture:
    run = model.experiments.shown
    if run is None or run.request is None or not run.claims:
        raise ValueError("the experiment is not done yet: run it in its tab")
    figure, asked = figures.stack([run.figure], EXPERIMENTS[run.name].title), run.request
    text = figures.draw_claims(
        [figures.ClaimRow(one.name, one.paper, one.here, one.tolerance, one.holds) for one in run.claims]
    )
    cited = cite_experiment(run.name, asked.settings, asked.options.get("motion"))
    return Picture.of(figures.append_below(figure, text), cited)


FIGURES: Mapping[str, Callable[[PageModel], Picture]] = {
    "Images": _images, "Landscape": _landscape, "Curves": _curves,
    "Equations": _equations, "Duel": _duel, "Experiments": _experiment,
}  # fmt: skip
PICTURES = *FIGURES, SPACE
