"""What was answered, and how far a lesson is: plain data that is kept with the session."""

import msgspec


class Outcome(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of a work that keeps one. seed: of what was dealt; selected: as `Given` has it; numbers: what it came to."""

    seed: int
    selected: tuple[int, ...]
    numbers: tuple[float, ...]


class Given(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """To one step. choice: counted from 0; place: in the unit of its figure; path: postures, degrees, the start first;
    E: px², at each of them; sliders: where they stand; seed: of what is dealt at random; done: what was to be reached
    has been; revealed: what is true was shown; selected: which value of each field, counted from 0, -1 for none yet;
    outcomes: of all seeds up to now, the newest last."""

    choice: int | None = None
    place: tuple[float, float] | None = None
    number: float | None = None
    path: tuple[tuple[float, ...], ...] = ()
    E: tuple[float, ...] = ()
    sliders: tuple[float, ...] = ()
    seed: int = 1
    done: bool = False
    revealed: bool = False
    selected: tuple[int, ...] = ()
    outcomes: tuple[Outcome, ...] = ()


class Progress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """at: the screen that is shown; given: by the steps' ids."""

    lesson: str
    at: int = 0
    given: dict[str, Given] = {}
