"""The family of treadmill models: fit, evaluate, save and apply them."""

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.arguments import path_of
from tepsipe.errors import InputError, listed, quoted
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.black_box_models import (
    BeltModel,
    DiscreteTransfer,
    ImpulseResponse,
    RippleTracker,
    fit_discrete_output_error,
    fit_finite_response,
    fit_hnat2014,
    fit_ripple_tracker,
    fit_spectral,
)
from tepsipe.treadmill.bristle_fit import Calibrated, fit_bristle_frame
from tepsipe.treadmill.bristle_frame import BristleFrame
from tepsipe.treadmill.linear_frame import LinearFrame, fit_linear_frame
from tepsipe.treadmill.mass_models import (
    LoadedFrame,
    MassResponse,
    MassSpringDamper,
    MeanSubtraction,
    fit_loaded_frame,
    fit_mass_spring_damper,
    fit_mean_subtraction,
)
from tepsipe.treadmill.options import BEST, FRAMES, ModelOptions
from tepsipe.treadmill.recording import BeltRecording, Score, check_recordings, score

MODEL_MEANINGS = {
    "mean-subtraction": "mean over the perturbations of the empty belt, subtracted condition by condition",
    "mass-spring-damper": "mass, damper and spring on the belt's motion",
    "hnat2014": "discrete second-order model, as published",
    "output-error": "discrete model of a given order, fitted by output error",
    "fir-causal": "finite impulse response, past acceleration only",
    "fir": "finite impulse response with a short look-ahead",
    "spectral": "spectral estimate H1, non-causal",
    "loaded-frame": "frame, friction and mounts, which depend on the load",
    "bristle-frame": "loaded frame with bristle friction, its lever and a second mode, if cross-validation "
    "asks for them",
    "linear-frame": "frame whose load is linear in the measured one, in force and moment together, with the "
    "delay between their logs and the belt's",
    "ripple-tracking": "impulse response with tracking of the roller ripple",
}
FORMAT = "tepsipe treadmill models 1"
JOINT = dict(zip(FRAMES, (fit_bristle_frame, fit_linear_frame), strict=True))
FAMILY = tuple(MODEL_MEANINGS)
# correlation of load and prediction from which they are alike
ALIKE = 0.5
# quantities of a calibration whose range is kept, with their units; the load has its own
RANGED = {"velocity": "m/s", "acceleration": "m/s²", "load": ""}
MOTION = ("velocity", "acceleration")
# share of a recording outside this range of which is warned
LEAVING = 0.05
KINDS = (
    MeanSubtraction,
    MassSpringDamper,
    DiscreteTransfer,
    ImpulseResponse,
    LoadedFrame,
    BristleFrame,
    LinearFrame,
    RippleTracker,
    MassResponse,
)


@dataclass(frozen=True)
class FamilyOptions(ModelOptions):
    """Choices of the fits, and what other fits have found."""

    frame: Annotated[np.ndarray, "(3,)"] | None = None
    """The loaded frame's d (s), e_0 (s2), e_1 (s2/kg), if identified from another load."""
    joint: dict[str, Calibrated] = field(default_factory=dict)
    """Name -> model of `JOINT`, which is fitted to force and moment together."""


