"""View-based imitation: a learner imitates a demonstrator from image points alone.

After "View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry", IROS 2001.

    Session, Settings, Snapshot     the loop: posture → views → transfer → E → servo → next posture
    Settings.best, Settings.paper   the best method, which Settings() is too, and the paper's
    RunResult                       why Session.run ended, and what it took
    FourViews                       image points in [l], [r], [L], [R], simulated or your own
    TRANSFERS, SERVOS               estimators and servo laws by name
    conflict                        E of the residuals that a fitted transfer gives, Eq. (6)
    fit_affine_fundamental          Eqs. (1)-(3)
    Arm, Eyes                       what to write for a robot and cameras of your own; Session.of(arm, eyes)
    World, load_scene               the simulated world, from a scene file
    landscape, Landscape            E over the range of the two moving joints: landscape(session)
    replay                          a session as one page, in a notebook or a file, that needs no server

The names are loaded when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.2.0"

if TYPE_CHECKING:
    from .analysis.landscape import Landscape, landscape
    from .drawing.export.replay import replay
    from .estimation.residuals import conflict
    from .estimation.transfers import TRANSFERS
    from .estimation.views import FourViews
    from .geometry.affine import fit_affine_fundamental
    from .loop.embodiment import Arm, Eyes
    from .loop.session import Session
    from .loop.settings import Settings
    from .loop.snapshot import RunResult, Snapshot
    from .servo import SERVOS
    from .simulation.scene import load_scene
    from .simulation.world import World

_MODULES = {
    "Arm": ".loop.embodiment",
    "Eyes": ".loop.embodiment",
    "FourViews": ".estimation.views",
    "Landscape": ".analysis.landscape",
    "RunResult": ".loop.snapshot",
    "SERVOS": ".servo",
    "Session": ".loop.session",
    "Settings": ".loop.settings",
    "Snapshot": ".loop.snapshot",
    "TRANSFERS": ".estimation.transfers",
    "World": ".simulation.world",
    "conflict": ".estimation.residuals",
    "fit_affine_fundamental": ".geometry.affine",
    "landscape": ".analysis.landscape",
    "load_scene": ".simulation.scene",
    "replay": ".drawing.export.replay",
}

__all__ = [
    "SERVOS",
    "TRANSFERS",
    "Arm",
    "Eyes",
    "FourViews",
    "Landscape",
    "RunResult",
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
