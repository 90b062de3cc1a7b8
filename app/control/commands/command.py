"""What all commands have in common: how they wait, whether they need the session to themselves, what they do."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, ClassVar


class Command:
    """An action, of which none is lost.

    moves: it moves, poses or looks, which takes long with camera images. commutes: it makes no difference whether it
    comes before or after any other, so that it need not wait. cancels: it ends the computation that others wait for.
    """

    moves: ClassVar[bool] = False
    commutes: ClassVar[bool] = False
    cancels: ClassVar[bool] = False

    @property
    def control(self) -> Hashable | None:
        """Of commands with the same control the newest is enough; None: each counts."""
        return None

    def opens_pictures(self, model: Any) -> bool:
        """Whether it asks for camera images."""
        return False

    def apply(self, model: Any, now: float) -> None:
        """Carry it out. model: `PageModel`, which imports what commands are made for; now: s. Raises ValueError."""
        raise NotImplementedError


class Value(Command):
    """A control's value."""

    @property
    def control(self) -> Hashable | None:
        return type(self).__qualname__


class OfView(Command):
    """What changes how the session is shown, and nothing of it."""

    commutes: ClassVar[bool] = True


@dataclass(frozen=True)
class Refused(Command):
    """What a browser sent cannot be. sender: the control that it came from; of one the newest is enough."""

    why: str
    sender: Hashable = None

    @property
    def control(self) -> Hashable | None:
        return None if self.sender is None else (Refused, self.sender)

    def apply(self, model: Any, now: float) -> None:
        raise ValueError(self.why)


@dataclass(frozen=True, eq=False)
class Arrival(Command):
    """What a worker has made, handed to whoever asked for it: take(made). kind: of one kind the newest is enough."""

    kind: Hashable
    take: Callable[[Any], None]
    made: Any

    @property
    def control(self) -> Hashable:
        return Arrival, self.kind

    def apply(self, model: Any, now: float) -> None:
        self.take(self.made)


@dataclass(frozen=True, eq=False)
class MovingArrival(Arrival):
    """One that moves the demonstrator."""

    moves: ClassVar[bool] = True
