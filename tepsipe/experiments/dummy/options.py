"""Pathways of the dummy, and the options of its specification curve."""

from dataclasses import dataclass
from typing import Annotated, Literal

from tepsipe.quantities import Frequency, Meanings, Thesis, Time


@dataclass(frozen=True)
class Pathway:
    """One way from raw signals to parameters, by the motion of the leg only."""

    torque: Annotated[
        Literal["leg", "leg-thesis"],
        Meanings(
            {
                "leg": "free body of the leg with consistent signs",
                "leg-thesis": "thesis eq (3-8) as printed, angle towards +y",
            }
        ),
    ]
    """Torque of the joint."""
    marker_instants: Annotated[
        Literal["aligned", "as-sampled"],
        Meanings(
            {
                "aligned": "markers interpolated at common instants",
                "as-sampled": "markers at their own sampling instants, as the thesis must have used them "
                "([decision 5](../docs/decisions/0005-sequential-marker-sampling.md))",
            }
        ),
    ]
    """Instants of the markers."""
    estimator: str
    """Estimator of the parameters (`tepsipe.identification.estimators`); output error and the joint
    likelihood do not use the torque."""


@dataclass(frozen=True)
class FootPathway:
    """One way from raw signals to parameters, by the torque from the force plate."""

    torque: Annotated[
        Literal["foot", "foot-thesis"],
        Meanings(
            {
                "foot": "balance of moments about the ankle, M_x − y_A F_z + l_f F_y − m_f y_A'' l_f / 2",
                "foot-thesis": "from F_y and the acceleration of the leg, thesis eq (3-7) and section 3-1-3; "
                "without the moment of the vertical force",
            }
        ),
    ]
    """Torque of the joint."""
    treadmill_model: Annotated[
        str | None,
        Meanings(
            {
                "null": "F_y and M_x as measured",
                "a model of `weight.models.family`": "the predicted load is subtracted from both",
                "best-frame": "the same, of `bristle-frame` and `linear-frame` with that which predicts "
                "trials best that it has not seen",
            }
        ),
    ]
    """Belt-induced load."""
    # a longer window includes the swing of the leg on the resting belt, without belt-induced load
    window_s: Annotated[
        Time | None,
        Meanings(
            {
                "null": "the perturbation",
                "a time": "begins with the perturbation and lasts this long, at most to the next one",
            }
        ),
    ]
    """Fitted window."""
    estimator: str
    """One of the estimators of `pathways` that fit a torque in windows."""


@dataclass(frozen=True)
class SpecificationOptions:
    """Options of the combinations, in addition to the study's."""

    other_cutoff_hz: Annotated[Frequency, Thesis("Appendix A")]
    """Cutoff in addition to `plate_treadmill.lowpass_cutoff_hz`."""
    command_s: Annotated[Time, Thesis("2-1-2")]
    """Window with the length of the command, from the onset."""
    longer_s: Time
    """Window longer than the perturbation, from the onset, at most to the next one."""
    before_segment_s: Time
    """Time before the onset that counts as rest of a perturbation."""
