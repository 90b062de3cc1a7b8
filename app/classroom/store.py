"""The file of a class: what must survive a restart of the server. SQLite. It holds answers, rounds, persons (a hash of
their browser's token and a random number) and the lecturer's settings. Names of persons are not written."""

import asyncio
import contextlib
import hashlib
import logging
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import msgspec

from .protocol import Given, Orders, Phase
from .votes import Round, Vote

BATCH_S = 0.01  # answers of this time are written at once
RETRY_S = 1.0  # after a write that failed
LOCKED_S = 0.5  # of waiting for another program's lock on the file
ADD_ANSWER = "insert or replace into answers values (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"
TABLES = """
create table if not exists kept (key text primary key, value text);
create table if not exists persons (key text primary key, number integer unique);
create table if not exists rounds (number integer primary key, lesson text, step text, phase text, times integer);
create table if not exists answers (
  voter text, person integer, lesson text, step text, phase text, round integer, answer text,
  "right" integer, sure integer, seconds real, place text, primary key (voter, lesson, step, phase)
);
"""
log = logging.getLogger(__name__)
Change = tuple[str, tuple]  # a statement and its values
Columns = tuple[str, int | None, str, str, str, int, str, bool | None, bool | None, float | None, str]  # of answers


def unlinked(token: str, lesson: str, step: str, phase: str) -> str:
    """Return the name of a voter whose answers are not to be linked, another one for each question."""
    return hashlib.sha256("\n".join((token, lesson, step, phase)).encode()).hexdigest()[:32]


class Kept(msgspec.Struct, rename={"last_order": "last order"}):
    """What the file keeps beside answers. salt: of all hashes; code, sessions: hashes."""

    salt: str = ""
    code: str | None = None
    sessions: list[str] = []
    orders: Orders = Orders()
    last_order: int = 0


class Row(NamedTuple):
    """An answer in the file. person: a random number, None if the person's answers are not to be linked."""

    voter: str
    person: int | None
    lesson: str
    step: str
    phase: str  # own, before, after, round 1 …
    round: int  # 0: at the person's own pace
    vote: Vote


