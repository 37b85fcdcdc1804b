"""Constants of the virtual laboratory: the truth."""

from tepsipe.quantities import NotNegative, Pause, Positive, Time
from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import DummyMarkers, DummyTruth, FootTilt
from tepsipe.virtual_lab.dummy_trial import Slip, Wobble
from tepsipe.virtual_lab.electromyography import EmgTruth
from tepsipe.virtual_lab.force_plate import PlateTruth
from tepsipe.virtual_lab.person_constants import (
    MuscleTruth,
    NervesTruth,
    PersonMarkers,
    PersonTruth,
    SkinTruth,
    TaskTruth,
)
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.treadmill_trial import CaptureTruth
from tepsipe.virtual_lab.walker import Joint
from tepsipe.virtual_lab.walking_trial import WalkerBody
from tepsipe.virtual_lab.weight_trial import WeightTruth
from tepsipe.virtual_lab.wristalyzer_trial import ManipulatorTruth
from workflow.settings.section import Section, fixed, made_from, named, optional, partial, setting


class WristalyzerLab(Section):
    """The manipulator."""

    manipulator: made_from(ManipulatorTruth)


class DummyLab(Section):
    """The dummy."""

    rubber: made_from(
        Rubber,
        """Joint of the dummy, the same on the treadmill and in the Wristalyzer.

        `dummy.other_laws` names [other laws](../docs/virtual-laboratory.md#other-laws-of-the-dummys-joint)
        of the joint, each by its constants that differ; null: none.

        [Decision 46](../docs/decisions/0046-dummy-of-the-thesis.md).
        """,
    )
    other_laws: named(partial(made_from(Rubber)), "^[a-z0-9][a-z0-9-]*$") | None = setting(
        "name of another law of the joint: its constants that differ from `rubber`; null: none"
    )
    subject: made_from(DummyTruth)
    markers: made_from(DummyMarkers)
    foot_tilt: made_from(FootTilt)
    wobble: made_from(
        Wobble, "The leg bends, or its markers wobble, as a mass on a spring that the belt accelerates."
    )
    slip: made_from(Slip)


class Tasks(Section):
    """Instructions."""

    relax: made_from(TaskTruth)
    stiff: made_from(TaskTruth)


class Muscles(Section):
    """Muscles."""

    TA: made_from(MuscleTruth)
    SOL: made_from(MuscleTruth)
    GAS: made_from(MuscleTruth)
    BF: made_from(MuscleTruth)
    RF: made_from(MuscleTruth)


class StandingLab(Section):
    """The standing person."""

    person: made_from(
        PersonTruth,
        """Four rigid bodies: feet, shanks, thighs, upper body; lengths follow from the stature.

        What violates an assumption of the analysis is listed, with its sources, in
        [decision 48](../docs/decisions/0048-mechanisms-of-the-person.md); 0 switches it off.
        """,
    )
    tasks: Tasks
    muscles: Muscles
    nerves: made_from(NervesTruth)
    markers: made_from(PersonMarkers)
    skin: made_from(SkinTruth)
    emg: made_from(EmgTruth)


class WalkingLab(Section):
    """Walking."""

    joint: made_from(
        Joint,
        "The ankle whose responses are added to real strides ([walking](../docs/recordings/walking.md)).",
    )
    body: made_from(WalkerBody)


class ProtocolLab(Section):
    """Times of a trial."""

    lead_s: Pause = setting("time logged before the trigger rises")
    tail_s: Pause = setting("time logged after it falls")
    rest_before_s: Time = setting("unperturbed time at the trial's start")
    rest_after_s: Time = setting("unperturbed time at its end")
    rest_after_weight_s: Time = setting(
        "the same at the end of trials with the weight and with the empty belt"
    )
    pulse_s: Time = setting("length of the commanded pulse")


class TreadmillLab(Section):
    """The treadmill, the same for the dummy, the weight, the empty belt and the person."""

    protocol: ProtocolLab
    drive: made_from(DriveTruth)
    plate: made_from(PlateTruth)
    left_plate: partial(made_from(PlateTruth)) = setting(
        "constants of the plate below the left belt that differ"
    )
    capture: made_from(CaptureTruth)


class Distribution(Section):
    """Distribution of a constant around its number in the file: one of the first three, and further keys."""

    normal: NotNegative = optional("`normal: s`: standard deviation *s*")
    rectangular: NotNegative = optional("`rectangular: a`: half width *a*, standard deviation *a*/√3")
    student: fixed(NotNegative, 2) = optional(
        "`student: [s, n]`: standard deviation *s*, with the tails of *n* > 2 degrees of freedom"
    )
    log_uniform: fixed(Positive, 2) = optional(
        "`log_uniform: [a, b]`: from *a* to *b*, whatever the number in the file, uniform in the logarithm"
    )
    one_of: list[float] = optional("`one_of: [a, b, ...]`: one of these, whatever the number in the file")
    relative: bool = optional("true: widths are fractions of the number, whose sign stays")
    positive: bool = optional(
        "true, for a number above 0 with an absolute width: draws of 0 or less are repeated"
    )
    below: float = optional("draws of this or more are repeated, for example of a share at 1")
    shift: float = optional(
        "the mean of each number moves by this many standard deviations, up or down at random"
    )


class VirtualLab(Section):
    """Constants of the virtual laboratory."""

    seed: int = setting(
        "seed of the laboratory. Every trial has its own generator, derived from the seed and the name of "
        "the trial",
        least=0,
    )
    wristalyzer: WristalyzerLab
    dummy: DummyLab
    weight: made_from(WeightTruth)
    heavy_weight: made_from(WeightTruth)
    standing: StandingLab
    walking: WalkingLab
    treadmill: TreadmillLab
    drawn: dict[str, Distribution] | None = setting(
        "path of a constant: its distribution; null draws nothing"
    )
