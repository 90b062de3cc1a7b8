"""What was answered, and how far a lesson is: plain data that is kept with the session."""

import msgspec


class Given(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """To one step. choice: counted from 0; place: in the unit of its figure; path: postures, degrees, the start first;
    E: px², at each of them; sliders: where they stand; seed: of what is dealt at random; done: what was to be reached
    has been; revealed: what is true was shown."""

    choice: int | None = None
    place: tuple[float, float] | None = None
    number: float | None = None
    path: tuple[tuple[float, ...], ...] = ()
    E: tuple[float, ...] = ()
    sliders: tuple[float, ...] = ()
    seed: int = 1
    done: bool = False
    revealed: bool = False


class Progress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """at: the screen that is shown; given: by the steps' ids."""

    lesson: str
    at: int = 0
    given: dict[str, Given] = {}
