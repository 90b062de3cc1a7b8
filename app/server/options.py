"""What a server is started with, as each of its processes gets it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from viewimit.loop.settings import Settings

from ..lab.lessons.format import Lesson
from .limits.connection_limits import Limits

PENDING = 200  # connections of a process without a seat, such as page loads
PAGE_CONNECTIONS = 12  # that a browser or two open at once


@dataclass(frozen=True)
class ServerOptions:
    """settings: what each session begins with; max_clients: tabs at a time; origins: of pages elsewhere that may
    connect; workers: processes that share the visitors; max_per_address: tabs of one address at a time, None: as many
    as there are; lessons: of a lecturer's own, by name, before those that are shipped; host: on which it listens."""

    settings: Settings = Settings.paper()
    max_clients: int = 40
    origins: tuple[str, ...] = ()
    workers: int = 1
    max_per_address: int | None = None
    lessons: Mapping[str, Lesson] = field(default_factory=dict)
    host: str = "127.0.0.1"

    def clients_of(self, worker: int) -> int:
        """How many of the tabs one of the processes takes."""
        return self.max_clients // self.workers + (worker < self.max_clients % self.workers)

    @property
    def seats_of_one(self) -> int:
        """How many of the tabs one address has at most."""
        return self.max_per_address or self.max_clients

    def limits_of(self, worker: int) -> Limits:
        """Of one of the processes."""
        pending_of_one = self.share_of_one(PENDING)
        return Limits(self.clients_of(worker), self.seats_of_one, PENDING, pending_of_one, self.max_clients)

    def share_of_one(self, most: int) -> int:
        """Of connections without a seat one address has the same share as of seats, and a page's own few."""
        return min(most, max(PAGE_CONNECTIONS, most * self.seats_of_one // self.max_clients))
