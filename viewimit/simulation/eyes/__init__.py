"""What a session in a scene looks with and moves arms by: projected points, or pictures of arms that have weight."""

import importlib.util
import platform
import sys

from ..markers import marker_names
from ..scene import Scene
from .projected import ProjectedEyes
from .protocol import SimulatedEyes

__all__ = ["SimulatedEyes", "ProjectedEyes", "open_eyes", "require_eyes"]

NEEDS = {"pybullet": "pybullet", "cv2": "opencv"}  # packages, and the extras that bring them
WHEELS = "CPython 3.10 and 3.11 on Linux x86-64"  # of PyBullet; elsewhere pip would compile it, for minutes


def open_eyes(camera: str, scene: Scene, points: int) -> SimulatedEyes:
    """camera: of `settings.CAMERAS`; points: layout of the scene, in place of which pictures show the markers.

    Raises ValueError as `require_eyes`.
    """
    if camera == "points":
        return ProjectedEyes(scene, points)
    require_eyes(camera, scene)
    from .rendered import RenderedEyes  # loads pybullet and OpenCV

    return RenderedEyes(scene)


def require_eyes(camera: str, scene: Scene) -> None:
    """Raises ValueError if what rendered pictures need is not installed, or the scene's robot has no markers, or its
    lenses distort."""
    if camera == "points":
        return
    missing = [package for package in NEEDS if importlib.util.find_spec(package) is None]
    if "pybullet" in missing and not has_wheel():
        raise ValueError(f"camera images need PyBullet, which has wheels only for {WHEELS}")
    if missing:
        extras = ",".join(NEEDS[package] for package in missing)
        raise ValueError(f"camera images need what is not installed: pip install 'viewimit[{extras}]'")
    if scene.robot not in marker_names():
        raise ValueError(f"camera images need markers on the arm, which {' and '.join(marker_names())} have")
    head = scene.stereo_head()
    if head.left.bends or head.right.bends:
        raise ValueError("camera images are rendered without distortion: leave it out of the scene's head")


def has_wheel() -> bool:
    """Whether PyBullet is installed here without a compiler, as pyproject.toml has it by default."""
    here = platform.python_implementation(), sys.platform, platform.machine()
    return here == ("CPython", "linux", "x86_64") and sys.version_info < (3, 12)