@dataclass(frozen=True, repr=False)
class FittedModel:
    """A treadmill model with everything needed to apply it."""

    name: str
    """Name in the family."""
    model: object
    """Its constants."""
    unit: str
    """Unit of the load that it predicts, N or Nm."""
    lowpass: Lowpass | None
    """Filter of the calibration signals; signals to be predicted need the same filter."""
    trained_on: tuple[str, ...]
    """Names of the calibration recordings."""
    deviations: Annotated[np.ndarray, "(draws, constants)"] | None = None
    """Draws of the errors of the model's ``constants``, for
    `tepsipe.treadmill.compensation.compensated_draws`; None where the calibration has none."""
    usual: tuple[float, ...] | None = None
    """Of a calibration with one mass on the belt: this mass (kg), correlation of load and prediction, and
    ratio of their sizes. None for several masses."""
    calibrated: dict[str, Sequence[float]] | None = None
    """Range of ``velocity`` (m/s), ``acceleration`` (m/s²) and ``load`` (unit of the load) in the
    calibration; None where it was not kept."""

    left_out: float | None = None
    """Error of trials that are left out of the fit of a model of `JOINT`, relative to the noise."""
    load: str = ""
    """Name of the load in recordings with several, such as ``plate 1 Fy``; empty where there is only one."""
    recommended: bool = False
    """True for the model that the calibration recommends for its load."""
    held_out: float | None = None
    """R² on the test recordings; None without them."""
    errors: tuple[tuple[float, float], tuple[float, float]] | None = None
    """Constant and relative part of the error of a load from which the model's prediction is subtracted
    (`tepsipe.treadmill.removal.half_width`), as recorded and behind the low-pass; None without tests."""

    def __repr__(self) -> str:
        return f"<FittedModel {self.name} ({self.unit}), calibrated by {listed(self.trained_on)}>"

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """Belt-induced load (unit of the load), shape (n,)."""
        self._check(recording)
        return self.model.predict(recording)

    def compensate(
        self, recording: BeltRecording, force: np.ndarray | None = None, friction: np.ndarray | None = None
    ) -> np.ndarray:
        """Measured load less the predicted belt-induced load (unit of the load), shape (n,).

        A recording that leaves the calibrated range of velocity or acceleration is warned of. A
        "bristle-frame" of the moment needs the true fore-aft force ``force`` (N), shape (n,), and takes
        the friction of the belt (N), shape (n,), where already known.
        """
        self._check(recording)
        if self.calibrated is not None and (text := leaving(recording, self.calibrated, MOTION)):
            warnings.warn(text, stacklevel=2)
        return self.model.compensate(recording, force, friction)

    def _check(self, recording: BeltRecording) -> None:
        rate = self.model.rate_hz
        if abs(recording.rate_hz - rate) > 1e-6 * rate:
            raise InputError(
                f"{recording.name}: expected {rate:g} Hz, the rate at which the model {self.name!r} was "
                f"calibrated, found {recording.rate_hz:g} Hz: resample the recording"
            )
        if recording.unit != self.unit:
            raise InputError(
                f"{recording.name}: expected a load in {self.unit}, as the model {self.name!r} was "
                f"calibrated with, found {recording.unit}: use the model of this load"
            )
        if recording.lowpass != self.lowpass:
            raise InputError(
                f"{recording.name}: expected signals filtered as in the calibration of {self.name!r} "
                f"({self.lowpass}), found {recording.lowpass}: use the same filter"
            )


def leaving(
    recording: BeltRecording, ranges: dict[str, Sequence[float]], quantities: Sequence[str] = RANGED
) -> str:
    """Sentence on how much of a recording lies outside the range of a calibration; empty if little does.

    recording: filtered as in the calibration (m/s, m/s², unit of the load).
    ranges: from `calibrated_range`, in the same units.
    quantities: those of the range that are compared.
    Returns: the sentence, with the share in %.
    """
    found = []
    for name in quantities:
        values, (low, high) = getattr(recording, name)[recording.evaluated], ranges[name]
        share = float(np.mean((values < low) | (values > high)))
        if share > LEAVING:
            unit = RANGED[name] or recording.unit
            found.append(f"{100.0 * share:.1f} % of its {name} outside {low:.3g} to {high:.3g} {unit}")
    if not found:
        return ""
    return (
        f"{recording.name}: expected the range of the calibration, found {', '.join(found)}: the model "
        "extrapolates there, so calibrate with such a motion"
    )


def calibrated_range(recordings: Sequence[BeltRecording]) -> dict[str, Sequence[float]]:
    """Range of velocity (m/s), acceleration (m/s²) and load (unit of the load), from lowest to highest."""
    ranges: dict[str, Sequence[float]] = {}
    for name in RANGED:
        values = np.concatenate([getattr(r, name)[r.evaluated] for r in recordings])
        ranges[name] = [float(values.min()), float(values.max())]
    return ranges


