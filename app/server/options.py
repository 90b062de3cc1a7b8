"""What a server is started with, as each of its processes gets it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from viewimit.settings import Settings

from ..lessons.format import Lesson


@dataclass(frozen=True)
class ServerOptions:
    """settings: what each session begins with; store: where sessions are kept, as `open_store` has it; max_clients:
    tabs at a time; origins: of pages elsewhere that may connect; workers: processes that share the visitors;
    lessons: shown before those that are shipped, by name."""

    settings: Settings = Settings()
    store: str | None = None
    max_clients: int = 40
    origins: tuple[str, ...] = ()
    workers: int = 1
    lessons: Mapping[str, Lesson] = field(default_factory=dict)

    def clients_of(self, worker: int) -> int:
        """How many of the tabs one of the processes takes."""
        return self.max_clients // self.workers + (worker < self.max_clients % self.workers)
