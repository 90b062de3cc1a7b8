"""The four images of the moment that a page shows."""

from viewimit.drawing.images.panel import SPARK_MOTIONS, draw_images
from viewimit.simulation.appearance import Bodies

from .state import PageState


def draw_shown(
    state: PageState, stage: int | None = None, standing: Bodies | None = None, print_size: bool = False
) -> str:
    """HTML. stage: up to which the construction is shown; standing: the arms where they are, while others are
    looked at; print_size: as in `draw_images`."""
    bodies, windows = state.arms_in_images
    return draw_images(
        state.looked,
        bodies,
        windows,
        state.view.chosen,
        state.view.whole_frames,
        pictures=state.pictures,
        construction=state.construction,
        stage=stage,
        standing=standing,
        goal=state.view.goal and state.view.truth,
        course=[
            moment.E for moment in state.session.history[max(state.cursor + 1 - SPARK_MOTIONS, 0) : state.cursor + 1]
        ],
        print_size=print_size,
    )
