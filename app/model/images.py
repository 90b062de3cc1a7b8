"""The four images of the moment that a page shows."""

from viewimit.drawing.images.panel import draw_images
from viewimit.simulation.appearance import Bodies

from .state import PageState


def draw_shown(state: PageState, stage: int | None = None, standing: Bodies | None = None) -> str:
    """HTML. stage: up to which the construction is shown; standing: the arms where they are, while others are
    looked at."""
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
    )
