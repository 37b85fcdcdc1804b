"""Settings of the weight, the empty belt and a recorded treadmill, and of models of a treadmill."""

from typing import Any, Literal

from pydantic import model_validator

from tepsipe.errors import InputError
from tepsipe.quantities import Delimiter, Frequency, Pause, Time
from tepsipe.treadmill.options import FRAMES, ModelOptions
from tepsipe.treadmill.options import Weight as KnownWeight
from workflow.settings.plate_treadmill import MarkerLabels, TreadmillIngest, TriggerIngest, Window
from workflow.settings.section import Section, UnfitError, different, made_from, refuse_unknown, setting, some

# name: description, size in the column `order` of the scores, lead
MODELS = {
    "mean-subtraction": (
        "mean load over the perturbations of the empty belt, subtracted condition by condition from the "
        "onset on (thesis eq 3-11)",
        "conditions",
        "–",
    ),
    "mass-spring-damper": (
        "m a + c (v − mean) + k (y − trend) + d of belt acceleration, velocity and position (thesis "
        "chapter 5)",
        "2",
        "mean and trend of the whole recording",
    ),
    "hnat2014": (
        "discrete transfer function from a to L, two poles, fitted by output error from the published "
        "starting values (Hnat and van den Bogert 2014)",
        "poles, 2",
        "no",
    ),
    "output-error": ("the same with `output_error_order` poles, kept stable", "poles", "no"),
    "fir-causal": ("finite impulse response from a to L, least squares", "taps", "no"),
    "fir": ("the same with a lead", "taps", "`fir_lead_s`"),
    "spectral": ("H1 = S_aL / S_aa as an impulse response", "taps", "half of `spectral_segment_s`"),
    "loaded-frame": (
        "resonance of the frame with its load, friction that increases with the load, mounts that relax",
        "2",
        "whole recording",
    ),
    "bristle-frame": (
        "the same, and friction with memory, a lever of the friction, cross-talk and a second mode, each if "
        "cross-validation asks for it; fitted to force and moment together "
        "([decision 53](../docs/decisions/0053-friction-with-memory.md))",
        "2 or 4",
        "whole recording",
    ),
    "linear-frame": (
        "frame whose load is linear in the measured one, with pitch, delay between the logs of force and "
        "belt, friction with memory and a second mode, the latter two if cross-validation asks for them; "
        "fitted to force and moment together ([decision 71](../docs/decisions/0071-linear-frame.md))",
        "4",
        "whole recording",
    ),
    "ripple-tracking": (
        "`fir`, and lines at fixed orders over travelled distance, tracked from past samples of the load",
        "lines",
        "as `fir`",
    ),
}
Family = Literal[tuple(MODELS)]


class FittedModels(Section):
    """Models that are fitted, whose options stand below them."""

    family: different(Family) = setting("models to fit, see [Models of a treadmill](#models-of-a-treadmill)")


class PlateModels(made_from(ModelOptions, without=("ripple",)), FittedModels):
    """Models of the load on the force plate."""

    calibration_draws: int = setting(
        "number of draws of the constants of `bristle-frame` and `linear-frame`, for the uncertainty of what "
        "they compensate",
        least=2,
    )


def _refuse_unsuited(family: list[str], unsuited: tuple[str, ...], why: str) -> None:
    for model in unsuited:
        if model in family:
            expected, found = "to have models that suit this experiment", f"'{model}', which {why}"
            raise UnfitError(expected, "take it out", "models.family", found)


class WeightFiles(Section):
    """Files of a recording."""

    marker_labels: MarkerLabels = setting(
        "markers in the C3D file, in the order of sequential sampling; all on the weight", thesis="Figure 2-7"
    )


class WeightAnalysis(Section):
    """Masses and loads."""

    other_cutoffs_hz: different(Frequency, least=0) = setting(
        "cutoffs in addition to `plate_treadmill.lowpass_cutoff_hz`, which is used for masses, stored "
        "models and most figures; the analysis is repeated at each. The last is used for Figure 5-1. The "
        "list may be empty",
        thesis="Figure 5-1",
    )
    segment_s: Time = setting(
        "evaluated time from the onset of every perturbation; not longer than the time between two",
        thesis="3-1-2",
    )
    window: Window


class Weight(Section):
    """A known weight on the belt."""

    files: WeightFiles
    ingest: TreadmillIngest
    weight: made_from(KnownWeight)
    further_weights: list[made_from(KnownWeight, without=("gravity_m_per_s2",))] = setting(
        "further weights, whose trials name `mass_kg` in the sheet. They calibrate models of the "
        "treadmill only; one should be near the mass of the subjects"
    )
    analysis: WeightAnalysis
    models: PlateModels
    example_condition: str = setting(
        "condition with the role `validate`, shown with the predictions of the models; the last of the "
        "sheet if the study does not contain it"
    )
    figure_5_1_conditions: some(str) = setting(
        "conditions of Figure 5-1; all if the study contains none of them", thesis="Figure 5-1"
    )

    @model_validator(mode="after")
    def _models_that_suit(self) -> Any:
        _refuse_unsuited(self.models.family, ("ripple-tracking",), "needs a belt that travels")
        return self


class Empty(Section):
    """The empty belt."""

    ingest: TriggerIngest


class BeltFiles(Section):
    """Tables of a recording, whose columns are named in the trial sheet."""

    delimiter: Delimiter = setting("delimiter of the tables")
    load_unit: Literal["Nm", "N"] = setting("unit of the load component")


class BeltIngest(Section):
    """What of a table is used."""

    max_gap_s: Time = setting("longest step between samples")
    shortest_s: Time = setting("shortest recording that is used")


class BeltAnalysis(Section):
    """Filter of velocity and load."""

    cutoffs_hz: different(Frequency) = setting(
        "Butterworth low-pass of velocity, acceleration and load; all models are fitted and evaluated at "
        "each cutoff, so a shorter list saves time"
    )
    shown_cutoff_hz: Frequency = setting(
        "cutoff at which models are stored and shown; it need not be in the list"
    )
    lowpass_order: int = setting(
        "order of the filter; of both passes together, and even, if `zero_lag`", least=1, most=8
    )
    zero_lag: bool = setting("false: forward only, as in real time; true: zero-lag (forward-backward)")
    trimmed_s: Pause = setting("neither fitted nor evaluated, at both ends")

    @model_validator(mode="after")
    def _even_order(self) -> Any:
        if self.zero_lag and self.lowpass_order % 2:
            raise InputError(
                "expected an even belt.analysis.lowpass_order, because the filter is zero-lag, found "
                f"{self.lowpass_order}: correct one of the two"
            )
        return self


class BeltModels(made_from(ModelOptions, needed=("ripple",)), FittedModels):
    """Models of the load of a recorded treadmill."""


class Belt(Section):
    """Recordings of an instrumented treadmill with an accelerated belt."""

    files: BeltFiles
    ingest: BeltIngest
    analysis: BeltAnalysis
    models: BeltModels
    chosen: str = setting("one of `models.family`, shown in the figures")

    @model_validator(mode="after")
    def _models_that_suit(self) -> Any:
        refuse_unknown("chosen", self.chosen, "belt.models.family", self.models.family)
        unsuited = ("mean-subtraction", "loaded-frame", *FRAMES)
        _refuse_unsuited(self.models.family, unsuited, "needs an empty belt beside a weight")
        return self