def fit_model(name: str, recordings: list[BeltRecording], options: FamilyOptions) -> FittedModel:
    """Fit one model of the family.

    Returns: model with its unit, filter and calibration recordings.
    """
    check_recordings(recordings, options.shortest_s)
    joint = options.joint.get(name)
    fits = {
        "mean-subtraction": lambda: fit_mean_subtraction(recordings),
        "mass-spring-damper": lambda: fit_mass_spring_damper(recordings),
        "hnat2014": lambda: fit_hnat2014(recordings, options.hnat2014_evaluations),
        "output-error": lambda: fit_discrete_output_error(recordings, options.output_error_order),
        "fir-causal": lambda: fit_finite_response(recordings, 0.0, options.fir_lag_s),
        "fir": lambda: fit_finite_response(recordings, options.fir_lead_s, options.fir_lag_s),
        "spectral": lambda: fit_spectral(recordings, options.spectral_segment_s),
        "loaded-frame": lambda: fit_loaded_frame(recordings, options.frame),
        **{name: lambda: joint.models["Fy" if recordings[0].unit == "N" else "Mx"] for name in JOINT},
        "ripple-tracking": lambda: fit_ripple_tracker(
            recordings, fit_finite_response(recordings, options.fir_lead_s, options.fir_lag_s), options.ripple
        ),
    }
    if name not in fits:
        raise InputError(f"expected a treadmill model of {', '.join(FAMILY)}, found {name!r}: correct it")
    for needing, settings, what in (
        (("ripple-tracking",), options.ripple, "options of the ripple"),
        (JOINT, joint, "the joint fit of force and moment"),
    ):
        if name in needing and settings is None:
            raise InputError(f"expected {what} for the model {name!r}, found none: give them")
    first, model = recordings[0], fits[name]()
    return FittedModel(
        name,
        model,
        first.unit,
        first.lowpass,
        tuple(r.name for r in recordings),
        None if joint is None else joint.deviations,
        _usual(model, recordings),
        left_out=None if joint is None else joint.error,
    )


def evaluate(fitted: FittedModel, recordings: list[BeltRecording]) -> Score:
    """Score of the model's prediction of held-out recordings (unit of the load)."""
    predictions = [fitted.predict(r) for r in recordings]
    for r in recordings:
        refuse_other_scale(r, fitted)
    return score(recordings, predictions)


def _usual(model: BeltModel, recordings: list[BeltRecording]) -> tuple[float, ...] | None:
    """Mass (kg), correlation of load and prediction, ratio of their sizes; None for several masses."""
    masses = {r.carried_kg for r in recordings}
    return (*masses, *_likeness(model, recordings)) if len(masses) == 1 else None


def _likeness(model: BeltModel, recordings: list[BeltRecording]) -> tuple[float, float]:
    """Correlation of measured and predicted load, and ratio of their sizes; 0 if one of them is 0."""
    base = getattr(model, "base", model)  # tracked ripple follows any load
    load, predicted = (
        np.concatenate([x[r.evaluated] - x[r.evaluated].mean() for r, x in found])
        for found in ([(r, r.load) for r in recordings], [(r, base.predict(r)) for r in recordings])
    )
    power = float(np.sqrt((load @ load) * (predicted @ predicted)))
    if power == 0.0:
        return 0.0, 0.0
    return float(load @ predicted) / power, float(np.linalg.norm(load) / np.linalg.norm(predicted))


def refuse_other_scale(recording: BeltRecording, fitted: FittedModel) -> None:
    """Compare the load of a recording with the calibration's load, with the same mass on the belt.

    A model predicts little of a load that is mostly noise, or that its own calibration hardly showed: loads
    are therefore compared through the prediction, whose size relative to the load must be like that in the
    calibration.
    """
    carried_kg, before, size = fitted.usual or (None, 0.0, 0.0)
    if before < ALIKE or recording.carried_kg != carried_kg:
        return
    correlation, ratio = _likeness(fitted.model, [recording])
    if abs(correlation) < ALIKE:
        return
    trained = ", ".join(fitted.trained_on[:3])
    if correlation < 0.0:
        raise InputError(
            f"{recording.name}: expected the load to follow the belt as in {trained}, found it with the "
            f"opposite sign (correlation {correlation:.2f}): turn the sign of one of the load columns"
        )
    if not 0.05 < ratio / size < 20.0:
        raise InputError(
            f"{recording.name}: expected a load of the size that {trained} predict, found one "
            f"{ratio / size:.3g} times as large: its column is probably not in {recording.unit}"
        )


