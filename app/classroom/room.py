"""A class: its persons, the lecturer's orders and the answers. It moves messages and computes nothing else. All methods
run in the server's one thread. A `Browser` is one connection; messages to it wait in its outbox until the server's task
for that connection takes it."""

import asyncio
import hashlib
import hmac
import logging
import secrets
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import msgspec
import segno

from ..server.limits import TokenBucket, network_of
from . import protocol as p
from .report import as_csv, learned
from .store import Row, Store, unlinked
from .votes import QUESTIONS, Asks, Round, Vote, fits, is_right, results

MAX_WAITING = 500  # messages in an outbox, after which its connection is closed: the browser comes back
MESSAGES_PER_S, MESSAGES_AT_ONCE = 25.0, 100  # of one browser, answers resent after a lost connection included
CODES_PER_S, CODES_AT_ONCE = 0.5, 8  # that one browser types
NEW_CODES_PER_S, NEW_CODES_AT_ONCE = 20.0, 100  # that new browsers of one network address type
STAY_S = 2.0  # that a browser is here until it is no new one, and its votes count after it has left
RELEASE_S = 15.0  # without a lecturer, after which students are released
MAX_SESSIONS = 20  # browsers that are logged in as the lecturer's
PERSON_NUMBERS = range(100_000, 1_000_000)
FIRST_NUMBERS = 500_000  # of orders: that of a new file is a random one below it
RELEASED: dict[str, Any] = {"asked": None, "lead": False, "frozen": False, "hidden": False}  # orders of no lecturer
log = logging.getLogger(__name__)


@dataclass(eq=False)
class Person:
    """The user of one browser, in one or more tabs."""

    token: str
    key: str  # a hash of its token, under which its answers are kept
    place: int  # in the class, by which lecturers know the person
    number: int  # random, in the table of answers; never sent, as a name could be joined to it
    since: float  # when its first tab came
    name: str = ""
    linked: bool = True
    tabs: set["Browser"] = field(default_factory=set)
    at: p.At | None = None
    codes: TokenBucket = field(default_factory=lambda: TokenBucket(CODES_PER_S, CODES_AT_ONCE))

    def voter(self, lesson: str, step: str, phase: str) -> str:
        """Return the name under which an answer is kept."""
        return self.key if self.linked else unlinked(self.token, lesson, step, phase)


class Browser:
    """One connection. address: its network address; wake(): called when there is something to send."""

    def __init__(self, address: str, wake: Callable[[], None] = lambda: None):
        self.address, self.wake = address, wake
        self.person: Person | None = None
        self.place = ""  # its network address, as votes have it
        self.session: str | None = None  # the key of the lecturer's session
        self.outbox: deque[str] = deque()
        self.screen: str | None = None  # the lecturer's newest one; older ones are not sent any more
        self.is_too_slow = False
        self.allowance = TokenBucket(MESSAGES_PER_S, MESSAGES_AT_ONCE)

    @property
    def is_lecturer(self) -> bool:
        """Whether somebody has logged in here."""
        return self.session is not None

    def send(self, text: str) -> None:
        """Put a message into the outbox."""
        self.is_too_slow = self.is_too_slow or len(self.outbox) >= MAX_WAITING
        self.outbox.append(text)
        self.wake()

    def show(self, screen: str) -> None:
        """Send the lecturer's screen, instead of an earlier one that still waits."""
        self.screen = screen
        self.wake()


