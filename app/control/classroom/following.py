"""How a page gets from what was done in its session to what was done in another: on from there, or back."""

from collections.abc import Iterable
from functools import lru_cache

from viewimit.loop.script import Deed, Script, Stepped
from viewimit.loop.settings import Settings

from ...sessions.link import Linked, read

cached_read = lru_cache(16)(read)  # the pages of a process follow the same link


def linked_of(text: str, begun: Settings) -> Linked:
    """As `link.read`."""
    return cached_read(text, begun)


def rest(done: Script, wanted: Script) -> tuple[Deed, ...] | None:
    """What leads from one to the other; None if that is not the way on."""
    if done.settings != wanted.settings:
        return None
    before, after = _merged(done.deeds), _merged(wanted.deeds)
    if not before:
        return tuple(after)
    last = len(before) - 1
    if len(after) <= last or before[:last] != after[:last]:
        return None
    if before[last] == after[last]:
        return tuple(after[last + 1 :])
    here, there = before[last], after[last]
    if isinstance(here, Stepped) and isinstance(there, Stepped) and here.times < there.times:
        return Stepped(there.times - here.times), *after[last + 1 :]
    return None


def only_steps(deeds: Iterable[Deed]) -> bool:
    return all(isinstance(deed, Stepped) for deed in deeds)


def _merged(deeds: Iterable[Deed]) -> list[Deed]:
    """Steps after steps as one."""
    merged: list[Deed] = []
    for deed in deeds:
        if merged and isinstance(deed, Stepped) and isinstance(merged[-1], Stepped):
            merged[-1] = Stepped(merged[-1].times + deed.times)
        else:
            merged.append(deed)
    return merged
