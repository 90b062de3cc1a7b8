"""What dropdowns call what they offer."""

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

SPEEDS = {
    "1 in 2 s": 0.5,
    "1 a second": 1.0,
    "2 a second": 2.0,
    "4 a second": 4.0,
    "10 a second": 10.0,
    "all it can": 0.0,
}  # motions a second; 0 is as fast as it computes
NO_POINT = "none"


def transfer_names() -> dict[str, str]:
    """Titles by name, of those that there are now."""
    return {name: method.title for name, method in TRANSFERS.items()}


def servo_names() -> dict[str, str]:
    return {name: servo.title for name, servo in SERVOS.items()}


def modified(preset: str) -> str:
    """A preset whose settings have been changed; first of all that, as a narrow list cuts off what is last."""
    return f"(modified) {preset}"
