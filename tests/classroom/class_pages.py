"""A class without browsers: pages that are ticked by hand, and the thread that would talk to the store as well."""

from page_fakes import QuietLandscapes
from quiet_page import QuietPage
from viewimit.app.classroom.classroom import Classroom
from viewimit.app.classroom.local_board import LocalBoard
from viewimit.app.control.classroom.attendance import Attendee
from viewimit.app.control.commands.classroom import OfClass

NAME, SHARED = "c" * 32, "http://192.0.2.7:8080"


class Class:
    """lecturer: its page, which leads; students: theirs. now: s, of the board and of all pages."""

    def __init__(self, students=1, settings=None, board=None):
        self.now = 100.0
        self.board = board or LocalBoard(lambda: self.now)
        self.classroom = Classroom(self.board, NAME, lambda: self.now)
        self.lecturer = self.open(lecturer=True)
        self.students = [self.open(key=f"student {k}", settings=settings) for k in range(students)]
        self.go_on(2.0)

    def open(self, key=None, lecturer=False, settings=None, resumed=None):
        who = {"classroom": self.classroom, "of_class": Attendee(key, lecturer)}
        page = QuietPage(
            settings, resumed=resumed, address="/touch/0.x", shared=SHARED, **who, landscapes=QuietLandscapes()
        )
        page.now = self.now
        return page

    @property
    def pages(self):
        return [self.lecturer, *self.students]

    def go_on(self, seconds=2.5):
        """All pages and the class, for a while."""
        for _ in range(round(seconds / 0.25)):
            self.now += 0.25
            for page in self.pages:
                page.now = self.now - 0.05
                page.tick()
                page.settle()
                page.tick(0.0)
            self.classroom.turn()

    def do(self, verb, seconds=2.5):
        """The lecturer does it, and all go on for a while."""
        self.lecturer.page.put(OfClass.parse(verb))
        self.go_on(seconds)
