"""Transfers: from the demonstrator's points in [l], [r] to where they would be in the learner's own views.

Each is one function `fit(views) -> transfer`, where `transfer.recover(l, r)` gives (..., N, 4) px and
`transfer.condition` says how far its linear system amplifies errors (≥ 1, inf where it is singular).
`views` are `FourViews` of points that are all seen; leading axes are a batch of postures.
"""

from . import epipolar, linear_combination, projective, rank3

TRANSFERS = {
    "epipolar": epipolar.fit,
    "linear": linear_combination.fit,
    "rank3": rank3.fit,
    "projective": projective.fit,
}
