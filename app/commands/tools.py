"""Commands to the page's tools: experiments, motions of the demonstrator, body points, files."""

from typing import Annotated

from viewimit.experiments import EXPERIMENTS

from ..model import pictures
from ..model.motions import MOST_BYTES, NAMES
from ..model.page_model import PageModel
from ..model.pictures import FORMATS, PICTURES
from ..model.queue import named, one_of
from .registry import command
from .session import MESSAGE_S


@command("experiment", latest=True)
def choose_experiment(
    model: PageModel, name: Annotated[str, lambda value: named(value, EXPERIMENTS, "there is no experiment {value}")]
) -> None:
    model.experiments.chosen = name


@command("run")
def run_or_cancel(model: PageModel) -> None:
    """Run the chosen experiment, or cancel the one that goes on."""
    model.experiments.run_or_cancel()


@command("download")
def download(model: PageModel) -> None:
    """Send the visitor the figure and the data of the chosen experiment."""
    model.experiments.download()


@command("imitation", moves=True)
def show_imitation(model: PageModel, *, now: float) -> None:
    """Show the imitated motion, or stop showing it."""
    run = model.experiments.shown
    if model.display.playback.playing:
        model.display.playback.stop()
    elif run is None or run.imitation is None:
        raise ValueError("there is no imitation to be seen before the experiment is done")
    else:
        model.player.pause()
        model.display.playback.play(run.imitation, now)


@command("motion", latest=True, moves=True)
def choose_motion(
    model: PageModel,
    name: Annotated[str, one_of({title: name for name, title in NAMES.items()}, "there is no motion {value}")],
) -> None:
    """Choose one of the demonstrator's motions by its title."""
    model.motions.choose(name)


@command("record", moves=True)
def record(model: PageModel) -> None:
    """Begin to record the demonstrator, or end it."""
    model.motions.record()


@command("replay", moves=True)
def replay(model: PageModel) -> None:
    """Play the chosen motion on, or stop."""
    model.motions.replay()


@command("motion_time", latest=True, moves=True)
def show_motion_at(model: PageModel, seconds: float) -> None:
    """Show a moment of the chosen motion."""
    model.motions.scrub(seconds)


@command("save_motion", moves=True)
def save_motion(model: PageModel) -> None:
    model.motions.save()


@command("load_motion", latest=True, moves=True)
def load_motion(
    model: PageModel, data: Annotated[bytes | int, lambda data: data if len(data) <= MOST_BYTES else len(data)]
) -> None:
    """Take a motion from a file. data: what the file holds, or its size if that is too large."""
    model.motions.load(data)


@command("edit_points", moves=True)
def edit_points(model: PageModel) -> None:
    """Begin to edit the body points, or end it; nothing moves meanwhile."""
    model.points.toggle()
    if model.points.on:
        model.player.pause()
        model.display.preview.let_go()
        model.display.playback.stop()


@command("place_point", moves=True)
def place_point(
    model: PageModel, link: int, local: Annotated[tuple[float, float, float], lambda value: tuple(map(float, value))]
) -> None:
    """Place a point on both arms, and choose it. link: 0 = base; local: (3,) m in its frame."""
    model.points.place(link, local)
    _choose_last(model)


@command("remove", moves=True, link=True)
def remove_point(model: PageModel) -> None:
    """Remove the chosen point."""
    model.points.remove(model.view.chosen)
    model.show(chosen=None)


@command("best", moves=True, link=True)
def best_next(model: PageModel) -> None:
    """Propose the point that would tell most; or place the one that is proposed."""
    if model.points.propose_or_take():
        _choose_last(model)


@command("scene", link=True)
def save_scene(model: PageModel) -> None:
    """Send the visitor a file of the scene with its points."""
    model.points.save()


def _choose_last(model: PageModel) -> None:
    model.show(chosen=len(model.session.world.body) - 1)


@command("save_replay", order_independent=True)
def save_replay(model: PageModel, *, now: float) -> None:
    """Send the visitor the session as one page that needs no server."""
    pictures.save_replay(model)
    model.say("Writing the replay: one file that opens anywhere, without a server …", now + MESSAGE_S)


@command("picture", latest=True)
def choose_picture(model: PageModel, name: Annotated[str, one_of(PICTURES, "there is no picture {value}")]) -> None:
    """Choose which panel is saved as a picture."""
    model.show(picture=name)


@command("picture_format", latest=True)
def choose_format(model: PageModel, name: Annotated[str, one_of(FORMATS, "there is no format {value}")]) -> None:
    model.show(picture_as=name)


@command("save_picture")
def save_picture(model: PageModel, *, now: float) -> None:
    """Send the visitor a picture of the chosen panel."""
    pictures.save_picture(model, now)
    model.say("Drawing the picture, in colours of print and with its caption …", now + MESSAGE_S)
