"""Why a demonstrator is no body like the own one, or why its posture cannot be reached or claimed, and its words."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np


class MisfitKind(str, Enum):
    """Reasons why a demonstrator is no body like the own one, or why its posture cannot be reached or claimed."""

    ANOTHER_BODY = "another-body"
    """Links between moving joints are longer or shorter, or joints are attached elsewhere."""
    LINK_POINTS = "link-points"
    """The points of one link sit elsewhere on it."""
    POINT = "point"
    """One point sits elsewhere."""
    MIXED_UP = "mixed-up"
    """More than two points of the demonstrator are mixed up; they were put right."""
    TWO_HEADS = "two-heads"
    """Other cameras see the demonstrator than the own body."""
    MIRRORED = "mirrored"
    """The demonstrator is the mirror image of the own body."""
    LENS = "lens"
    """A lens bends the images."""
    ARM = "arm"
    """The arm is not where it was sent."""
    LIMIT = "limit"
    """The demonstrator's posture is beyond a joint limit of the learner."""
    NOT_RIGID = "not-rigid"
    """The learner's own images fit no rigid links: an estimate may be wrong by more than noise explains."""
    NEARLY_FLAT = "nearly-flat"
    """All points move near one plane, as seen against the noise: no reason can be told from another one."""
    EPIPOLE = "epipole"
    """One camera is ahead of the other, so that an epipole lies among the points: no reason can be told either."""
    NONE = "none"
    """None of these explains the images."""

    __str__ = str.__str__


@dataclass(frozen=True)
class LinkChange:
    """How much longer the demonstrator's link between two moving joints is."""

    joints: tuple[int, int]  # indices of the joints at its ends
    change: float  # relative to the own link
    std: float  # of the change


@dataclass(frozen=True)
class BeyondLimit:
    """By how much the demonstrator's posture is beyond a joint limit."""

    joint: int  # index of the moving joint
    beyond: float  # rad, above the highest angle; negative: below the lowest
    std: float  # rad, of that


@dataclass(frozen=True)
class Misfit:
    """The reason, as far as it was found."""

    kind: MisfitKind
    points: tuple[int, ...] = ()  # indices of the points concerned
    links: tuple[LinkChange, ...] = ()  # of another body
    amount: float | None = None  # of a lens: px by which it moves an image coordinate at most; of an arm: the share of
    # each motion by which it stops short, negative if it goes too far; of another body of which all points sit
    # elsewhere: their rms distance, in the rms extent of the own ones; None if unknown
    limits: tuple[BeyondLimit, ...] = ()  # that exclude the posture

    def per_pixel(self, unit_px: float) -> "Misfit":
        """Convert images from image units of unit_px pixels to px."""
        return replace(self, amount=self.amount * unit_px) if self.kind is MisfitKind.LENS and self.amount else self

    def describe(self, joints: Sequence[int] = (), names: Sequence[str] = ()) -> str:
        """Say it in words. joints: numbers of the moving joints, by default from 1; names: of the points."""
        number = lambda joint: joints[joint] if joints else joint + 1
        points = ", ".join(names[point] if names else str(point) for point in self.points)
        if self.kind is MisfitKind.ANOTHER_BODY:
            lengths = [
                f"its link from joint {number(link.joints[0])} to {number(link.joints[1])} is "
                f"{100 * abs(link.change):.1f} ± {100 * link.std:.1g} % {'longer' if link.change > 0 else 'shorter'}"
                for link in self.links
            ]
            if self.amount is not None:
                lengths = [f"its points sit elsewhere by about {100 * self.amount:.1g} % of its size"]
            return "the demonstrator has another body" + (": " + "; ".join(lengths) if lengths else "")
        if self.kind is MisfitKind.LIMIT:
            beyond = [
                f"{np.degrees(abs(one.beyond)):.2f} ± {np.degrees(one.std):.2g}° "
                f"{'above the highest' if one.beyond > 0 else 'below the lowest'} angle of joint {number(one.joint)}"
                for one in self.limits
            ]
            return f"the demonstrator's pose is beyond the limits: {' and '.join(beyond)}"
        return {
            MisfitKind.LINK_POINTS: f"points {points}, of one link, sit elsewhere on the demonstrator",
            MisfitKind.POINT: f"point {points} sits elsewhere on the demonstrator",
            MisfitKind.MIXED_UP: f"the demonstrator's points {points} were mixed up; the learner put them right",
            MisfitKind.TWO_HEADS: "the demonstrator is seen by other cameras than the learner's own arm",
            MisfitKind.MIRRORED: "the demonstrator is a mirror image of the learner",
            MisfitKind.LENS: f"a lens bends the pictures, by up to {self.amount or 0:.2g} px",
            MisfitKind.ARM: _of_arm(self.amount),
            MisfitKind.NOT_RIGID: "the arm or its points do not move as rigid bodies",
            MisfitKind.NEARLY_FLAT: "the points lie too near a plane, for this noise, to compare the bodies by",
            MisfitKind.EPIPOLE: "an epipole lies among the points: put the cameras side by side, none ahead",
            MisfitKind.NONE: "no pose of the learner's body explains the demonstrator's pictures, nor a known reason",
        }[self.kind]


def _of_arm(share: float | None) -> str:
    """share: of each motion that it misses; None if that differs."""
    if share is None:
        return "the arm is not where it was sent"
    return f"the arm {'stops short' if share > 0 else 'goes too far'}, by {100 * abs(share):.1f} % of each step"
