"""View-based imitation: a robot copies the posture of another robot that its two cameras see, from image points alone.

The learner sees the demonstrator in the images l and r, and, looking down at itself, its own arm in the images L and R.
From N matched points in these four views it estimates where the demonstrator's points would appear in L and R if both
postures were equal (transfer). The differences to its own points are the residuals e; their mean square is the conflict
E. A servo moves the arm until E is least. No joint angles, link lengths or camera calibration of the demonstrator are
used. After "View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry", IROS 2001.

>>> import numpy as np
>>> from viewimit import TRANSFERS, Session, Settings, conflict
>>> session = Session(Settings(demonstrator_deg=(45, -90), start_deg=(25, -45)))
>>> result = session.run()  # each step: ask the servo, move, look, transfer, evaluate E
>>> print(result.status, np.degrees(result.theta).round(1))
converged [ 45. -90.]
>>> views = result.last.views.used  # or FourViews.from_images(l, r, L, R) of your own points, (N, 2) px each
>>> transfer = TRANSFERS["epipolar"](views)  # Eqs. (1)-(4); recover(l, r) transfers any other points
>>> print(f"E = {conflict(transfer.residual(views)):.2f} px², cond(A) = {transfer.condition:.0f}")
E = 1.59 px², cond(A) = 13

**Conventions.** Angles are radians; they are degrees where a name ends in `_deg`, on the command line and on the page.
Lengths are metres. Image coordinates are pixels, x to the right and y down; cameras look along +z (OpenCV). Shapes
stand in every docstring: m joints, N points, n usable ones. Leading axes (...) are a batch: one function serves a
posture and a grid. A point that is not visible is NaN. A wrong value raises ValueError with its field and bounds.

**Names**

The loop
    `Session`, `Settings` (the best method; `Settings.paper()` is the paper's), `Snapshot` (one pass), `RunResult`
The method
    `FourViews`, `fit_affine_fundamental`, `TRANSFERS`, `conflict`, `SERVOS`, `ServoStatus`
Methods of your own
    `Servo` and `Observation`: ``Session(servo=…)``; a transfer is a function of `FourViews`: ``Session(transfer=…)``
A robot of your own
    `Arm` and `Eyes`: ``Session.of(arm, eyes)``
The simulated world
    `load_scene`, `World`
Results
    `landscape` (E over the range of two joints), `Landscape`, `replay` (a run as one HTML page)

The names are loaded when they are first used. `python -m viewimit` serves the page; `viewimit --help` lists commands.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.2.0"

if TYPE_CHECKING:
    from .analysis.landscape import Landscape, landscape
    from .app.lab.replay import replay
    from .estimation.transfers import TRANSFERS
    from .estimation.transfers.transfer import conflict
    from .estimation.views import FourViews
    from .geometry.affine import fit_affine_fundamental
    from .loop.arm_and_eyes import Arm, Eyes
    from .loop.session import Session
    from .loop.settings import Settings
    from .loop.snapshot import RunResult, Snapshot
    from .servo import SERVOS, Observation, Servo, ServoStatus
    from .simulation.scene import load_scene
    from .simulation.world import World

_MODULES = {
    "Arm": ".loop.arm_and_eyes",
    "Eyes": ".loop.arm_and_eyes",
    "FourViews": ".estimation.views",
    "Landscape": ".analysis.landscape",
    "Observation": ".servo",
    "RunResult": ".loop.snapshot",
    "SERVOS": ".servo",
    "Servo": ".servo",
    "ServoStatus": ".servo",
    "Session": ".loop.session",
    "Settings": ".loop.settings",
    "Snapshot": ".loop.snapshot",
    "TRANSFERS": ".estimation.transfers",
    "World": ".simulation.world",
    "conflict": ".estimation.transfers.transfer",
    "fit_affine_fundamental": ".geometry.affine",
    "landscape": ".analysis.landscape",
    "load_scene": ".simulation.scene",
    "replay": ".app.lab.replay",
}

__all__ = [
    "SERVOS",
    "TRANSFERS",
    "Arm",
    "Eyes",
    "FourViews",
    "Landscape",
    "Observation",
    "RunResult",
    "Servo",
    "ServoStatus",
    "Session",
    "Settings",
    "Snapshot",
    "World",
    "conflict",
    "fit_affine_fundamental",
    "landscape",
    "load_scene",
    "replay",
]


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name], __name__), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
