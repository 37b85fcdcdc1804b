"""Settings of a person standing on the treadmill (thesis sections 2-2, 3-2 and 4-2)."""

from typing import Any

from pydantic import model_validator

from tepsipe.errors import quoted
from tepsipe.experiments.standing import options
from tepsipe.experiments.standing.muscle_torque import ACTIVE, FREE, ActiveOptions
from tepsipe.experiments.standing.options import (
    EpochOptions,
    FreeReflexOptions,
    StanceLimits,
    StandingOptions,
    TorquePathway,
)
from tepsipe.quantities import Gravity, InnerFraction, Mass, Stature, Time
from tepsipe.signals.emg import EmgOptions
from tepsipe.signals.onsets import OnsetOptions
from workflow.settings.plate_treadmill import MarkerLabels, PlacedMarkers, TreadmillIngest
from workflow.settings.section import (
    Section,
    UnfitError,
    different,
    made_from,
    meanings,
    named,
    number,
    one_of,
    optional,
    partial,
    refuse_unknown,
    setting,
    whole,
)

NAME = "^[a-z0-9.-]+$"
# what estimators with a model of the muscles' torque need, beside its meaning in the registry
ABOUT_ACTIVE = {
    FREE: "for `recommended.pathway` only, whose torque must be `ankle`; `window_s` at most 0.2; no "
    "`inertia` ([decision 52](../docs/decisions/0052-free-reflex.md))"
}


class StandingFiles(Section):
    """Files of a recording."""

    marker_labels: MarkerLabels = setting(
        "markers in the C3D file, in the order of sequential sampling", thesis="Figure 2-13"
    )
    emg_trigger: str | None = setting(
        "label of the trigger in the file of electromyograms; null if the trigger started their recorder, "
        "whose first sample is then time 0"
    )
    emg_trigger_threshold: float = setting(
        "value above which it is high, for example 0.5 for a line of 0 and 1", unit="unit of that channel"
    )


class Person(Section):
    """Size of the person, and places of the markers."""

    mass_kg: Mass = setting("mass of the body; mass and inertia of the feet follow from it", thesis="2-2")
    stature_m: Stature = setting("stature", thesis="2-2")
    com_height: InnerFraction = setting(
        "height of the body's centre of mass as a fraction of the stature: 0.55 for women, 0.56 for men"
    )
    ankle_height_m: number(above=0, most=0.3) = setting("height of the ankle joint above the belt")
    foot_com_m: number(least=-0.3, most=0.3) = setting(
        "anterior offset of the feet's centre of mass from the ankle, at half the height of the ankle"
    )
    gravity_m_per_s2: Gravity = setting("gravity")
    foot_markers: PlacedMarkers = setting(
        "markers of the foot, at least two: offsets from the ankle, forwards and up, with the foot flat",
        thesis="Figure 2-13",
    )
    shank_markers: PlacedMarkers = setting(
        "markers of the shank: `anterior_offset_m` from the axis from ankle to knee, "
        "`longitudinal_offset_m` from the ankle",
        thesis="Figure 2-13",
    )
    thigh_markers: PlacedMarkers = setting(
        "the same for the axis from knee to hip, `longitudinal_offset_m` from the knee", thesis="Figure 2-13"
    )


class Lengthening(Section):
    """Rotations that lengthen a muscle."""

    ankle: float = optional(
        "lengthening per angle of the ankle, which increases as the shank tips forward; with one joint "
        "only the sign matters"
    )
    knee: float = optional(
        "lengthening per angle of the knee, which increases as the knee extends. The trunk has no marker, "
        "so the hip is not available"
    )

    @model_validator(mode="after")
    def _one_of_both(self) -> Any:
        if not self.model_fields_set:
            raise UnfitError("to have at least 1 entry")
        return self


class Muscle(Section):
    """Muscle whose activity is recorded."""

    channel: str = setting("label in the file of electromyograms; a muscle without channel is omitted")
    ankle_action: whole(-1, 0, 1) = setting(
        "1 if it resists tipping forward (calf), −1 if it resists tipping backward (shin), 0 if it does "
        "not act at the ankle. Muscles with an action drive the torque of `emg`"
    )
    lengthened_by: Lengthening


_OF_TRIAL = made_from(StandingOptions, without=("person", "belt", "lowpass", "limits"))
_OF_EPOCHS = made_from(EpochOptions, without=("max_gap_s", "lowpass_cutoff_hz", "lowpass_order", "emg"))


