"""What the trust region remembers from one motion to the next, and how a visit is recorded in it."""

from dataclasses import dataclass, replace
from enum import Enum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import Pairs
from ...geometry.kinematics.adjustment import fit_kinematics, predicts_last
from ...geometry.kinematics.disturbed import Shortfall, fit_shortfall
from ...geometry.kinematics.model import ProjectiveKinematics
from ..observation import Observation, Visit
from ..status import ServoStatus
from .convergence import Certificate
from .final_adjustment import PostureEstimate, prediction_sigmas
from .image_models import observations_of
from .localisation import contradicts_command, localise
from .misfit import Explanation, Misfit, MisfitKind
from .motions import distance_to_visits
from .naming import Naming
from .options import TrustRegionOptions

T = TypeVar("T")
MAX_SWAPPED = 2  # points of a single pair, which is no misfit


class Phase(str, Enum):
    """What the trust region does before a motion: see `algorithm`."""

    PROBE = "probe"
    MATCH = "match"
    PLAN = "plan"
    DESCEND = "descend"
    VERIFY = "verify"
    SEARCH = "search"
    REST = "rest"


@dataclass(frozen=True)
class Region:
    """The trust region about the best posture, as of Nocedal and Wright, Algorithm 4.1."""

    radius: float  # rad per joint; inf: the whole range
    predicted_reduction: float | None = None  # px² of E, by the last motion; None: it was no step of DESCEND
    n_rejected: int = 0  # short steps in a row that did not reduce E
    descend_allowed: bool = True  # False at a posture to rest at, and where a step led to a posture visited before


@dataclass(frozen=True)
class Search:
    """How far the search for a smaller E has come. A restart begins it again."""

    rung: int = 0  # index into `TrustRegionOptions.ladder`
    n_restarts: int = 0
    n_verifications: int = 0  # verification motions since the last restart
    min_points: int = 0  # points that must determine E at the best visit: fewer left a joint unobservable
    partial_points: bool = False  # whether points that one camera alone sees are used


@dataclass(frozen=True)
class Destination:
    """A posture that several motions lead to: where a restart begins, or where the arm is to rest."""

    displacement: NDArray[np.float64] | None = None  # (m,) rad; None after the last motion to it, and without one
    status: ServoStatus | None = None  # to report on arrival; None if a restart begins there
    at_joint_limit: bool = False  # whether the predicted minimum is at a joint limit
    by_explanation: bool = False  # whether it is the posture of an explanation, and no minimum of E


@dataclass(frozen=True)
class Swaps:
    """Points of the demonstrator that seem to be swapped."""

    pairs: Pairs = ()  # indices of the points that are swapped back
    n_searches: int = 0  # searches made


