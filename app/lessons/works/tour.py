"""Of the tour: the landscape of what is seen, and other servos from the same start."""

from collections.abc import Mapping

from viewimit.analysis.landscape import Landscape, grid_axes, landscape_over

from ..stage import Race
from .work import Task, Work

MOST_MOTIONS = 400  # of a race


def _landscape(task: Task) -> Landscape | None:
    """None unless two joints move."""
    if len(task.world.scene.moving_joints) != 2:
        return None
    views = task.snapshot.views
    return landscape_over(task.world, task.snapshot.fit, views.demo, views.visible[:, :2], grid_axes(task.world))


def _races(task: Task) -> tuple[Race, ...]:
    """Each servo of the step from the same start."""
    races = []
    for servo in task.step.race:
        session = task.session(servo=servo)
        session.run(MOST_MOTIONS)
        races.append(Race(servo, tuple(session.history)))
    return tuple(races)


WORKS: Mapping[str, Work] = {
    "landscape": Work(_landscape, "turned"),
    "races": Work(_races, "revealed", played=True),
}