class StandingAnalysis(_OF_EPOCHS, _OF_TRIAL):
    """Epochs around the perturbations."""

    tried_windows_s: different(Time) = setting("lengths of the window in the figure of K against the window")
    bootstrap_draws: int = setting(
        "bootstrap samples over responses and unperturbed epochs", least=100, most=100000
    )

    @model_validator(mode="after")
    def _times_in_epoch(self) -> Any:
        _ordered("baseline_s", self.baseline_s, -self.before_s, 0.0)
        if max(self.tried_windows_s) > self.after_s:
            expected = f"of at most standing.analysis.after_s ({self.after_s:g} s)"
            found = f"{max(self.tried_windows_s):g} s"
            raise UnfitError(expected, "correct one of the two", "tried_windows_s", found)
        return self


def _ordered(key: str, values: list[float], least: float, most: float) -> None:
    low, high = values
    if not least <= low < high <= most:
        raise UnfitError(
            f"from low to high between {least:g} and {most:g}", key=key, found=f"[{low}, {high}]"
        )


class StandingEstimator(made_from(options.StandingEstimator, without=("active",))):
    """From responses to parameters."""

    active: one_of(meanings(ACTIVE, ABOUT_ACTIVE)) = setting("active torque of the muscles")


class Recommended(Section):
    """Pathway and estimator of the estimate to quote."""

    pathway: str = setting("recommended pathway")
    estimator: str = setting("recommended estimator")


class Standing(Section):
    """A person standing with both feet on one belt."""

    files: StandingFiles
    ingest: TreadmillIngest
    person: Person
    participants: dict[str, partial(Person)] = setting(
        "name of a participant: keys of `person` with other values, for example `{P01: {shank_markers: "
        "[...]}}`; see [Participants](#participants)"
    )
    muscles: named(Muscle) = setting("name: a muscle", thesis="Figure 2-13")
    emg: made_from(EmgOptions)
    analysis: StandingAnalysis
    stance: made_from(StanceLimits)
    pathways: named(made_from(TorquePathway), NAME) = setting("name: a pathway", thesis="3-2")
    estimators: named(StandingEstimator, NAME) = setting("name: an estimator", thesis="chapter 5")
    active: made_from(ActiveOptions, without=("action",))
    free_reflex: made_from(FreeReflexOptions)
    latency: made_from(OnsetOptions)
    as_printed: str = setting(
        "one of `pathways`: shown in Figure 4-13, with every other reading of eq (3-14) in `pathways`",
        thesis="3-2",
    )
    recommended: Recommended
    example_condition: str = setting(
        "condition of Figures 4-13 and 4-14; the last of the sheet if the study does not contain it",
        thesis="Figure 4-13",
    )

    @model_validator(mode="after")
    def _names(self) -> Any:
        recommended = self.recommended
        for key, wanted, section in (
            ("as_printed", self.as_printed, "pathways"),
            ("recommended.pathway", recommended.pathway, "pathways"),
            ("recommended.estimator", recommended.estimator, "estimators"),
        ):
            refuse_unknown(key, wanted, f"standing.{section}", getattr(self, section))
        people = {"person": self.person}
        people |= {f"participants.{name}": differing for name, differing in self.participants.items()}
        for key, person in people.items():
            for segment in ("foot_markers", "shank_markers", "thigh_markers"):
                for marker in getattr(person, segment) or ():
                    if marker.label not in self.files.marker_labels:
                        expected = "to name markers of standing.files.marker_labels"
                        found = quoted(marker.label)
                        raise UnfitError(expected, "correct one of the two", f"{key}.{segment}", found)
        return self

    @model_validator(mode="after")
    def _channels(self) -> Any:
        muscles: dict[str, str] = {}
        for name, muscle in self.muscles.items():
            other = muscles.setdefault(muscle.channel, name)
            if other != name:
                raise UnfitError(
                    "to be the channel of one muscle",
                    "correct one of the two",
                    f"muscles.{name}.channel",
                    f"{quoted(muscle.channel)}, that of standing.muscles.{other}.channel",
                )
        return self

    @model_validator(mode="after")
    def _times(self) -> Any:
        longest = self.analysis.after_s
        for name, estimator in self.estimators.items():
            if estimator.window_s > longest:
                raise UnfitError(
                    f"of at most standing.analysis.after_s ({longest:g} s)",
                    "correct one of the two",
                    f"estimators.{name}.window_s",
                    f"{estimator.window_s:g} s",
                )
        _ordered("latency.search_s", self.latency.search_s, self.latency.baseline_until_s, longest)
        return self