@dataclass(frozen=True)
class TrustRegionState:
    """The state of `TrustRegion`. All images, noise and E in it are in units of `unit_px`."""

    visits: tuple[Visit, ...]  # postures and images; the arm is at the last
    joints_to_probe: tuple[int, ...]  # indices
    region: Region
    unit_px: float  # pixels per image unit
    phase: Phase = Phase.PLAN  # in which the last motion was made; PLAN before the first
    search: Search = Search()
    destination: Destination = Destination()
    swaps: Swaps = Swaps()
    naming: Naming | None = None  # of a demonstrator's points that came without names; of the last search
    unnamed: NDArray[np.float64] | None = None  # (N, 4), the points it names, as they came; None once they have moved
    n_naming_motions: int = 0  # made because no naming explained the images
    naming_grid: int = 0  # postures of the grid that names were last searched at
    n_renamings: int = 0  # corrections of the names
    status: ServoStatus = ServoStatus.MOVING
    certificate: Certificate | None = None  # of the posture to rest at; None before E was small anywhere
    estimate: PostureEstimate | None = None  # by the final adjustment; None before it, and without noise
    explanation: Explanation | None = None  # why no posture explains the demonstrator's images; None: not needed yet
    refusal: Misfit | None = None  # why nothing is claimed although E is small enough; None: it is, or not yet known
    earlier: tuple[PostureEstimate, ...] = ()  # earlier postures of a demonstrator that is another body, newest first
    target_moved: tuple[bool, bool] = (False, False)  # whether the demonstrator moved since the last motion; before it
    calibration: tuple[Visit, ...] = ()  # visits of an earlier calibration, until images contradict them
    kinematics: ProjectiveKinematics | None = None  # that explain all visits and predict images everywhere
    confirmed: bool = False  # whether they have predicted a visit far from those that they were fitted to
    doubted: bool = False  # whether the final adjustment allowed no claim by them; until the demonstrator moves
    mismatch: NDArray[np.float64] | None = None  # (m,) rad, where the arm was sent, minus where it is by its images, as
    # with backlash, steps or an obstacle; None: it is where it was sent, or `shortfall` says where it is
    shortfall: Shortfall | None = None  # by which it stops short of where it is sent; None: no sign of that
    sent: tuple[NDArray[np.float64], ...] = ()  # (m,) rad, where it was sent at each visit, with a shortfall

    @property
    def probe(self) -> bool:
        """Whether the last motion was made to learn, not to arrive."""
        return self.phase in (Phase.PROBE, Phase.MATCH, Phase.VERIFY)

    @property
    def exchanged(self) -> Pairs:
        """Pairs of swapped points, as `ServoState.exchanged`."""
        return self.swaps.pairs

    @property
    def misfit(self) -> Misfit | None:
        """Why the demonstrator is no body like the own one, or the arm not where it was sent; None: no such sign."""
        if self.explanation is not None:
            return self.explanation.misfit
        if self.refusal is not None:
            return self.refusal
        if len(mixed_up := {point for pair in self.swaps.pairs for point in pair}) > MAX_SWAPPED:
            return Misfit(MisfitKind.MIXED_UP, tuple(sorted(mixed_up)))
        if self.shortfall is not None:
            return Misfit(MisfitKind.ARM, amount=self.shortfall.share)
        return None if self.mismatch is None else Misfit(MisfitKind.ARM)

    def known_postures(self, options: TrustRegionOptions) -> tuple[PostureEstimate, ...]:
        """Postures of a demonstrator that is another body, newest first, with the present one if it convinces."""
        found = self.explanation
        if found is None or found.misfit.kind is not MisfitKind.ANOTHER_BODY:
            return self.earlier
        if not found.is_convincing(options.max_body_sigmas, options.clear_criterion):
            return self.earlier
        return (found.estimate, *self.earlier)[: options.max_earlier]

    @property
    def trusts_explanation(self) -> bool:
        """Whether the arm is on its way to, or at, the posture of an explanation: E is not asked there."""
        return self.destination.by_explanation and self.destination.status is not None

    @property
    def known(self) -> tuple[Visit, ...]:
        """All visits that images are predicted from, the calibration first."""
        return (*self.calibration, *self.visits)

    @property
    def trusts_kinematics(self) -> bool:
        """Whether kinematics are evidence, as of `convergence`."""
        return self.confirmed and not self.doubted

    @property
    def has_global_model(self) -> bool:
        """Whether images are predicted over the whole range."""
        return bool(self.calibration) or self.kinematics is not None

    @property
    def effective_radius(self) -> float:
        """Radius of the subproblem, rad per joint."""
        return np.inf if self.kinematics is not None else self.region.radius

    @property
    def is_tracking(self) -> bool:
        """Whether the demonstrator moved before each of the last two motions."""
        return all(self.target_moved)


def initial_state(observation: Observation, unit_px: float, options: TrustRegionOptions) -> TrustRegionState:
    """Return the state before the first motion. observation: in image units."""
    probes = () if observation.calibration else tuple(range(len(observation.displacement)))
    region = first_region(observation.calibration, options)
    return TrustRegionState((visit_of(observation),), probes, region, unit_px, calibration=observation.calibration)


def first_region(calibration: tuple[Visit, ...], options: TrustRegionOptions) -> Region:
    """Return the region of a new search: the whole range after a calibration."""
    return Region(np.inf if calibration else options.first_radius)


def visit_of(observation: Observation) -> Visit:
    """Return the visit that an observation shows."""
    return Visit.of(observation.displacement, observation.own, observation.seen)


def record_visit(
    state: TrustRegionState, observation: Observation, options: TrustRegionOptions
) -> tuple[TrustRegionState, Observation]:
    """Add the posture and its images to the state.

    Parameters
    ----------
    state : TrustRegionState
    observation : Observation
        In image units; displacements as commanded.
    options : TrustRegionOptions

    Returns
    -------
    state, observation
        The observation's displacement and limits are relative to where the arm is by its images.
    """
    state, here = replace(state, target_moved=(False, state.target_moved[0])), visit_of(observation)
    if state.mismatch is not None:
        return _localise_from_images(state, state.mismatch, observation, options)
    before, sent = state.visits[-1].displacement, observation.displacement
    again = np.array_equal(before if state.shortfall is None else state.sent[-1], sent)
    if state.shortfall is not None:
        there = before if again else sent  # a fit will tell where the arm is
        observation = replace(observation, displacement=there)
        here, state = replace(here, displacement=there), replace(state, sent=_last(state.sent, sent, again, options))
    after = replace(state, visits=_last(state.visits, here, again, options))
    if again and len(after.visits) > 1:
        return after, observation
    after = _with_kinematics(after, observation, options)
    if not again and after.kinematics is None and contradicts_command(state.known, here, observation.noise_px):
        return _on_mismatch(state, here, options), observation
    return after, replace(observation, displacement=after.visits[-1].displacement)


def _last(before: tuple[T, ...], one: T, again: bool, options: TrustRegionOptions) -> tuple[T, ...]:
    """Add what a visit shows, in place of the last one if the arm has not moved, and forget the oldest."""
    return (*before[: -1 if again else None], one)[-options.max_visits :]


