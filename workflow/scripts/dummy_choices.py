"""From sections of the configuration to the library's options: what several scripts need."""

import numpy as np

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.statistics.uncertainty import sources_of


def dummy_options(
    geometry: dict, analysis: dict, belt_fixed_labels=(), uncertainty: dict | None = None
) -> DummyOptions:
    """Options of dummy.geometry, dummy.analysis without bootstrap_draws, dummy.foot.belt_fixed_labels and
    uncertainty.dummy, without which Type B is not evaluated.
    """
    placed, analysis = geometry["leg_markers"], dict(analysis)
    return DummyOptions(
        leg=Leg(
            mass_kg=geometry["leg_mass_kg"],
            com_m=geometry["leg_com_m"],
            inertia_kgm2=geometry["leg_inertia_kgm2"],
            gravity_m_per_s2=geometry["gravity_m_per_s2"],
        ),
        leg_markers=SegmentMarkers(
            tuple(marker["label"] for marker in placed),
            np.array([[marker["anterior_offset_m"], marker["longitudinal_offset_m"]] for marker in placed]),
        ),
        lowpass_cutoff_hz=analysis.pop("lowpass_cutoff_hz"),
        lowpass_order=analysis.pop("lowpass_order"),
        window=WindowOptions(**analysis),
        belt_fixed_labels=tuple(belt_fixed_labels),
        sources=sources_of(uncertainty or {}),
    )


def known_inertia(checks: dict) -> tuple[float, float] | None:
    """Inertia of the joint and its standard uncertainty (N·m·s²/rad) of dummy.checks; None if unknown."""
    known = checks["joint_inertia_Nms2_per_rad"]
    return None if known is None else (known, checks["joint_inertia_uncertainty_Nms2_per_rad"])
