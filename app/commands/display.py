"""Commands to what the page shows of a session: they change nothing of it."""

from typing import Annotated

from ..model.choices import FLAGS, LARGE, NO_POINT, SWITCHED
from ..model.page_model import PageModel
from ..model.queue import add_command, command, number, one_of

CLIENT_REPORTED = {"dark": "prefers_dark", "truth": "truth", "flat": "flat"}  # fields of View, by link
ENLARGED = one_of({str(k): what for k, what in enumerate(LARGE)}, "there is no panel or picture {value}")
NO_FLAG = "{value} is neither 0 nor 1"


@command("choose_point", latest=True)
def choose_point(
    model: PageModel, point: Annotated[int | None, lambda value: None if value == NO_POINT else round(number(value))]
) -> None:
    """Choose a body point, or none."""
    count = len(model.session.world.body)
    if point is not None and not 0 <= point < count:
        raise ValueError(f"there is no point {point}; there {'is 1' if count == 1 else f'are {count}'}")
    model.show(chosen=point)


@command("point", order_independent=True, link=True)
def toggle_point(model: PageModel, point: int) -> None:
    """Choose a point; the chosen one again: none."""
    choose_point(model, None if point == model.view.chosen else point)


@command("next_point", order_independent=True)
def next_point(model: PageModel) -> None:
    chosen, count = model.view.chosen, len(model.session.world.body)
    model.show(chosen=0 if chosen is None else (chosen + 1) % count)


@command("switch", latest=True, order_independent=True)
def switch(model: PageModel, name: Annotated[str, one_of(SWITCHED, "there is no switch {value}")], on: bool) -> None:
    """Set one of the switches of `View`."""
    model.show(**{name: on})


def _report(link: str, field: str) -> None:
    """Add a command that takes what a browser says of itself, see `View`."""
    report = lambda model, on: model.show(**{field: on})
    add_command(link, report, one_of(FLAGS, NO_FLAG), latest=True, order_independent=True, link=True)


for _link, _field in CLIENT_REPORTED.items():
    _report(_link, _field)


@command("still", order_independent=True, link=True)
def prefer_still(model: PageModel, still: Annotated[bool, one_of(FLAGS, NO_FLAG)]) -> None:
    """Take whether the browser asks for less motion: arms are then shown where they arrive, not on their way."""
    model.player.still = still


@command("unseen", order_independent=True, link=True)
def hide_tabs(model: PageModel, tabs: str) -> None:
    """Take which tabs nobody sees, as the browser says: see `View.unseen`."""
    model.show(unseen=frozenset() if tabs == "none" else frozenset(tabs.split(",")))


def _toggle(name: str, field: str, **options: bool) -> None:
    """Add a command that turns a switch of `View` over."""
    toggle = lambda model: model.show(**{field: not getattr(model.view, field)})
    add_command(name, toggle, order_independent=True, **options)


_toggle("goal", "goal")  # the learner in L and R as it would look in the demonstrator's posture
_toggle("share", "share", link=True)  # the card with a link to what the page shows, and the code that repeats it
_toggle("help", "help", link=True)
add_command("fit_view", lambda model: model.show(fits=model.view.fits + 1), order_independent=True)


@command("construction", order_independent=True, link=True)
def build_up(model: PageModel, *, now: float) -> None:
    """Show step by step how the chosen point is recovered; once more: all at once."""
    if model.display.construction_began is not None:
        model.display.construction_began = None
        return
    if model.view.chosen is None:
        next_point(model)
    model.display.construction_began = now


@command("large", order_independent=True, link=True)
def enlarge(model: PageModel, what: Annotated[str, ENLARGED]) -> None:
    """Enlarge a panel or an image, by its index in LARGE; the one that is large already: all as before."""
    model.show(large=None if model.view.large == what else what)


@command("next_larger", order_independent=True)
def next_larger(model: PageModel) -> None:
    """Enlarge the images, then the figures, then show all as before."""
    after = {None: "images", "images": "figures"}
    model.show(large=after.get(model.view.large))


@command("dismiss", order_independent=True, link=True)
def dismiss(model: PageModel) -> None:
    """Close the help, or else end a link that is followed, a proposed point or editing them, or else an imitation, the
    see-through arm, the large panel and the offer of the tour."""
    if model.view.help or model.view.share:
        model.show(help=False, share=False)
    elif not model.following.let_go() and not model.points.let_go():
        model.tour_offered = False
        model.display.playback.stop()
        model.display.preview.let_go()
        model.show(large=None)


@command("starts")
def run_from_many_starts(model: PageModel) -> None:
    """Find from where the learner arrives, or hide it; over the landscape of the transfer that is used."""
    hidden = model.comparison.on
    if hidden:
        model.comparison.toggle()
    if not hidden or model.basins.run is None:
        model.basins.toggle(model.session)


@command("compare", order_independent=True)
def toggle_comparison(model: PageModel) -> None:
    """Show the landscapes of all transfers, large, or of the one that is used."""
    model.comparison.toggle()
    if model.comparison.on or model.view.large == "figures":
        model.show(large="figures" if model.comparison.on else None)
