"""`@command`: declares a function as a command, which keys, buttons, sliders and links call by its name.

A command is a function of the page's model and of typed parameters. What a browser sends for a parameter is checked by
its annotation: `int` and `float` take finite numbers, `bool` a checkbox, `str` any text; `Annotated[T, parse]` takes
what `parse` accepts, which raises ValueError, in words for the visitor, for all else. A keyword-only parameter `now` is
given the time in seconds.
"""

import inspect
from collections.abc import Callable
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from ..model.queue import Command, number, switch, text, whole

COMMANDS: dict[str, Command] = {}
PARSERS: dict[type, Callable[[Any], Any]] = {int: whole, float: number, bool: switch, str: text}
Function = TypeVar("Function", bound=Callable[..., None])


def command(name: str, **options: Any) -> Callable[[Function], Function]:
    """Register a function as the command of this name. options: the last ones of `Command`, by name.

    Raises ValueError for a name that is taken, and for a parameter whose annotation says no parser.
    """

    def register(function: Function) -> Function:
        if name in COMMANDS:
            raise ValueError(f"two commands named {name!r}")
        hints = get_type_hints(function, include_extras=True)
        parameters = list(inspect.signature(function).parameters.values())[1:]  # without the model
        given = [one.name for one in parameters if one.kind is not one.KEYWORD_ONLY]
        parsers = tuple(_parser(name, parameter, hints.get(parameter)) for parameter in given)
        COMMANDS[name] = Command(name, function, parsers, takes_now=len(given) < len(parameters), **options)
        return function

    return register


def _parser(name: str, parameter: str, hint: Any) -> Callable[[Any], Any]:
    found = get_args(hint)[1] if get_origin(hint) is Annotated else PARSERS.get(hint)
    if found is None:
        raise ValueError(f"command {name!r}: {parameter} needs int, float, bool, str or Annotated[type, parse]")
    return found
