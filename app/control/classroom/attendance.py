"""What ties a page to the others of its class, while it is open."""

from typing import NamedTuple

from ...classroom.classroom import Classroom
from ...classroom.member import Member
from ..commands.classroom import FollowOn, SeeClass, TakeOrders
from ..page_model import PageModel
from ..queue import CommandQueue
from .lecturer import Lecturer
from .student import Student

TELL_EVERY, FOLLOW_EVERY = 1.0, 0.15  # s


class Attendee(NamedTuple):
    """Who a page is in a class. key: of its session, None if it is not kept; lecturer: whether it is the lecturer's."""

    key: str | None = None
    lecturer: bool = False


class Attendance:
    """Of one page. classroom: None where there is no class."""

    def __init__(self, classroom: Classroom | None, who: Attendee, model: PageModel, queue: CommandQueue):
        self._classroom, self._model, self._queue = classroom, model, queue
        self._told_at = self._followed_at = -float("inf")
        self._member: Member | None = None
        if classroom is None:
            return
        hear = lambda heard: queue.put(TakeOrders(heard))
        see = lambda seen: queue.put(SeeClass(seen))
        if who.lecturer:
            self._member = Member(classroom.id_of(None), hear, see)
            model.role = Lecturer(self._member, queue)
            model.guided.offered = False
        else:
            self._member = Member(classroom.id_of(who.key), hear)
            model.role = Student(self._member, queue)
        classroom.join(self._member)

    def tick(self, now: float) -> None:
        """Tell what the page is, and follow what the lecturer's does; not while a turn goes on beside the scheduler."""
        model, role = self._model, self._model.role
        if isinstance(role, Student) and now - self._told_at >= TELL_EVERY:
            self._told_at = now
            role.tell(model)
        if now - self._followed_at < FOLLOW_EVERY:
            return
        if isinstance(role, Lecturer):
            self._followed_at = now
            role.follow(model)
        elif isinstance(role, Student) and role.due(model):
            self._followed_at = now
            self._queue.put(FollowOn())

    def end(self) -> None:
        if self._classroom is not None and self._member is not None:
            self._classroom.leave(self._member)