def _with_kinematics(
    state: TrustRegionState, observation: Observation, options: TrustRegionOptions
) -> TrustRegionState:
    """Fit kinematics that explain all visits: at some visits until one fits, then at each."""
    since = len(state.visits) - (0 if state.calibration else len(observation.displacement))
    if state.kinematics is None and since not in options.fit_kinematics_at:
        return state
    if state.shortfall is None:
        found = fit_kinematics(
            observations_of(state.known), observation.noise_px, observation.rectification, state.kinematics
        )
        if found is not None or state.calibration:
            return replace(
                state, kinematics=found, confirmed=_is_confirmed(state, found, observation.noise_px, options)
            )
    return _with_shortfall(state, observation)


def _is_confirmed(
    state: TrustRegionState, found: ProjectiveKinematics | None, noise_px: float, options: TrustRegionOptions
) -> bool:
    """Whether a visit far from all others has confirmed the kinematics, and the last one does not contradict.

    Without noise they must have predicted it exactly.
    """
    if found is None or state.kinematics is None:
        return False
    if noise_px > 0 and len(found.reference) < options.trusted_from_joints:
        return False
    *earlier, last = state.known
    far = options.min_evidence if noise_px == 0 else options.min_evidence_noisy
    if not state.confirmed and distance_to_visits(tuple(earlier), last.displacement[None])[0] < far:
        return False
    if noise_px == 0:
        return predicts_last(state.kinematics, observations_of(state.known))
    sigmas = prediction_sigmas(state.kinematics, found, observations_of(state.known), noise_px)
    return sigmas < options.max_body_sigmas


def _with_shortfall(state: TrustRegionState, observation: Observation) -> TrustRegionState:
    """Fit kinematics of an arm that stops short; without any, it counts as where it was sent."""
    if state.shortfall is None:
        sent = tuple(visit.displacement for visit in state.visits)
    else:  # where it was sent to the oldest visit may be forgotten, but not where it was
        sent = (state.visits[0].displacement, *state.sent[1:])
    of_visits = replace(observations_of(state.visits), displacement=np.array(sent))
    previous = None if state.shortfall is None or state.kinematics is None else (state.kinematics, state.shortfall)
    found = fit_shortfall(of_visits, observation.noise_px, observation.rectification, previous)
    kinematics, shortfall = (None, None) if found is None else found
    reached = sent if shortfall is None else shortfall.reached(np.array(sent))
    visits = tuple(replace(visit, displacement=there) for visit, there in zip(state.visits, reached))
    return replace(
        state,
        visits=visits,
        kinematics=kinematics,
        confirmed=False,
        shortfall=shortfall,
        sent=sent if shortfall is not None else (),
    )


def _on_mismatch(state: TrustRegionState, here: Visit, options: TrustRegionOptions) -> TrustRegionState:
    """Begin again with probes: the displacements commanded so far are not those of the images."""
    joints = len(here.displacement)
    return TrustRegionState(
        (here,),
        tuple(range(joints)),
        first_region((), options),
        state.unit_px,
        search=Search(n_restarts=state.search.n_restarts),
        swaps=state.swaps,
        naming=state.naming,
        unnamed=state.unnamed,
        target_moved=(False, state.target_moved[1]),
        mismatch=np.zeros(joints),
    )


def _localise_from_images(
    state: TrustRegionState, mismatch: NDArray[np.float64], observation: Observation, options: TrustRegionOptions
) -> tuple[TrustRegionState, Observation]:
    """Record a visit where the arm is by its images.

    After a step that led to a posture visited before, DESCEND is skipped: it would make the same step again.
    """
    last, sent = state.visits[-1].displacement, visit_of(observation.with_origin(mismatch))
    if np.abs(sent.displacement - last).max() < options.same_posture:
        here, been = replace(sent, displacement=last), False
    else:
        here, been = localise(state.known, sent, observation.noise_px)
    region = state.region
    if been and region.predicted_reduction is not None:
        region = replace(region, predicted_reduction=None, descend_allowed=False)
    before = state.visits[:-1] if np.array_equal(here.displacement, last) else state.visits
    offset = observation.displacement - here.displacement
    state = replace(state, visits=(*before, here)[-options.max_visits :], region=region, mismatch=offset)
    return state, replace(observation.with_origin(offset), displacement=here.displacement)


def without_calibration(state: TrustRegionState, options: TrustRegionOptions) -> TrustRegionState:
    """Drop a calibration that the images contradict: points, base or cameras have moved since."""
    visits, joints = state.visits, len(state.visits[0].displacement)
    probes = tuple(range(joints)) if len(visits) <= joints else ()
    return TrustRegionState(
        visits, probes, first_region((), options), state.unit_px, target_moved=(False, state.target_moved[1])
    )
