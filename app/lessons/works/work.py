"""A computation that a step's figures and measures show the outcome of, made beside the page."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from viewimit.settings import Settings
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot

from ..format import Step


@dataclass(frozen=True, eq=False)
class Task:
    """A step at one moment. snapshot: what is seen; settings: the session's; sliders: where they stand, by name; seed:
    of what is dealt."""

    step: Step
    world: World
    snapshot: Snapshot
    settings: Settings
    sliders: Mapping[str, float]
    seed: int


@dataclass(frozen=True)
class Work:
    """make(task): outside the page's own thread. when: once as the step is entered, then and whenever a slider was
    turned that changes what is seen, or once it is revealed; played: it has motions, which a step may show one by
    one."""

    make: Callable[[Task], object]
    when: Literal["entered", "turned", "revealed"] = "entered"
    played: bool = False