# ---- files of models -----------------------------------------------------------------------------


def save_models(path: str | Path, models: list[FittedModel]) -> None:
    """Write models as JSON; numbers keep every digit (units as in the models' classes)."""
    content = {"format": FORMAT, "models": [_plain(m) for m in models]}
    Path(path).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def load_treadmill_models(path: str | Path, load: str | None = None) -> dict[str, FittedModel]:
    """Name -> model, from a file written by `save_models` (units as in the models' classes).

    Parameters
    ----------
    path : str or Path
        The file.
    load : str
        Name of the load, if the file has models of several.

    Raises
    ------
    InputError
        If the file is missing or is not such a file, or has no models of the load.

    Examples
    --------
    >>> from tepsipe import load_treadmill_models
    >>> models = load_treadmill_models("treadmill_models.json")  # doctest: +SKIP
    >>> rest = models["fir"].compensate(recording)  # doctest: +SKIP
    """
    path = path_of(path)
    models = read_models(path)
    loads = list(dict.fromkeys(model.load for model in models))
    if load not in loads and (load is not None or len(loads) > 1):
        found = "none" if load is None else quoted(load)
        raise InputError(
            f"{path}: expected load to be one of {listed(loads)}, found {found}: name one of them"
        )
    return {m.name: m for m in models if load is None or m.load == load}


def read_models(path: Path) -> list[FittedModel]:
    """All models in a file written by `save_models` (units as in the models' classes)."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        if content["format"] != FORMAT:
            raise ValueError(f"its format is {content['format']!r}")
        models = [_revived(entry) for entry in content["models"]]
        if not all(isinstance(model, FittedModel) for model in models):
            raise ValueError("it holds something else than models")
        for model in models:
            if not isinstance(model.name, str) or model.unit not in ("N", "Nm"):
                raise ValueError("it holds a model without a name or unit")
            if not isinstance(model.trained_on, tuple) or not isinstance(model.lowpass, Lowpass | None):
                raise ValueError(f"it holds a damaged model {model.name!r}")
        if not all(0.0 < model.model.rate_hz < np.inf for model in models):
            raise ValueError("it holds a sampling rate that is not positive")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(
            f"{path}: expected a file of treadmill models, found one that cannot be read ({quoted(error)}): "
            "fit the models again"
        ) from error
    return models


def _plain(x):
    """Dataclasses, arrays and tuples as JSON values, with the names of classes."""
    if type(x) in (*KINDS, FittedModel, Lowpass):
        return {"kind": type(x).__name__} | {f.name: _plain(getattr(x, f.name)) for f in fields(x)}
    if isinstance(x, np.ndarray):
        return {"kind": "array", "values": x.tolist()}
    if isinstance(x, tuple):
        return list(x)
    if isinstance(x, dict):
        return {"kind": "dict", "values": {key: _plain(value) for key, value in x.items()}}
    return x


def _revived(x):
    if isinstance(x, list):
        return tuple(x)
    if isinstance(x, float) and not np.isfinite(x):
        raise ValueError(f"it holds the number {x}")
    if not isinstance(x, dict):
        return x
    kind = x["kind"]
    if kind == "array":
        values = np.array(x["values"], dtype=float)
        if not np.isfinite(values).all():
            raise ValueError("it holds numbers that are not finite")
        return values
    if kind == "dict":
        return {key: _revived(value) for key, value in x["values"].items()}
    known = {c.__name__: c for c in (*KINDS, FittedModel, Lowpass)}
    return known[kind](**{key: _revived(value) for key, value in x.items() if key != "kind"})


def pick(models: dict[str, FittedModel], name: str) -> FittedModel:
    """One model by its name, or of those of `JOINT` the one with the least error as `BEST`."""
    if name == BEST and (frames := [model for model in models.values() if model.left_out is not None]):
        return min(frames, key=lambda model: model.left_out)
    if name not in models:
        raise InputError(f"expected a treadmill model named {name!r}, found {listed(models)}: fit it first")
    return models[name]
