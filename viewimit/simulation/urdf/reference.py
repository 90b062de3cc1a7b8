"""How a robot of a person's own is named: the path of a URDF, and which chain of it is the arm.

`arm.urdf`, or `arm.urdf#base=torso&tip=left_hand`, as a part of a document is named in an address; what of a link's
name would be read as more than a name stands there as in an address, too: %26 for &.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

PARTS = ("base", "tip")
ENDING = r"\.urdf(?:#(.*))?$"  # of a path, which may have # in it
QUOTED = str.maketrans({letter: f"%{ord(letter):02X}" for letter in "%&#"})


@dataclass(frozen=True)
class Reference:
    """base, tip: links between which the arm is; None leaves that to `chain.arm_of`."""

    path: Path
    base: str | None = None
    tip: str | None = None

    def __str__(self) -> str:
        parts = {part: getattr(self, part) for part in PARTS}
        named = [f"{part}={link.translate(QUOTED)}" for part, link in parts.items() if link is not None]
        return f"{self.path}#{'&'.join(named)}" if named else str(self.path)


def is_reference(name: object) -> bool:
    """Whether a robot is named by a URDF."""
    return re.search(ENDING, str(name), re.IGNORECASE) is not None


def parse_reference(name: str | Path) -> Reference:
    """Raises ValueError for what stands after # and is neither a base nor a tip."""
    found = re.search(ENDING, str(name), re.IGNORECASE)
    fragment = found[1] if found and found[1] else ""
    path = str(name).removesuffix(f"#{fragment}")
    parts = {part.partition("=")[0]: unquote(part.partition("=")[2]) for part in fragment.split("&") if part}
    if wrong := [part for part, link in parts.items() if part not in PARTS or not link]:
        raise ValueError(f"{path}: #{wrong[0]} is not read: say {path}#base=LINK&tip=LINK, or one of the two")
    return Reference(Path(path), parts.get("base"), parts.get("tip"))
