"""The orders of a class: who gives them, and which question was asked before."""

import logging

import msgspec

from .messages import Orders, Round, decode

log = logging.getLogger(__name__)


def taken_over(orders: Orders, by: str, present: bool) -> Orders:
    """What another page had ordered goes on, unless that one had let go by its silence."""
    if present:
        return msgspec.structs.replace(orders, leader=by)
    return msgspec.structs.replace(orders, leader=by, lead=None, frozen=False, asked=None)


def earlier_round(orders: Orders) -> Round | None:
    """When the same step was asked the last time before."""
    asked = orders.asked
    if asked is None:
        return None
    same = [
        one
        for one in orders.rounds
        if (one.lesson, one.step) == (asked.round.lesson, asked.round.step) and one.number < asked.round.number
    ]
    return same[-1] if same else None


def read_orders(data: bytes) -> Orders:
    """None yet, or none of this version: nothing is wanted."""
    try:
        return decode(Orders, data) if data else Orders()
    except ValueError as error:
        log.warning("the lecturer's orders are not followed: %s", error)
        return Orders()
