"""All constants that tune the trust-region servo.

Angles are joint displacements in radians. Image quantities are in px of images that are scaled by their own size (see
`observation.in_units`), so none depends on the resolution of a camera. Most are multiples of the measured noise. Where
a source gives a value, it is named. The others are orders of magnitude that follow from the reason beside them.
"""

from dataclasses import dataclass

import numpy as np


def _deg(angle: float) -> float:
    return float(np.radians(angle))


@dataclass(frozen=True)
class TrustRegionOptions:
    """Tuning of `TrustRegion`, its subproblem, its local model and its convergence test."""

    seed: int = 0  # of random searches; `TrustRegion` sets that of the session

    # Region and steps
    first_radius: float = _deg(25.0)  # rad: a probe of 15° predicts images about this far
    max_radius: float = _deg(45.0)  # rad
    min_radius: float = _deg(0.5)  # rad: below it a rejected step counts towards max_rejections
    shrink_below: float = 0.25  # actual over predicted reduction; Nocedal and Wright, Algorithm 4.1
    grow_above: float = 0.6  # actual over predicted reduction; they have 0.75
    shrink_factor: float = 0.4  # of the step made; they have 0.25 of the radius
    grow_factor: float = 2.0  # of the radius; as they have it
    full_step: float = 0.8  # share of the radius, from which a step counts as limited by the region
    max_rejections: int = 2  # short steps in a row that did not reduce E, after which DESCEND is skipped
    max_step: float = _deg(45.0)  # rad per motion, as long as images are known near the visits only
    xtol: float = _deg(0.1)  # rad: shorter steps are not worth a motion
    min_step: float = _deg(0.01)  # rad: shorter steps are no motion, even if they would settle a doubt
    xtol_converged: float = _deg(0.3)  # rad: displacement that E may leave possible where the servo stops
    arrival_tolerance: float = 0.1  # of the expected error: how near the arm must return to its best posture
    max_visits: int = 60  # that are remembered; a prediction costs their number cubed
    same_posture: float = 1e-9  # rad: rounding of two motions to one posture

    # Search strategy: (transfer, first radius) of each rung, tried in turn before a restart; None: the chosen transfer
    ladder: tuple[tuple[str | None, float], ...] = (
        (None, _deg(25.0)),
        ("linear", _deg(25.0)),  # its E has other local minima, so it may lead out of one
        (None, _deg(12.0)),  # from where the second rung led; nearer visits predict images better
    )
    restart_candidates: int = 200  # random postures, of which the one farthest from all visits is taken

    # Kinematics
    # Numbers of visits, minus the number of joints, at which a fit is tried; 1 is after all probes. A fit is costly.
    fit_kinematics_at: tuple[int, ...] = (1, 2, 3, 5, 8, 13, 21, 34, 55)

    # Swapped points
    # Numbers of visits, minus the number of joints, from which each search is due. The first is left out without
    # kinematics.
    swap_search_at: tuple[int, ...] = (1, 5, 10, 16, 24)
    floor_image_share: float = 1e-3  # of the mean square extent of the own image: E that is small
    floor_noise_ratio: float = 25.0  # times the noise variance: E that is small
    swap_grid: int = 12  # postures per joint, for one swapped pair
    swap_grid_two: int = 8  # postures per joint, for two swapped pairs: there are many more hypotheses
    swap_first_pairs: int = 6  # best single pairs that are extended by a second one
    swap_refined: int = 3  # best postures that are refined by least squares
    swap_gain: float = 0.1  # of E without a swap: what a swap must leave, to be accepted where E is not small

    # Unnamed points
    naming_grid_step: float = _deg(10.0)  # rad: between postures that a naming is searched at
    naming_refinement: float = 0.8  # of that step from one attempt to the next
    naming_postures: int = 5000  # at most; random ones where a grid has more
    naming_starts: int = 8  # most similar namings, each refined by least squares
    naming_neighbourhood: float = _deg(45.0)  # rad: a naming is refined from one posture in each cell of this size
    naming_rounds: int = 10  # of refining the posture and the names in turn
    naming_reach: float = _deg(20.0)  # rad: of the posture in a round of refinement, at most
    naming_trials: int = 600  # choices of points that are left out, at most
    naming_left_out: int = 2  # points without a partner, at most, of either body
    naming_min_points: int = 7  # named points: of fewer, E says too little
    naming_samples: int = 16  # of the noise, for the E that it explains
    naming_min_std_px: float = 0.07  # px: rms error of learned kinematics far from all visits, without noise
    naming_rough_noise_px: float = 0.1  # px: of kinematics for a naming, where no exact ones are found
    naming_accept: float = 4.0  # times the E that noise explains: what a naming may leave
    naming_max_noise: float = 2.0  # px²: E by noise, above which wrong names would be accepted too
    naming_distinct: float = _deg(3.0)  # rad: a naming that fits in a posture farther away is another answer
    naming_rival: float = 3.0  # times the E of the answer, or of noise: what another answer may leave at the end
    naming_certain: float = 0.99  # probability from which a name is certain
    naming_enough: int = 10  # certain names with which uncertain ones can be left out
    naming_corrections: int = 8  # of names after the first search, at most
    naming_motions: int = 4  # further motions, at most, before the points count as impossible to name

    # Subproblem
    grid: int = 7  # candidates per joint, for one or two joints
    samples: int = 48  # random candidates, for three joints or more: about as many as 7 x 7
    refined: int = 3  # best candidates that are refined by least squares
    max_prediction_std_px: float = 1.0  # px: std up to which a predicted point serves as a seen one, while E is large
    averaged_variance: float = 0.1  # of a single own image: what kinematics leave of its noise

    # Local model
    max_std_per_px: float = _deg(20.0)  # rad/px: a joint that noise of 1 px turns by more is unobservable

    # Final adjustment
    max_body_sigmas: float = 3.09  # standard deviations; a body like the own one contradicts by more once in a thousand
    max_reason_sigmas: float = 3.72  # as max_body_sigmas, of a reason why another body differs: once in ten thousand
    clear_criterion: float = 10.0  # by which the best reason's criterion is smaller than others', to base a claim on it
    early_criterion: float = 70.0  # the same, to spare the search elsewhere: later visits may show another reason
    max_claimed_std: float = _deg(0.75)  # rad, expected error: if larger, no claim about another body or by kinematics
    max_imitated_std: float = _deg(3.0)  # rad, expected error: if larger, the angles of an explanation are not imitated
    max_earlier: int = 7  # earlier postures of a demonstrator that is another body, adjusted with the present one
    misfit_grid: int = 13  # postures per joint, in which a mirror image is looked for
    max_limit_sigmas: float = 3.0  # expected errors beyond a joint limit, from which it excludes the posture
    same_minimum: float = 3.0  # expected errors between the adjusted posture and a tested one that count as the same

    # Convergence test
    noise_sigmas: float = 3.0  # standard deviations of E above its mean, up to which E is noise
    noise_slack: float = 1.2  # times the noise, which is measured itself
    max_verifications: int = 3  # verification motions per joint, from one restart to the next
    verification_step: float = _deg(2.0)  # rad, without noise
    verification_step_noisy: float = _deg(8.0)  # rad, the shortest with noise
    min_evidence: float = _deg(1.0)  # rad from the posture along a direction, or from all visits, to be evidence
    max_evidence: float = _deg(25.0)  # rad per joint: farther visits are beyond the quadratic model
    min_evidence_noisy: float = _deg(5.5)  # rad, the same with noise: image slopes must stand out
    max_evidence_noisy: float = _deg(15.0)  # rad, also the longest verification motion
    min_own_share: float = 0.6  # of a predicted rise: what the direction must make of it, not the others
    min_rise: float = 0.5  # of the direction's predicted rise: what must be measured
    min_alignment: float = 0.95  # cosine, from which a visit that shows no rise speaks against a direction
    min_conflict_share: float = 1e-4  # of the mean square motion of own images: what must remain as conflict
    significance: float = 3.0  # standard deviations of a measured rise
    trusted_from_joints: int = 3  # from which confirmed kinematics are evidence in spite of noise, as `convergence`
    min_component: float = 0.1  # of a unit direction: smaller components do not turn their joint


DEFAULTS = TrustRegionOptions()
MAX_STD_PER_PX = DEFAULTS.max_std_per_px  # rad/px, by default