class Store:
    """Reads at once, writes in batches in a thread of its own. kept: the lecturer's settings by key, as the file had
    them; persons: numbers by key; rounds: all with their votes, in the order in which they were asked. Raises OSError
    if the file cannot be opened, or is none of a class; then it is not changed."""

    def __init__(self, path: Path):
        self.problem: str | None = None  # why the last write failed
        self._changes: list[Change] = []
        self._done: list[Callable[[], None]] = []  # to be called once all changes are written
        self._tried: list[Callable[[], None]] = []  # to be called once a write has ended, well or not
        self._thread = ThreadPoolExecutor(1)
        self._wake = asyncio.Event()
        self.path = path
        if not path.exists():
            path.touch(0o600)  # for its owner alone
        with self._readable():
            self._file = self._open()
            self._require_own()
            self._file.execute("pragma journal_mode=wal")
            self._file.execute("pragma synchronous=full")
            self._file.executescript(TABLES)
            self._file.create_function("unlinked", 4, unlinked, deterministic=True)
            persons = dict(self._file.execute("select key, number from persons"))
            self.persons = msgspec.convert(persons, dict[str, int])
            kept = dict(self._file.execute("select key, value from kept"))
            for name in {"sessions", "orders"} & kept.keys():
                kept[name] = msgspec.json.decode(kept[name])
            self.kept, self.rounds = msgspec.convert(kept, Kept, strict=False), self._rounds()

    def _open(self) -> sqlite3.Connection:
        return sqlite3.connect(str(self.path), timeout=LOCKED_S, check_same_thread=False, isolation_level="IMMEDIATE")

    @contextlib.contextmanager
    def _readable(self) -> Iterator[None]:
        """Say by an OSError that the file is none of a class."""
        try:
            yield
        except (sqlite3.Error, msgspec.MsgspecError, ValueError, TypeError) as error:
            what = f"{self.path}: is no file of a class, or a damaged one: {error}"
            raise OSError(f"{what}. It is left as it is; name another file") from None

    def _require_own(self) -> None:
        """Raise ValueError for a damaged file, or one of another program. Nothing is written."""
        damage = [row[0] for row in self._file.execute("pragma quick_check(1)") if row[0] != "ok"]
        if damage:
            raise ValueError(damage[0].splitlines()[-1])
        with contextlib.closing(sqlite3.connect(":memory:")) as empty:
            empty.executescript(TABLES)
            own = _columns(empty)
        if (found := _columns(self._file)) and found != own:
            raise ValueError(f"it has the tables {', '.join(found)} of another program")

    # Reading

    def _rounds(self) -> list[Round]:
        rows = self._file.execute("select * from rounds order by number").fetchall()
        by_number = {row[0]: Round(*row) for row in msgspec.convert(rows, list[tuple[int, str, str, Phase, int]])}
        for row in self.answers():
            if row.round in by_number:
                asked = by_number[row.round]
                asked.votes[row.voter] = row.vote
                asked.stayed.add(row.voter)
                asked.most[row.vote.place] += 1
        return list(by_number.values())

    def answers(self) -> list[Row]:
        """Return all answers that are written. It may be called in any thread, and hinders no write."""
        with contextlib.closing(self._open()) as file:
            rows = file.execute("select * from answers").fetchall()
        return [
            Row(*row[:6], Vote(msgspec.json.decode(row[6], type=Given), *row[7:]))
            for row in msgspec.convert(rows, list[Columns], strict=False)
        ]

    # Writing

    def keep(self, key: str, value: str | None, done: Callable[[], None] | None = None) -> None:
        """Write a setting; None deletes it. Call `done` once it is on the disk."""
        if done is not None:
            self._done.append(done)
        if value is None:
            self._add("delete from kept where key = ?", (key,))
        else:
            self._add("insert or replace into kept values (?, ?)", (key, value))

    def add_person(self, key: str, number: int) -> None:
        self._add("insert or replace into persons values (?, ?)", (key, number))

    def add_round(self, asked: Round) -> None:
        row = asked.number, asked.lesson, asked.step, asked.phase, asked.times
        self._add("insert or replace into rounds values (?, ?, ?, ?, ?)", row)

    def add_answer(self, row: Row, done: Callable[[], None]) -> None:
        """Write an answer over the voter's earlier one, and call `done` once it is on the disk."""
        vote, answer = row.vote, msgspec.json.encode(row.vote.answer).decode()
        self._done.append(done)
        self._add(ADD_ANSWER, (*row[:6], answer, vote.right, vote.sure, vote.seconds, vote.place))

    def drop_answers(self, round: int, voters: Iterable[str]) -> None:
        for voter in voters:
            self._add("delete from answers where round = ? and voter = ?", (round, voter))

    def judge(self, asked: Round) -> None:
        """Write which votes of a round are right."""
        for voter, vote in asked.votes.items():
            self._add('update answers set "right" = ? where round = ? and voter = ?', (vote.right, asked.number, voter))

    def unlink(self, person: str, token: str) -> None:
        """Let none of a person's answers tell whose it is, nor which others are the same person's."""
        self._add(
            "update answers set voter = unlinked(?, lesson, step, phase), person = null where voter = ?",
            (token, person),
        )
        self._add("delete from persons where key = ?", (person,))

    def clear(self) -> None:
        """Delete answers, rounds and persons."""
        for table in ("answers", "rounds", "persons"):
            self._add(f"delete from {table}", ())

    def _add(self, statement: str, values: tuple) -> None:
        self._changes.append((statement, values))
        self._wake.set()

    async def write(self) -> None:
        """Write all changes as they come, until cancelled."""
        loop = asyncio.get_running_loop()
        while True:
            await self._wake.wait()
            await asyncio.sleep(BATCH_S)
            self._wake.clear()
            changes, done, tried, self._tried = self._changes[:], self._done[:], self._tried, []
            try:
                await loop.run_in_executor(self._thread, self._commit, changes)
            except sqlite3.Error as error:
                if self.problem is None:
                    log.error("answers are not saved: %s", error)
                self.problem = f"answers are not saved: {error}"
                done = []
            else:
                self.problem = None
                del self._changes[: len(changes)], self._done[: len(done)]
            for call in done + tried:
                call()
            if self.problem is not None:
                await asyncio.sleep(RETRY_S)
                self._wake.set()

    async def flush(self) -> None:
        """Return once everything that waits to be written is on the disk, or at once while writes fail (`problem`)."""
        if self.problem is None:
            tried = asyncio.Event()
            self._tried.append(tried.set)
            self._wake.set()
            await tried.wait()

    @property
    def unsaved(self) -> int:
        """How many answers wait to be written."""
        return sum(statement == ADD_ANSWER for statement, _ in self._changes)

    def close(self) -> None:
        """Write the rest, or log how many answers it lacks, and close the file."""
        self._thread.shutdown()
        try:
            self._commit(self._changes)
        except sqlite3.Error as error:
            log.error("number of answers that could not be saved: %d: %s", self.unsaved, error)
        self._file.close()

    def _commit(self, changes: list[Change]) -> None:
        with self._file:  # as one transaction
            for statement, values in changes:
                self._file.execute(statement, values)


def _columns(file: sqlite3.Connection) -> dict[str, list[str]]:
    """The names of columns by table."""
    names = [name for (name,) in file.execute("select name from sqlite_master where type = 'table' order by name")]
    return {name: [row[0] for row in file.execute("select name from pragma_table_info(?)", (name,))] for name in names}
