"""How a robot of a person's own is named: the path of a URDF, and which chain of it is the arm.

`arm.urdf`, or `arm.urdf#base=torso&tip=left_hand`, as a part of a document is named in an address.
"""

import re
from dataclasses import dataclass
from pathlib import Path

PARTS = ("base", "tip")


@dataclass(frozen=True)
class Reference:
    """base, tip: links between which the arm is; None leaves that to `chain.arm_of`."""

    path: Path
    base: str | None = None
    tip: str | None = None

    def __str__(self) -> str:
        named = [f"{part}={link}" for part in PARTS if (link := getattr(self, part)) is not None]
        return f"{self.path}#{'&'.join(named)}" if named else str(self.path)


def is_reference(name: object) -> bool:
    """Whether a robot is named by a URDF."""
    return re.search(r"\.urdf(#.*)?$", str(name), re.IGNORECASE) is not None


def parse_reference(name: str | Path) -> Reference:
    """Raises ValueError for what stands after # and is neither a base nor a tip."""
    path, _, fragment = str(name).partition("#")
    parts = {part.partition("=")[0]: part.partition("=")[2] for part in fragment.split("&") if part}
    if wrong := [part for part, link in parts.items() if part not in PARTS or not link]:
        raise ValueError(f"{path}: #{wrong[0]} is not read: say {path}#base=LINK&tip=LINK, or one of the two")
    return Reference(Path(path), parts.get("base"), parts.get("tip"))
