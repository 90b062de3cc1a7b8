"""What an experiment is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from ..analysis.trajectory import Imitation
from ..loop.settings import Settings
from ..simulation.scene import Scene, load_scene
from .paper.claims import Claims
from .tables import Tables


class Result(Protocol):
    """What an experiment has found: claims judged by the paper, and the numbers as tables."""

    @property
    def settings(self) -> Settings: ...

    @property
    def claims(self) -> Claims: ...

    @property
    def tables(self) -> Tables: ...


@dataclass(frozen=True)
class Experiment:
    """title: what it repeats, a colon, what of it, as in "Fig. 7: landscape and minima".

    run(settings, tell, **options) → a `Result`; tell(share done, the result so far or None). Raises ValueError for
    settings that it cannot do with. draw(scene, found): SVG in HTML; found: a result, whole or so far, None for an
    empty figure that says what the experiment shows; `draw` is None without a figure for the page.
    imitation(found): what of a whole result is a motion that can be seen, None for none.
    options: those of `run` that a user chooses, of "motion": the demonstrator's, a name or an `analysis.motion.Motion`.
    """

    title: str
    run: Callable[..., Any]
    draw: Callable[..., str] | None = None
    options: tuple[str, ...] = ()
    imitation: Callable[..., Imitation] | None = None

    @property
    def short_title(self) -> str:
        return self.title.split(":")[0]

    def figure(self, found: Result) -> str:
        """Of a result, or of what is there of it so far."""
        settings = found.settings
        scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
        return self._drawn(scene, found)

    def empty_figure(self, scene: Scene) -> str:
        """Frames and axes, and one sentence that says what the experiment shows."""
        return self._drawn(scene, None)

    def _drawn(self, scene: Scene, found: Result | None) -> str:
        return "" if self.draw is None else self.draw(scene, found)
