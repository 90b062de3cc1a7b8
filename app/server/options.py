"""What a server is started with, as each of its processes gets it."""

from dataclasses import dataclass

from viewimit.settings import Settings


@dataclass(frozen=True)
class ServerOptions:
    """settings: what each session begins with; store: where sessions are kept, as `open_store` has it; max_clients:
    tabs at a time; origins: of pages elsewhere that may connect; workers: processes that share the visitors."""

    settings: Settings = Settings()
    store: str | None = None
    max_clients: int = 40
    origins: tuple[str, ...] = ()
    workers: int = 1

    def clients_of(self, worker: int) -> int:
        """How many of the tabs one of the processes takes."""
        return self.max_clients // self.workers + (worker < self.max_clients % self.workers)
