"""What a page is in a class."""

from ...classroom.messages import Asked
from ..history.past import Left
from .class_view import ClassView


class Role:
    """Of a page that is in no class; `Student` and `Lecturer` say more. name: that its visitor has typed, None where
    nobody is asked for one."""

    name: str | None = None

    @property
    def holds(self) -> str | None:
        """Why the page's controls are locked; None if they are not."""
        return None

    @property
    def follows(self) -> bool:
        """Whether the page shows what the lecturer's does."""
        return False

    @property
    def moves_along(self) -> bool:
        """Whether the lecturer's session plays, which this one follows."""
        return False

    @property
    def asked(self) -> Asked | None:
        """The question that goes on, for this page to answer."""
        return None

    @property
    def own(self) -> Left | None:
        """What was there before the lecturer led, while they do: that, not what is followed, is kept of the page."""
        return None

    def view(self, now: float) -> ClassView | None:
        """What a lecturer's page shows of the class. now: s"""
        return None

    def call(self, name: str) -> None:
        """Its visitor so, where names are asked for."""

    def require_free(self) -> None:
        """Raises ValueError while the lecturer has locked the page's controls."""
        if self.holds is not None:
            raise ValueError(self.holds)
