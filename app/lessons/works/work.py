"""A computation that a step's figures and measures show the outcome of, made beside the page."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import msgspec

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.world import World

from ..format import Step
from ..scenes import Staging


@dataclass(frozen=True, eq=False)
class Task:
    """A step at one moment. snapshot: what is seen; settings: the session's; sliders: where they stand, by name; seed:
    of what is dealt; staging: what is different about its scene; selected: values of fields of settings,
    by name; made: what the work has come to so far."""

    step: Step
    world: World
    snapshot: Snapshot
    settings: Settings
    sliders: Mapping[str, float]
    seed: int
    staging: Staging = field(default_factory=Staging)
    selected: Mapping[str, Any] = field(default_factory=dict)
    made: Any = None

    def session(self, **changes) -> Session:
        """A new one like the step's, but for changes of its settings."""
        return Session(msgspec.structs.replace(self.settings, **changes), open_eyes=self.staging.open_eyes)


@dataclass(frozen=True)
class Work:
    """make(task): outside the page's own thread. when: once as the step is entered, then and whenever a slider was
    turned that changes what is seen, or once it is revealed; played: it has motions, which a step may show one by
    one; goes_on(made): whether it was only a part, after which it is asked again, so that nobody waits for the whole;
    outcome(made): numbers to be kept once it is whole."""

    make: Callable[[Task], object]
    when: Literal["entered", "turned", "revealed"] = "entered"
    played: bool = False
    goes_on: Callable[[Any], bool] = lambda made: False
    outcome: Callable[[Any], tuple[float, ...]] | None = None
