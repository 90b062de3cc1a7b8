"""What the page calls each transfer and servo, and what it says of them: what it assumes, where it fails."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Method:
    """name: in the dropdown; assumes, fails: a sentence each."""

    name: str
    assumes: str
    fails: str


TRANSFER_NOTES = {
    "epipolar": Method(
        "Epipolar (paper)",
        "Affine cameras: each point is where the epipolar lines of its images in l and r cross.",
        "Lines nearly parallel, and depth in the views: the minimum is degrees off the demonstrator.",
    ),
    "linear": Method(
        "Linear combination",
        "Affine cameras: each own image is an affine function of the demonstrator's shape.",
        "Depth in the views, as for the epipolar one; but no lines are crossed, so none can be parallel.",
    ),
    "rank3": Method(
        "Rank 3, all views",
        "Affine cameras, and equal noise in all four images, which are fitted at once.",
        "Depth in the views: the largest bias of all without noise; the steadiest under much of it.",
    ),
    "projective": Method(
        "Projective combination",
        "Parallel optical axes: both images of a pair have one depth. Then it is exact.",
        "Verged cameras, and much noise: the demonstrator's is amplified, so average its frames.",
    ),
}
SERVO_NOTES = {
    "gradient": Method(
        "Gradient (paper)",
        "That E is convex, and that a gradient learned on the way stays true.",
        "The input fades with E and the gradient goes stale: thousands of motions, mostly without arriving.",
    ),
    "gradient-retuned": Method(
        "Gradient, retuned",
        "The same, with a larger gain, bounded steps and a dither that keeps the gradient fresh.",
        "Hundreds of motions; it never stands still, so it never says that it has arrived.",
    ),
    "broyden": Method(
        "Broyden on images",
        "That the images follow the joints nearly linearly; what E would be is asked, not tried.",
        "Flat valleys and missing points: it may stop degrees away and believe to be there.",
    ),
    "trust-region": Method(
        "Trust region on images",
        "That the images follow the joints smoothly; it predicts them from all postures visited.",
        "Where two postures give the same images, or every transfer misleads: then it says that it stalled.",
    ),
}
