"""The address at which the lab opens in a session's state, as app/lab/view/address.js reads it."""

from urllib.parse import urlencode

import numpy as np
from numpy.typing import NDArray

from viewimit.loop.snapshot import Snapshot

from .page import SHIPPED, presets

TRANSFERS = ("epipolar", "linear", "projective")  # that the lab has
SERVOS = ("broyden", "gradient", "gradient-retuned")
DIGITS = 2  # of an angle in degrees


def lab_address(now: Snapshot) -> str | None:
    """Return the lab's path and fragment for a moment; None for a scene that the lab does not have.

    A servo or a transfer that the lab does not have is left to its default there.
    """
    settings = now.settings
    found = [preset for preset in presets() if (preset.scene or SHIPPED) == settings.scene and not preset.head]
    own = settings.robot, settings.joints, settings.body_points
    if not found or own != (None, None, None) or settings.sensor != "projected":
        return None
    fields = {
        "preset": found[0].name,
        "demo": _degrees(now.theta_demo),
        "start": _degrees(now.theta),
        "law": settings.servo if settings.servo in SERVOS else None,
        "transfer": settings.transfer if settings.transfer in TRANSFERS else None,
        "points": settings.points,
        "noise": settings.noise_px,
        "lost": round(100 * settings.missing, 3),
        "seed": settings.seed,
    }
    return "/lab#" + urlencode({name: value for name, value in fields.items() if value is not None}, safe=",")


def _degrees(theta: NDArray[np.float64]) -> str:
    return ",".join(f"{angle:g}" for angle in np.degrees(theta).round(DIGITS))
