"""From sections of the configuration to the library's options: what the standing person's scripts need."""

import numpy as np

from tepsipe.experiments.standing.epochs import EpochOptions
from tepsipe.experiments.standing.free_reflex.fit import FreeReflexOptions
from tepsipe.experiments.standing.free_reflex.results import FreeReflexChoices
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import Person, StanceLimits, StandingOptions
from tepsipe.experiments.standing.thesis.impedance import StandingEstimator
from tepsipe.mechanics.anthropometry import both_feet, standing_body
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.emg import EmgOptions
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.statistics.uncertainty import sources_of


def person_of(choice: dict) -> Person:
    """The person of the section standing.person."""

    def placed(segment: str) -> SegmentMarkers:
        markers = choice[f"{segment}_markers"]
        layout = np.array(
            [[marker["anterior_offset_m"], marker["longitudinal_offset_m"]] for marker in markers]
        )
        return SegmentMarkers(tuple(marker["label"] for marker in markers), layout)

    size = choice["mass_kg"], choice["stature_m"]
    return Person(
        mass_kg=choice["mass_kg"],
        feet=both_feet(*size),
        body=standing_body(*size, choice["com_height"], choice["ankle_height_m"], choice["gravity_m_per_s2"]),
        foot_com_m=choice["foot_com_m"],
        ankle_height_m=choice["ankle_height_m"],
        foot=placed("foot"),
        shank=placed("shank"),
        thigh=placed("thigh"),
    )


def standing_options(person: dict, belt: str, analysis: dict, stance: dict) -> StandingOptions:
    """Options of the sections standing.person, standing.analysis and standing.stance."""
    order = analysis["lowpass_order"]
    return StandingOptions(
        person=person_of(person),
        belt=belt,
        lowpass=Lowpass(analysis["lowpass_cutoff_hz"], order, True),
        stretch_lowpass=Lowpass(analysis["stretch_cutoff_hz"], order, True),
        window=WindowOptions(**analysis["window"]),
        quiet_after_s=analysis["quiet_after_s"],
        limits=StanceLimits(**stance),
    )


def epoch_options(analysis: dict, emg: dict, max_gap_s: float) -> EpochOptions:
    """Options of the sections standing.analysis and standing.emg."""
    return EpochOptions(
        before_s=analysis["before_s"],
        after_s=analysis["after_s"],
        baseline_s=tuple(analysis["baseline_s"]),
        least_perturbations=analysis["least_perturbations"],
        max_gap_s=max_gap_s,
        lowpass_cutoff_hz=analysis["lowpass_cutoff_hz"],
        lowpass_order=analysis["lowpass_order"],
        emg=EmgOptions(**emg),
        mains_hz=analysis["line_hz"],
    )


def estimators_of(choice: dict) -> dict[str, StandingEstimator]:
    """Those of the section standing.estimators."""
    return {name: StandingEstimator(**estimator) for name, estimator in choice.items()}


def active_options(choice: dict, ankle_action: dict[str, int]) -> ActiveOptions:
    """Options of the section standing.active, and of the muscles' ankle_action."""
    action = {muscle: float(acts) for muscle, acts in ankle_action.items() if acts}
    return ActiveOptions(**{key: tuple(times) for key, times in choice.items()}, action=action)


def free_reflex_choices(
    pathway: str, options: dict, uncertainty: dict, draws: int, seed: int
) -> FreeReflexChoices:
    """Choices of the sections standing.free_reflex and uncertainty.standing."""
    windows = tuple(options["windows_s"])
    return FreeReflexChoices(
        pathway, FreeReflexOptions(**{**options, "windows_s": windows}), sources_of(uncertainty), draws, seed
    )
