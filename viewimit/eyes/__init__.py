"""What a session looks with and moves arms by: projected points, or pictures of arms that have weight.

All eyes have `world`, of which they look at the truth; `noise_px`, the standard deviation of a coordinate that their
maker states; demo_images(theta) and own_images(theta) → points (..., N, 4) px, visible (..., N, 2), as `World` has them;
settle(theta), where an arm comes to rest that is told to stand at theta; and drive(settings, theta, sent, commanded),
where one at theta that was last sent to `sent` comes to rest once sent to `commanded`, (m,) rad each.
"""

from ..scene import Scene
from .projected import ProjectedEyes


def open_eyes(camera: str, scene: Scene, points: int) -> ProjectedEyes:
    """camera: of `snapshot.CAMERAS`; points: layout of the scene, which pictures do without: they show the markers.

    Raises ValueError if a scene cannot be seen so, or what pictures need is not installed.
    """
    if camera == "points":
        return ProjectedEyes(scene, points)
    from ..physics import why_not

    if why_not():
        raise ValueError(why_not())
    from .rendered import RenderedEyes  # loads pybullet and OpenCV

    return RenderedEyes(scene)
