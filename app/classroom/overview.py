"""All that stands on the board of a class, for the lecturer's page. What is no message of a class is left out."""

import logging
from collections.abc import Mapping
from typing import TypeVar

from .board import Board
from .member import Rounds, Seen
from .messages import Answer, Copy, Orders, Roster, Round, Summary, call_of, decode
from .orders import earlier_round

M = TypeVar("M", Answer, Copy)
log = logging.getLogger(__name__)


def seen_on(board: Board, orders: Orders) -> Seen:
    """All students, and what was asked of them by these orders."""
    students: dict[str, Summary] = {}
    for data in board.rosters():
        try:
            students |= {one.id: one for one in decode(Roster, data).students}
        except ValueError as error:
            log.warning("students of a process are not shown: %s", error)
    answers: Mapping[str, Answer] = {}
    earlier: Mapping[str, Answer] = {}
    if orders.asked is not None:
        answers = answers_on(board, orders.asked.round)
        before = earlier_round(orders)
        earlier = {} if before is None else answers_on(board, before)
    copy = None
    if orders.wanted is not None:
        found = _read_replies(Copy, board.replies(call_of(orders.wanted)))
        if orders.wanted.student in found:
            copy = orders.wanted.number, found[orders.wanted.student]
    return Seen(tuple(students.values()), answers, earlier, copy)


def rounds_on(board: Board, orders: Orders) -> Rounds:
    """All that was answered to all that was asked."""
    return tuple((asked, answers_on(board, asked)) for asked in orders.rounds)


def answers_on(board: Board, asked: Round) -> dict[str, Answer]:
    """By student."""
    return _read_replies(Answer, board.replies(call_of(asked)))


def _read_replies(kind: type[M], replies: Mapping[str, bytes]) -> dict[str, M]:
    """Those that are some."""
    found = {}
    for student, data in replies.items():
        try:
            found[student] = decode(kind, data)
        except ValueError:
            continue  # one page's nonsense is nobody's answer
    return found
