"""Commands that make a page what a link holds, or what its own tab has kept."""

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from ..model.choices import text
from ..model.following import Played
from ..model.keeping import become
from ..model.page_model import PageModel
from ..model.queue import Queued
from ..sessions.link import decode
from .registry import command

Text = Annotated[str, text("text")]


@dataclass(frozen=True, eq=False)
class Arrived(Queued):
    """What was played beside the page, which becomes it."""

    played: Played
    moves: ClassVar[bool] = True
    cancels: ClassVar[bool] = True

    @property
    def coalesce_key(self) -> Hashable:
        return Arrived

    def needs_camera(self, model: Any) -> bool:
        return self.played.page.uses_pictures

    def apply(self, model: Any, now: float) -> None:
        if model.following.finish(self.played):
            become(model, self.played, now)


@command("link", latest=True, moves=True, link=True)
def follow_link(model: PageModel, address: Text) -> None:
    """Become what a link holds. Its motions are computed beside the page, as that may take seconds."""
    model.following.begin(decode(address, model.begun), Arrived)


@command("session", latest=True, link=True)
def restore_session(model: PageModel, kept: Text) -> None:
    """Become what the tab has kept; an empty text of a new tab."""
    if model.is_kept:
        return
    model.is_kept = True
    if kept:
        try:
            page = decode(kept, model.begun)
        except ValueError as error:
            why = str(error).removeprefix("the link ")
            raise ValueError(f"what this tab has kept {why}, so the session begins again") from None
        model.following.begin(page, Arrived, is_own=True)


@command("resend", latest=True, link=True)
def resend_all(model: PageModel) -> None:
    """Send again all that the tab is to keep, of which it has missed a part."""
    model.resends_all = True


@command("unsaved", latest=True, link=True)
def tell_unsaved(model: PageModel, why: Text) -> None:
    """Take why the browser cannot keep the session; empty where it can."""
    model.unsaved = why[:200] or None
