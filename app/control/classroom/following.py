"""How a page gets from what was done in its session to what was done in another: on from there, or back."""

from collections.abc import Iterable
from functools import lru_cache

from viewimit.loop.script import Action, Script, Steps
from viewimit.loop.settings import Settings

from ...sessions.link import Linked, read

cached_read = lru_cache(16)(read)  # the pages of a process follow the same link


def linked_of(text: str, begun: Settings) -> Linked:
    """As `link.read`."""
    return cached_read(text, begun)


def rest(done: Script, wanted: Script) -> tuple[Action, ...] | None:
    """What leads from one to the other; None if that is not the way on."""
    if done.settings != wanted.settings:
        return None
    before, after = _merged(done.actions), _merged(wanted.actions)
    if not before:
        return tuple(after)
    last = len(before) - 1
    if len(after) <= last or before[:last] != after[:last]:
        return None
    if before[last] == after[last]:
        return tuple(after[last + 1 :])
    here, there = before[last], after[last]
    if isinstance(here, Steps) and isinstance(there, Steps) and here.times < there.times:
        return Steps(there.times - here.times), *after[last + 1 :]
    return None


def only_steps(actions: Iterable[Action]) -> bool:
    return all(isinstance(action, Steps) for action in actions)


def _merged(actions: Iterable[Action]) -> list[Action]:
    """Steps after steps as one."""
    merged: list[Action] = []
    for action in actions:
        if merged and isinstance(action, Steps) and isinstance(merged[-1], Steps):
            merged[-1] = Steps(merged[-1].times + action.times)
        else:
            merged.append(action)
    return merged
