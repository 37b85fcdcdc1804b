"""Settings of a person standing on the treadmill (thesis sections 2-2, 3-2 and 4-2)."""

from typing import Any, Literal

from pydantic import model_validator

from tepsipe.errors import quoted
from tepsipe.experiments.standing.muscle_torque import ACTIVE, FREE
from workflow.settings.plate_treadmill import MarkerLabels, PlacedMarkers, TreadmillIngest, Window
from workflow.settings.quantities import (
    FilterOrder,
    Fraction,
    Frequency,
    Gravity,
    InnerFraction,
    Mass,
    Pause,
    Positive,
    Stature,
    Time,
    Torque,
    Velocity,
    band,
    different,
    fixed,
    named,
    number,
)
from workflow.settings.section import (
    Section,
    UnfitError,
    meanings,
    one_of,
    optional,
    partial,
    refuse_unknown,
    setting,
    whole,
)

Latency = number(above=0, most=1)  # s
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


class Emg(Section):
    """Filters of the electromyograms."""

    band_hz: band() = setting("Butterworth band-pass", thesis="3-2")
    band_order: FilterOrder = setting("order of both passes together, at each edge", thesis="3-2")
    envelope_cutoff_hz: Frequency = setting(
        "Butterworth low-pass of the rectified signal; the envelope is only shown", thesis="3-2"
    )
    envelope_order: FilterOrder = setting("order of both passes together", thesis="3-2")
    mains_hz: Frequency | None = setting(
        "mains frequency to remove, with its harmonics; null removes nothing"
    )
    notch_width_hz: Frequency = setting("width of each notch")


class StandingAnalysis(Section):
    """Epochs around the perturbations."""

    stretch_cutoff_hz: Frequency = setting(
        "cutoff for the angles that determine which muscles are lengthened first, at most 0.3 of the rate; "
        "order as in `plate_treadmill`"
    )
    window: Window
    quiet_after_s: Pause = setting("time after a perturbation that does not count as unperturbed")
    before_s: Time = setting("length of an epoch before its onset")
    after_s: Time = setting("length of an epoch after its onset")
    baseline_s: fixed(number(most=0), 2) = setting("baseline of an epoch, from the onset")
    least_perturbations: int = setting("a trial with fewer usable perturbations is omitted", least=2)
    line_hz: Frequency = setting(
        "mains frequency, whose hum indicates a loose electrode; to remove hum, use `emg.mains_hz`"
    )
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


class Stance(Section):
    """Limits of quiet standing; a trial beyond them is omitted."""

    foot_shift_m: number(above=0, most=1) = setting(
        "largest displacement of a foot marker relative to the belt within 2 s; more is a step"
    )
    foot_lift_m: number(above=0, most=1) = setting("largest rise of a foot marker")
    other_belt: Positive = setting("largest fraction of the weight on the other belt")
    unloading: Positive = setting(
        "largest fraction of the weight that leaves the plate for longer than `unloading_s`"
    )
    unloading_s: Pause = setting("this time")
    lean_rad: number(above=0, most=3.2) = setting("largest angle of the shank relative to its median")


class TorquePathway(Section):
    """From plate and markers to the torque of both ankles."""

    torque: one_of(
        {
            "ankle-thesis": "thesis eq (3-14) as printed",
            "ankle": "balance of moments of the feet about the ankles, derived consistently",
            "single-joint": "the body above the ankles as one inverted pendulum, from markers only; "
            "included to show that this model fails",
        }
    ) = setting("torque of both ankles")
    treadmill_model: str | None = setting(
        "belt-induced load",
        values={
            "null": "F_y and M_x as measured",
            "a model of `weight.models.family`": "the predicted load is subtracted from both; requires "
            "trials of `weight` and `empty` in the study. `single-joint` does not use the plate",
        },
    )


class StandingEstimator(Section):
    """From responses to parameters."""

    window_s: Time = setting(
        "length of the window from the onset; the fit starts 0.03 s before the onset, because of the "
        "zero-lag filter; at most `analysis.after_s`"
    )
    inertia: bool = setting(
        "true if I is estimated in addition to B and K. The torque contains no inertia, so false is correct"
    )
    active: one_of(meanings(ACTIVE, ABOUT_ACTIVE)) = setting("active torque of the muscles")


class Active(Section):
    """Time constants and delays that are tried for the active torque."""

    twitch_s: different(Latency) = setting("time constants of the twitch response that are tried")
    reflex_delay_s: different(Latency) = setting("delays of the reflex that are tried")
    balance_delay_s: different(Latency) = setting("delays of balance that are tried")


class FreeReflex(Section):
    """Estimators with `active: free`."""

    lowpass_cutoff_hz: Frequency = setting(
        "low-pass of all signals for estimators with `active: free`, at most 0.3 of the rate; order as in "
        "`plate_treadmill`"
    )
    discrepancy: Positive = setting(
        "what the model of the rig leaves: standard deviation as a share of the largest torque"
    )
    discrepancy_s: Time = setting("its length")
    reflex_Nm: Torque = setting(
        "standard deviation of the reflex torque `reflex_after_s` after its earliest instant, at "
        "`reflex_speed_m_per_s` of the belt, in proportion to the speed"
    )
    reflex_after_s: Latency = setting("this time")
    reflex_speed_m_per_s: Velocity = setting("this speed")
    reflex_onset_s: Latency = setting(
        "earliest instant of the reflex torque for single trials, and where no latency of an ankle muscle "
        "is known"
    )
    electromechanical_delay_s: number(least=0, most=1) = setting(
        "from the first latency of an ankle muscle to that instant"
    )
    windows_s: fixed(Time, 2) = setting(
        "the spread of K and B over these windows is a source of their uncertainty"
    )


class Latencies(Section):
    """Responses of the muscles."""

    detector: Literal["threshold", "teager-kaiser", "changepoint"] = setting(
        "the detector shown in figures and used for intervals; all three are computed", thesis="chapter 5"
    )
    baseline_until_s: number(least=-60, most=60) = setting("end of the baseline, from the onset")
    search_s: fixed(number(least=0, most=60), 2) = setting(
        "time of possible onsets; its start at most 0.05 s after `baseline_until_s`"
    )
    window_s: Time = setting("length of the moving mean of `threshold` and `teager-kaiser`")
    threshold_sd: Positive = setting("threshold of both, in standard deviations of the baseline")
    hold_s: Pause = setting("time for which the threshold must be exceeded")
    whitening_order: int = setting("order of the linear prediction of `changepoint`", least=0, most=20)
    signal_to_noise: Positive = setting(
        "number of standard errors by which its activity must exceed the baseline"
    )
    rise_fraction: number(above=0, most=1) = setting(
        "its ramp is fitted up to this fraction of the first peak"
    )
    longest_rise_s: Time = setting("greatest length of the ramp")
    bootstrap_draws: int = setting("number of ensembles resampled from the responses", least=100, most=100000)
    trusted_share: Fraction = setting("fraction of them that must also have an onset")


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
    emg: Emg
    analysis: StandingAnalysis
    stance: Stance
    pathways: named(TorquePathway, NAME) = setting("name: a pathway", thesis="3-2")
    estimators: named(StandingEstimator, NAME) = setting("name: an estimator", thesis="chapter 5")
    active: Active
    free_reflex: FreeReflex
    latency: Latencies
    as_printed: str = setting("one of `pathways`: shown in Figure 4-13", thesis="3-2")
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
