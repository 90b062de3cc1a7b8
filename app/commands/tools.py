"""Commands to the page's tools: experiments, motions of the demonstrator, body points, files."""

from typing import Annotated

from viewimit.experiments import EXPERIMENTS

from ..model.choices import MESSAGE_S
from ..model.motions import MOST_BYTES, NAMES
from ..model.page_model import PageModel
from ..model.pictures import FORMATS, PICTURES, save_picture, save_replay
from ..model.queue import add_command, command, one_of, titled

EXPERIMENT = titled(EXPERIMENTS, "experiment")
MOTION = one_of({title: name for name, title in NAMES.items()}, "there is no motion {value}")

add_command("run", lambda model: model.experiments.run_or_cancel())
add_command("download", lambda model: model.experiments.download())
add_command("motion", lambda model, name: model.motions.choose(name), MOTION, latest=True, moves=True)
add_command("record", lambda model: model.motions.record(), moves=True)
add_command("replay", lambda model: model.motions.replay(), moves=True)
add_command("save_motion", lambda model: model.motions.save(), moves=True)
add_command("scene", lambda model: model.points.save(), link=True)


@command("experiment", latest=True)
def choose_experiment(model: PageModel, name: Annotated[str, EXPERIMENT]) -> None:
    model.experiments.chosen = name


@command("motion_time", latest=True, moves=True)
def show_motion_at(model: PageModel, seconds: float) -> None:
    """Show a moment of the chosen motion."""
    model.motions.scrub(seconds)


@command("picture", latest=True)
def choose_picture(model: PageModel, name: Annotated[str, one_of(PICTURES, "there is no picture {value}")]) -> None:
    """Choose which panel is saved as a picture."""
    model.show(picture=name)


@command("picture_format", latest=True)
def choose_format(model: PageModel, name: Annotated[str, one_of(FORMATS, "there is no format {value}")]) -> None:
    """Choose the kind of file in which pictures are saved."""
    model.show(picture_as=name)


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


def _choose_last(model: PageModel) -> None:
    model.show(chosen=len(model.session.world.body) - 1)


@command("save_replay", order_independent=True)
def send_replay(model: PageModel, *, now: float) -> None:
    """Send the visitor the session as one page that needs no server."""
    save_replay(model)
    model.say("Writing the replay: one file that opens anywhere, without a server …", now + MESSAGE_S)


@command("save_picture")
def send_picture(model: PageModel, *, now: float) -> None:
    """Send the visitor a picture of the chosen panel."""
    save_picture(model, now)
    model.say("Drawing the picture, in colours of print and with its caption …", now + MESSAGE_S)
