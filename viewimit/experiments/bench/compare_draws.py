"""On what servo laws are compared: cases, and in each the same bodies, images and noise for all, drawn at random."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Settings
from ...simulation.eyes import ProjectedEyes
from ...simulation.robot import BodyPoints
from ...simulation.scene import Scene, load_scene
from .random_scenes import draw
from .robustness import DEMO_DEG, SEVEN
from .scenes import open_resized, written
from .surface import SurfaceEyes, surface_points

TRIES = 200  # bodies, for one with enough points in sight at both ends


@dataclass(frozen=True)
class Case:
    """changes: of the settings; any_head: in scenes drawn anew for each run; hidden: so many points anywhere on the
    surface, seen where that faces the camera, None for the scene's layout; offset_deg: of the start from the
    demonstrator, None for anywhere."""

    name: str
    changes: dict
    any_head: bool = False
    hidden: int | None = None
    offset_deg: float | None = None


CASES = (
    Case("default scene", {}),
    Case("toed-in heads", {}, any_head=True),
    Case("noise 0.5 px, 25 frames", {"noise_px": 0.5, "frames": 25}),
    Case("20 points, hidden by surfaces", {}, hidden=20),
    Case("seven joints, ±30°, 16 points", {"joints": SEVEN, "points": 16}, offset_deg=30.0),
)


@contextmanager
def drawn(settings: Settings, case: Case, rng: np.random.Generator) -> Iterator[tuple[Session, Settings]]:
    """A session, and the settings that all laws begin with."""
    if case.any_head:
        scenery = draw(rng, any_head=True)
        with written(scenery) as path:
            settings = msgspec.structs.replace(settings, scene=path, points=scenery.points)
            session = Session(settings, partial(open_resized, size=scenery.size))
            yield session, _begun(settings, case, session.scene, rng)
    elif case.hidden is not None:
        scene = load_scene(settings.scene)
        begun = _begun(settings, case, scene, rng)
        for _ in range(TRIES):
            body = surface_points(scene.robot, range(len(scene.posture_deg) + 1), case.hidden, rng)
            session = Session(begun, partial(_open_surface, body=body))
            if session.snapshot.transfer is not None:
                break
        yield session, begun
    else:
        session = Session(settings)
        yield session, _begun(settings, case, session.scene, rng)


def _begun(settings: Settings, case: Case, scene: Scene, rng: np.random.Generator) -> Settings:
    low, high = np.transpose(scene.range_deg)
    if case.offset_deg is None:
        demo, start = rng.uniform(low, high, (2, len(low)))
    else:
        rest = np.array(scene.posture_deg)[scene.moving]
        demo = np.clip(rest + rng.uniform(-DEMO_DEG, DEMO_DEG, len(low)), low, high)
        start = np.clip(demo + rng.uniform(-case.offset_deg, case.offset_deg, len(low)), low, high)
    postures = {"demonstrator_deg": tuple(demo.tolist()), "start_deg": tuple(start.tolist())}
    return msgspec.structs.replace(settings, seed=int(rng.integers(2**32)), **postures)


def _open_surface(camera: str, scene: Scene, points: int, body: tuple[BodyPoints, NDArray]) -> ProjectedEyes:
    return SurfaceEyes(scene, *body)
