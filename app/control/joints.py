"""Which joints imitate: those of the scene, as the paper's two, or all of the robot's."""

from viewimit.drawing import svg
from viewimit.loop.settings import Settings, given
from viewimit.simulation.scene import Scene, load_robot, load_scene

MANY_POINTS = 16  # that more joints than the scene's need at least
WORDS = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


def joint_choices(settings: Settings) -> dict[str, tuple[int, ...] | None]:
    """What `Settings.joints` may become, by name; the present ones too, whatever they are."""
    scene = load_scene(settings.scene, settings.robot)
    every = load_robot(scene.robot).movable_joints
    choices = {_name(scene.moving_joints): None, f"all {_number(len(every))}": every}
    if settings.joints is not None and settings.joints not in (every, scene.moving_joints):
        choices[_name(settings.joints)] = settings.joints
    return choices


def chosen_joints(settings: Settings, choices: dict[str, tuple[int, ...] | None]) -> str:
    """The name of the joints that move now."""
    return next((name for name, joints in choices.items() if joints == settings.joints), next(iter(choices)))


class Freedom:
    """Frees joints and holds them: what that asks of the settings. Both arms keep what angles they have."""

    def __init__(self):
        self._layout: int | None = None  # of the scene's own joints, to come back to

    def fields(self, settings: Settings, scene: Scene, joints: tuple[int, ...] | None) -> dict:
        """Settings to change. scene: with the joints that move now."""
        after = load_scene(settings.scene, settings.robot, joints, body_points=settings.body_points)
        layouts = sorted(map(int, scene.points))
        points = settings.points
        if joints is None:
            points = self._layout if self._layout in layouts else min(layouts, key=lambda n: abs(n - Settings().points))
        elif settings.joints is None:
            self._layout = points
        if len(after.moving_joints) > 2:
            points = max(points, next((n for n in layouts if n >= MANY_POINTS), layouts[-1]))
        return {
            "joints": joints,
            "points": points,
            "demonstrator_deg": _carried(given(settings.demonstrator_deg), scene, after),
            "start_deg": _carried(given(settings.start_deg), scene, after),
        }


def _carried(angles_deg: tuple[float, ...], scene: Scene, after: Scene) -> tuple[float, ...]:
    """Angles of the joints that moved, as angles of those that will; the others are at rest."""
    known = dict(zip(scene.moving_joints, angles_deg))
    return tuple(known.get(joint, after.posture_deg[joint - 1]) for joint in after.moving_joints)


def _name(joints: tuple[int, ...]) -> str:
    return f"{_number(len(joints))}: {', '.join(map(svg.joint_symbol, joints))}"


def _number(count: int) -> str:
    return WORDS[count] if count < len(WORDS) else str(count)
