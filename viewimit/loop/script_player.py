"""A script played in a session: what another was led by, done again."""

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from .script import Began, Changed, Deed, Looked, Posed, Rehearsed, Script, Stepped
from .session import Session
from .settings import Settings


def play(script: Script, session: Session) -> None:
    """The session begins anew, and ends at the moment that the script leads to. Raises ValueError for what cannot be
    done."""
    session.begin(script.settings)
    for deed in script.deeds:
        do(session, deed)


def do(session: Session, deed: Deed) -> None:
    """Raises ValueError for what cannot be done."""
    if isinstance(deed, Stepped):
        for _ in range(deed.times):
            session.step()
    elif isinstance(deed, Looked):
        for _ in range(deed.times):
            session.look()
    elif isinstance(deed, Posed):
        session.pose(deed.theta_demo)
    elif isinstance(deed, Changed):
        session.change(**converted(deed.fields))
    elif isinstance(deed, Rehearsed):
        session.rehearse(np.array(deed.postures, float))
    elif isinstance(deed, Began):
        session.begin(deed.settings)
    else:
        session.remember(None)


def converted(fields: Mapping[str, Any]) -> dict[str, Any]:
    """As the fields' types have them. Raises ValueError for a name or value that is none."""
    try:
        whole = msgspec.convert(dict(fields), Settings)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None
    return {name: getattr(whole, name) for name in fields}
