"""How many connections a process takes, of whom, and how long each may take for what it does."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """seats: tabs of this process; seats_of_one: of all processes, from one address; pending: connections of this
    process that are no seats yet, such as page loads; pending_of_one: of those, from one address; seats_of_all: tabs of
    all processes.

    Times in s. head_within: from the connection to the end of its request's head; page_within: from a handshake to the
    first view; stalled_within: in which a client takes something of what waits for it; written_within: in which a ping
    is on its way behind what waits; closed_within: in which a client that is closed says goodbye.
    """

    seats: int = 40
    seats_of_one: int = 36
    pending: int = 200
    pending_of_one: int = 180
    seats_of_all: int = 40
    head_within: float = 9.0  # less than websockets waits, which then closes without a word
    page_within: float = 30.0
    stalled_within: float = 30.0
    ping_every: float = 15.0
    pong_within: float = 15.0
    written_within: float = 120.0
    closed_within: float = 2.0
