"""What the lecturer's page shows of the class."""

from dataclasses import dataclass

from ...classroom.messages import Orders, Summary, Tally


@dataclass(frozen=True)
class ClassView:
    """leads: whether it is this page that gives orders; students: sorted; sure: whether a click resets all; told:
    whether answers are shown before they are revealed; tally: of the question that goes on; invites: whether the
    address is shown to all."""

    leads: bool
    present: bool
    orders: Orders
    students: tuple[Summary, ...]
    sort: str
    sure: bool
    told: bool
    tally: Tally | None
    problem: str | None
    invites: bool
