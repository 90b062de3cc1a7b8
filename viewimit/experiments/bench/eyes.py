"""Eyes for the runs of a study: one scene serves them all, and is set up once in a process."""

from functools import lru_cache

import msgspec

from ...simulation.eyes import ProjectedEyes, SimulatedEyes, open_eyes
from ...simulation.scene import Scene


def shared_eyes(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
    """As `open_eyes`; those that project points remember nothing of a run, so the same ones serve the next."""
    if sensor != "projected":
        return open_eyes(sensor, scene, points)
    return _projected(msgspec.msgpack.encode(scene), points)


@lru_cache(2)
def _projected(scene: bytes, points: int) -> ProjectedEyes:
    """scene: all that it says."""
    return ProjectedEyes(msgspec.msgpack.decode(scene, type=Scene), points)