class Room:
    """A class, as its store has it. code: the lecturer's, unless the lecturer has chosen another one, which is_new_code
    forgets; asks: what its lessons ask."""

    def __init__(self, store: Store, code: str, asks: Asks, is_new_code: bool = False):
        self.store, self.asks = store, asks
        kept = store.kept
        self.address = ""  # what students type, if no lecturer's page knows better
        self._salt = kept.salt or secrets.token_hex(16)
        store.keep("salt", self._salt)
        if is_new_code:
            store.keep("code", None)
        self.has_own_code, self._code = False, self._hash(code)
        if kept.code is not None and not is_new_code:
            self.has_own_code, self._code = True, kept.code
        self._sessions: dict[str, None] = dict.fromkeys(kept.sessions)
        self._numbers = store.persons  # by key, of those who have linked answers
        self._places: dict[str, int] = {}  # by key, of all since the server began
        self.rounds, self.orders = store.rounds, kept.orders
        first = max((one.number for one in self.rounds), default=secrets.randbelow(FIRST_NUMBERS))
        self._last_order = kept.last_order or first
        self.persons: dict[str, Person] = {}  # present ones, by key
        self.browsers: set[Browser] = set()
        self.leader: Browser | None = None
        self._stayed: set[str] = set()  # keys of all who were here for a while, since the server began
        self._new_codes: dict[str, TokenBucket] = {}  # by network address
        self._absent_since: float | None = time.monotonic()
        self._requested: tuple[int, Browser, Person] | None = None
        self._requests = 0
        self._screen: str | None = None  # the lecturer's, while all follow it
        self._changed: set[Person] = set()
        self._gone: set[int] = set()
        self._counted = False  # whether lecturers know all answers that came
        self._problem: str | None = None

    # Coming and going

    def leave(self, browser: Browser) -> None:
        """A connection has ended."""
        self.browsers.discard(browser)
        self._leave_class(browser)
        if self.leader is browser:
            self._lead(next(iter(self._lecturers()), None))
        if not self._lecturers() and self._absent_since is None:
            self._absent_since = time.monotonic()

    def _leave_class(self, browser: Browser) -> None:
        person = browser.person
        if person is None:
            return
        person.tabs.discard(browser)
        if not person.tabs and self.persons.get(person.key) is person:
            if (asked := self.asked) is not None:
                self._counted = False
                if person.key in self._stayed:
                    asked.stayed.add(person.voter(asked.lesson, asked.step, asked.label))
            del self.persons[person.key]
            self._gone.add(person.place)
            self._changed.discard(person)

    def _hello(self, browser: Browser, hello: p.Hello) -> None:
        key = hashlib.sha256(f"{self._salt} {hello.token}".encode()).hexdigest()[:32]
        person = self.persons.get(key)
        if person is None:
            place = self._places.setdefault(key, len(self._places) + 1)
            person = Person(hello.token, key, place, self._numbers.get(key) or self._new_number(), time.monotonic())
        person.name = name_of(hello.name)
        self._link(person, hello.linked)
        browser.person, browser.place = person, self._hash(str(network_of((browser.address,))))[:16]
        self.browsers.add(browser)
        session = None if hello.session is None else self._hash(hello.session)
        if session in self._sessions:
            self._become_lecturer(browser, session)
        else:
            self._join_class(browser)
        browser.send(p.encode("welcome", lecturer=browser.is_lecturer))
        browser.send(msgspec.json.encode(self.orders).decode())
        if browser.is_lecturer:
            self._tell_everything(browser)
        elif self.orders.lead and self._screen is not None:
            browser.show(self._screen)

    def _join_class(self, browser: Browser) -> None:
        assert browser.person is not None
        browser.person.tabs.add(browser)
        self.persons[browser.person.key] = browser.person
        self._gone.discard(browser.person.place)
        self._changed.add(browser.person)

    def _tell_of(self, person: Person) -> None:
        """Send lecturers the news of a person in the class, to which the lecturer does not belong."""
        if self.persons.get(person.key) is person:
            self._changed.add(person)

    def _set_self(self, person: Person, message: p.Self) -> None:
        person.name = name_of(message.name)
        self._tell_of(person)
        self._link(person, message.linked)

    def _new_number(self) -> int:
        taken = {*self._numbers.values(), *(one.number for one in self.persons.values())}
        while (number := secrets.choice(PERSON_NUMBERS)) in taken:
            pass
        return number

    # The lecturer

    def _hash(self, text: str) -> str:
        return hmac.new(self._salt.encode(), text.strip().encode(), hashlib.sha256).hexdigest()

    def _login(self, browser: Browser, code: str) -> None:
        if not self._may_try(browser):
            why = "Too many wrong codes. Wait a few seconds, then type it again."
            return browser.send(p.encode("wrong", why=why))
        if not hmac.compare_digest(self._hash(code), self._code):
            log.warning("a wrong lecturer's code from %s", browser.address)
            return browser.send(p.encode("wrong", why="That is not the code of this class."))
        session = secrets.token_hex(16)
        self._leave_class(browser)
        self._become_lecturer(browser, self._hash(session))
        browser.send(p.encode("lecturer", session=session))
        self._tell_everything(browser)

    def _may_try(self, browser: Browser) -> bool:
        """Whether a browser may type a code now: others at its address do not keep it from that."""
        assert browser.person is not None
        bucket_of_place = self._new_codes.setdefault(browser.place, TokenBucket(NEW_CODES_PER_S, NEW_CODES_AT_ONCE))
        return browser.person.codes.take() and (browser.person.key in self._stayed or bucket_of_place.take())

    def _become_lecturer(self, browser: Browser, session: str) -> None:
        self._sessions.pop(session, None)
        self._sessions[session] = None
        for oldest in list(self._sessions)[:-MAX_SESSIONS]:
            del self._sessions[oldest]
        self._keep_sessions()
        browser.session = session
        self._absent_since = None
        self._lead(browser)

    def _keep_sessions(self) -> None:
        self.store.keep("sessions", msgspec.json.encode(list(self._sessions)).decode())

    def _logout(self, browser: Browser) -> None:
        self._sessions.pop(browser.session or "", None)
        self._keep_sessions()
        self._become_student(browser)

    def _become_student(self, browser: Browser) -> None:
        browser.session = None
        self.leave(browser)
        self.browsers.add(browser)
        self._join_class(browser)
        browser.send(p.encode("student"))

    def _change_code(self, browser: Browser, code: str) -> None:
        self._code, self.has_own_code = self._hash(code), True
        for other in self._lecturers():
            if other.session != browser.session:
                self._become_student(other)
        self._sessions = {browser.session or "": None}
        self._keep_sessions()
        done = p.encode("done", what="The code is changed. All other browsers are logged out.")
        self.store.keep("code", self._code, lambda: browser.send(done))

    def _lecturers(self) -> list[Browser]:
        return [one for one in self.browsers if one.is_lecturer]

    def _lead(self, browser: Browser | None) -> None:
        self.leader = browser
        for one in self._lecturers():
            one.send(p.encode("leader", here=one is self.leader))

    def _tell_everything(self, browser: Browser) -> None:
        """Send what a lecturer's page shows, from the beginning."""
        browser.send(p.encode("people", all=True, people=[_described(one) for one in self.persons.values()], gone=[]))
        browser.send(self._count_text())

    # Orders

    def _order(self, **changes: object) -> None:
        if "asked" in changes:
            self._leave_out()
        self.orders = msgspec.structs.replace(self.orders, **changes)
        if not self.orders.lead:
            self._screen = None
        text = msgspec.json.encode(self.orders).decode()
        self.store.keep("orders", text)
        for browser in self.browsers:
            browser.send(text)

    def _new_order(self) -> int:
        """Return a number that no order had before, as browsers remember which ones they have followed."""
        self._last_order += 1
        self.store.keep("last order", str(self._last_order))
        return self._last_order

    @property
    def asked(self) -> Round | None:
        """The round of the question that is asked now."""
        asked = self.orders.asked
        return None if asked is None else next((one for one in self.rounds if one.number == asked.round), None)

    def _staying(self) -> Counter[str]:
        """How many are here and no longer new, by network address."""
        return Counter(next(iter(one.tabs)).place for one in self.persons.values() if one.key in self._stayed)

    def _note_who_stays(self) -> None:
        now = time.monotonic()
        stayed = {one.key for one in self.persons.values() if now - one.since >= STAY_S} - self._stayed
        if stayed:
            self._stayed |= stayed
            self._counted = False
        if (asked := self.asked) is not None:
            asked.most |= self._staying()

    def _left_out(self, asked: Round) -> set[str]:
        """The voters that do not count now; none once the answers are revealed, as `_leave_out` has deleted theirs."""
        if self.orders.asked is None or self.orders.asked.revealed:
            return set()
        here = {one.voter(asked.lesson, asked.step, asked.label) for one in self.persons.values()}
        return asked.left_out(here, self._staying())

    def _leave_out(self) -> int:
        """Delete the votes that do not count in a round that ends now, and return how many those are."""
        if (asked := self.asked) is None:
            return 0
        left_out = self._left_out(asked)
        for voter in left_out:
            del asked.votes[voter]
        self.store.drop_answers(asked.number, left_out)
        return len(left_out)

    def _ask(self, ask: p.Ask) -> None:
        times = 1 + sum((r.lesson, r.step, r.phase) == (ask.lesson, ask.step, ask.phase) for r in self.rounds)
        what = self._new_order(), ask.lesson, ask.step, ask.phase, times
        self.rounds.append(Round(*what))
        self.store.add_round(self.rounds[-1])
        self._order(asked=p.Asked(*what, seed=ask.seed), lead=False)
        self._note_who_stays()
        self._counted = False

    def _reveal(self, truth: tuple[tuple[float, ...], ...], near: float | None) -> None:
        asked, order = self.asked, self.orders.asked
        if asked is None or order is None or order.revealed:
            return
        left_out = self._leave_out()
        if truth and (ask := self.asks.get((asked.lesson, asked.step))) is not None:
            for voter, vote in asked.votes.items():
                asked.votes[voter] = replace(vote, right=is_right(ask, vote.answer, truth, near))
            self.store.judge(asked)
        found = results(asked, self.rounds)
        self._order(asked=msgspec.structs.replace(order, revealed=True, results=found, left_out=left_out))

    def _begin_new_class(self) -> None:
        """Delete all answers, and let students begin their step again."""
        self.store.clear()
        self.rounds, self._numbers = [], {}
        self._order(**RELEASED, gather=None, reset=self.orders.reset + 1)

    def _show(self, browser: Browser, state: p.State) -> None:
        if browser is not self.leader or not (state.once or self.orders.lead):
            return  # a screen on its way while the lecturer released the class, or another page took over
        kind = "send" if state.once else "screen"
        text = f'{{"kind":"{kind}","state":{bytes(state.state).decode()}}}'
        if not state.once:
            self._screen = text
        for one in self.browsers:
            if not one.is_lecturer:
                one.send(text) if state.once else one.show(text)

    def _request(self, browser: Browser, place: int) -> None:
        person = next((one for one in self.persons.values() if one.place == place), None)
        if person is None:
            return browser.send(p.encode("done", what="This student is gone."))
        self._requests += 1
        self._requested = self._requests, browser, person
        next(iter(person.tabs)).send(p.encode("request", number=self._requests))

    def _copy(self, browser: Browser, copy: p.Copy) -> None:
        if self._requested is None:
            return
        number, lecturer, person = self._requested
        if number == copy.number and browser.person is person and lecturer in self.browsers:
            lecturer.send(f'{{"kind":"copy","state":{bytes(copy.state).decode()}}}')
            self._requested = None

    # Answers

    def _answer(self, browser: Browser, answer: p.Answer) -> None:
        person = browser.person
        if person is None or browser.is_lecturer:
            raise p.Rejected("an answer of a browser that is no student")
        ask = self.asks.get((answer.lesson, answer.step))
        is_own = answer.phase == "own"
        if ask is None or is_own == (answer.lesson == QUESTIONS) or not fits(ask, answer.answer):
            return self._refuse(browser, answer, "This class asks nothing like that.")
        phase, asked = str(answer.phase), None
        if answer.round:
            asked = self.asked
            if asked is None or asked.number != answer.round or (self.orders.asked and self.orders.asked.revealed):
                return self._refuse(browser, answer, "It came after the question was closed.")
            if (asked.lesson, asked.step) != (answer.lesson, answer.step):
                raise p.Rejected("an answer to another question")
            phase = asked.label
        voter = person.voter(answer.lesson, answer.step, phase)
        vote = Vote(answer.answer, is_right(ask, answer.answer), answer.sure, answer.seconds, browser.place)
        if asked is not None:
            asked.votes[voter] = vote
            self._counted = False
        if person.linked and self._numbers.get(person.key) != person.number:
            self._numbers[person.key] = person.number
            self.store.add_person(person.key, person.number)
        number = person.number if person.linked else None
        row = Row(voter, number, answer.lesson, answer.step, phase, answer.round, vote)
        self.store.add_answer(row, lambda: browser.send(p.encode("ack", seq=answer.seq)))

    def _refuse(self, browser: Browser, answer: p.Answer, why: str) -> None:
        browser.send(p.encode("refused", seq=answer.seq, why=why))

    async def _saved(self, browser: Browser) -> list[Row]:
        """Return all answers that are on the disk, and tell the browser how many are not."""
        await self.store.flush()
        rows = await asyncio.to_thread(self.store.answers)
        if self.store.problem is not None:
            what = f"Number of answers missing here: {self.store.unsaved}, as {self.store.problem}"
            browser.send(p.encode("done", what=what))
        linked = set(self._numbers.values())  # the file does not know yet who withdrew while writes fail
        return [row if row.person in linked else row._replace(person=None) for row in rows]

    def _link(self, person: Person, linked: bool) -> None:
        """Let a person's answers be linked to each other, or no longer: then earlier ones are unlinked too."""
        person.linked = linked
        if linked or person.key not in self._numbers:  # without a number there are no linked answers
            return
        self.store.unlink(person.key, person.token)
        person.number = self._new_number()
        del self._numbers[person.key]
        for one in self.rounds:
            if (vote := one.votes.pop(person.key, None)) is not None:
                one.votes[unlinked(person.token, one.lesson, one.step, one.label)] = vote

    # Messages

    async def receive(self, browser: Browser, message: p.Message) -> None:
        """Do what a browser's message says. Raises Rejected if this browser may not say that."""
        if not browser.allowance.take():
            raise p.Rejected("too many messages")
        if (browser.person is None) != isinstance(message, p.Hello):
            raise p.Rejected("a connection begins with one hello")
        if isinstance(message, p.ORDERS) and not browser.is_lecturer:
            what = message.what if isinstance(message, p.Order) else type(message).__name__
            raise p.Rejected(f"an order of a browser that is not the lecturer: {what}")
        person = browser.person
        match message:
            case p.Hello():
                self._hello(browser, message)
            case p.Self() if person is not None:
                self._set_self(person, message)
            case p.At() if person is not None:
                person.at = message
                self._tell_of(person)
            case p.Answer():
                self._answer(browser, message)
            case p.Copy():
                self._copy(browser, message)
            case p.Login(code):
                self._login(browser, code)
            case p.NewCode(code):
                self._change_code(browser, code)
            case p.State():
                self._show(browser, message)
            case p.Ask():
                self._ask(message)
            case p.Reveal(truth, near):
                self._reveal(truth, near)
            case p.Switch(what, on):
                self._order(**{what: on})
            case p.Gather(lesson, step, seed):
                self._order(gather=p.Place(self._new_order(), lesson, step, seed), lead=False, asked=None)
            case p.Request(place):
                self._request(browser, place)
            case p.Invite(address):
                address = address or self.address
                browser.send(p.encode("invite", address=address, qr=_qr_code(address)))
            case p.Order("export"):
                browser.send(p.encode("csv", text=await asyncio.to_thread(as_csv, await self._saved(browser))))
            case p.Order("gain"):
                browser.send(p.encode("gain", learned=await asyncio.to_thread(learned, await self._saved(browser))))
            case p.Order("close"):
                self._order(asked=None)
            case p.Order("reset"):
                self._order(reset=self.orders.reset + 1)
            case p.Order("logout"):
                self._logout(browser)
            case p.Order("take"):
                self._lead(browser)
            case p.Order("new"):
                self._begin_new_class()

    # What goes on by itself

    def tick(self) -> None:
        """Tell lecturers what has changed, and release students if no lecturer is left. Call it often."""
        if self._absent_since is not None and time.monotonic() - self._absent_since > RELEASE_S:
            self._absent_since = None
            if msgspec.structs.replace(self.orders, **RELEASED) != self.orders:
                log.info("no lecturer is here: students are released")
                self._order(**RELEASED)
        self._note_who_stays()
        news = []
        if self._changed or self._gone:
            people = [_described(one) for one in self._changed]
            news.append(p.encode("people", people=people, gone=sorted(self._gone)))
            self._changed, self._gone = set(), set()
        if not self._counted or self.store.problem != self._problem:
            self._counted, self._problem = True, self.store.problem
            news.append(self._count_text())
        for lecturer in self._lecturers():
            for text in news:
                lecturer.send(text)

    def _count_text(self) -> str:
        """The question that is asked, and its answers so far, for lecturers alone."""
        asked, found = self.asked, None
        if asked is not None:
            left_out = self._left_out(asked)
            votes = {voter: vote for voter, vote in asked.votes.items() if voter not in left_out}
            found = results(replace(asked, votes=votes), self.rounds)
        times = [{"lesson": one.lesson, "step": one.step, "phase": one.phase} for one in self.rounds]
        return p.encode("count", results=found, round=asked and asked.number, asked=times, problem=self.store.problem)


def _described(person: Person) -> dict[str, object]:
    """A person for a lecturer's page."""
    return {"place": person.place, "name": person.name, "at": person.at}


def _qr_code(text: str) -> str:
    """As the path of an SVG, a module of the code is one unit; "" for no text."""
    if not text:
        return ""
    rows = segno.make(text, micro=False).matrix
    path = "".join(f"M{x} {y}h1v1h-1z" for y, row in enumerate(rows) for x, dark in enumerate(row) if dark)
    return f"{len(rows)} {path}"


def name_of(text: str) -> str:
    """Return what somebody has typed as a name in one short line."""
    return "".join(c for c in " ".join(text.split()) if c.isprintable())[: p.MAX_NAME].strip()
