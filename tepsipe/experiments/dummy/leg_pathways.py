"""TEP-SIPE on the ankle dummy, from one trial to its parameters by every pathway (thesis section 3-1-2)."""

import zlib
from dataclasses import dataclass, field

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.dummy.joint_rows import joint_estimates, joint_facts
from tepsipe.identification.estimators import LEAST_SQUARES_THESIS, Record, estimate, find_estimator
from tepsipe.identification.joint_channels import DummyMarkers, dummy_markers
from tepsipe.identification.joint_result import JointLikelihood
from tepsipe.identification.output_error import OutputError
from tepsipe.identification.window_regression import WindowedFits, damping_per_skew
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS, impedance_torque
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.joint_torque import leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, segment_motion
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import WindowOptions, perturbations_of, rest_samples
from tepsipe.statistics.bootstrap import Interval, bootstrap_mean
from tepsipe.statistics.goodness_of_fit import vaf

# attribute of a trial whose belt velocity was derived from markers
MARKED_BELT = "belt_velocity_from"
LOAD_UNITS = {"Fy": "N", "Mx": "Nm"}
MARKER_SIGNALS = {"aligned": "marker_position", "as-sampled": "marker_position_as_sampled"}


@dataclass(frozen=True)
class Pathway:
    """One way from markers to parameters (names, no units).

    Attributes
    ----------
    torque : {"leg", "leg-thesis"}
        Equation of the torque (`tepsipe.mechanics.inverse_dynamics`).
    marker_instants : {"aligned", "as-sampled"}
        Whether sequential marker sampling is corrected.
    estimator : str
        Estimator of the parameters (`tepsipe.identification.estimators`); output error and the joint
        likelihood do not use the torque.
    """

    torque: str
    marker_instants: str
    estimator: str


@dataclass(frozen=True)
class DummyOptions:
    """Options of the thesis (section 3-1-2) and properties of the dummy (Table 2-2).

    Attributes
    ----------
    leg : Leg
        The leg (kg, m, kg·m²).
    leg_markers : SegmentMarkers
        Its markers and their offsets (m).
    lowpass_cutoff_hz, lowpass_order : float, int
        Zero-lag Butterworth filter (Hz, -).
    window : WindowOptions
        Search for perturbations and rest (s).
    belt_fixed_labels : tuple of str
        Belt-fixed markers, whose mean is the motion of the foot, for output error and joint likelihood only.
    """

    leg: Leg
    leg_markers: SegmentMarkers
    lowpass_cutoff_hz: float
    lowpass_order: int
    window: WindowOptions
    belt_fixed_labels: tuple[str, ...] = ()


@dataclass(frozen=True)
class DummyAnalysis:
    """Results of one trial.

    Attributes
    ----------
    time, belt_velocity : ndarray, shape (n,)
        Instants (s), and filtered measured velocity (m/s).
    belt_command : ndarray, shape (n,), or None
        Commanded velocity (m/s), for figures only; None where it was not recorded.
    regressions : dict of str to WindowedFits
        Pathway -> parameters and predictions.
    pathways : dict of str to Pathway
        Definition of each pathway.
    damping_per_skew : dict of str to float
        Pathway -> change of B per delay of the leg's position relative to its angle (N·m·s/rad per s).
    marker_residual_rms_m : float
        Marker residual RMS: root mean square distance between markers and the rigid leg (m).
    marker_noise_m : float
        Root mean square of the component that the filter removes from the leg's markers at rest (m per
        coordinate).
    loads : dict of str to ndarray, shape (n,)
        ``Fy/measured`` (N), ``Mx/measured`` (N·m) and the same compensated by each treadmill model that a
        pathway uses, for example ``Fy/loaded-frame``; empty without pathways from the foot.
    """

    time: np.ndarray
    belt_velocity: np.ndarray
    belt_command: np.ndarray | None
    regressions: dict[str, WindowedFits]
    pathways: dict[str, Pathway]
    damping_per_skew: dict[str, float]
    marker_residual_rms_m: float
    marker_noise_m: float
    loads: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def output_errors(self) -> dict[str, OutputError | JointLikelihood]:
        """Pathway -> measured and simulated angle (rad), where the estimator simulates the angle."""
        simulated = (OutputError, JointLikelihood)
        return {name: found for name, found in self.regressions.items() if isinstance(found, simulated)}

    @property
    def joint_likelihoods(self) -> dict[str, JointLikelihood]:
        """Pathway -> fit, where the joint likelihood was the estimator (units in it)."""
        return {name: found for name, found in self.regressions.items() if isinstance(found, JointLikelihood)}


def analyse_dummy(trial: Trial, options: DummyOptions, pathways: dict[str, Pathway]) -> DummyAnalysis:
    """Estimate I, B, K of the ankle dummy by every pathway.

    Parameters
    ----------
    trial : Trial
        Markers (m) and belt velocity (m/s).
    options : DummyOptions
        Choices (units in their names).
    pathways : dict of str to Pathway
        Name -> pathway.

    Returns
    -------
    DummyAnalysis
        One regression per pathway, all over the same perturbations.

    Raises
    ------
    InputError
        If no perturbation or no rest is found, or the markers are not the leg's.
    """
    rate, time = trial.rate_hz, trial.time

    def lowpass(x: np.ndarray) -> np.ndarray:
        return butterworth_lowpass(x, rate, options.lowpass_cutoff_hz, options.lowpass_order)

    belt_velocity = lowpass(trial.values("belt_velocity"))
    perturbations = perturbations_of(belt_velocity, rate, options.window, "belt velocity")
    at_rest = rest_samples(time, options.window)
    motions = {
        instants: segment_motion(
            time,
            trial.values(MARKER_SIGNALS[instants]),
            options.leg_markers,
            options.leg.com_m,
            labels=trial.axes["marker"].tolist(),
            cutoff_hz=options.lowpass_cutoff_hz,
            order=options.lowpass_order,
        )
        for instants in sorted({pathway.marker_instants for pathway in pathways.values()})
    }
    regressions, skews = {}, {}
    for name, pathway in pathways.items():
        motion, estimator = motions[pathway.marker_instants], find_estimator(pathway.estimator)
        given = {"motion": motion, "perturbations": perturbations, "at_rest": at_rest, "leg": options.leg}
        if "torque" in estimator.needs:
            given["torque"] = leg_pathway_torque(pathway.torque, options.leg, motion)
            thesis = pathway.estimator == LEAST_SQUARES_THESIS
            skews[name] = damping_per_skew(
                motion, options.leg, perturbations, at_rest, pathway.torque, thesis=thesis
            )
        if "foot_position" in estimator.needs:
            foot = belt_fixed_position(trial, options.belt_fixed_labels, pathway.marker_instants)
            given |= {"foot_position": lowpass(foot), "belt_velocity": belt_velocity}
        if "markers" in estimator.needs:
            given["markers"] = markers_of(trial, options, pathway.marker_instants)
            given["belt_log"] = None if MARKED_BELT in trial.attributes else trial.values("belt_velocity")
        regressions[name] = estimate(pathway.estimator, Record(**given))
    return DummyAnalysis(
        time=time,
        belt_velocity=belt_velocity,
        belt_command=trial.optional("belt_command"),
        regressions=regressions,
        pathways=pathways,
        damping_per_skew=skews,
        marker_residual_rms_m=max(motion.marker_residual_rms_m for motion in motions.values()),
        marker_noise_m=_noise_at_rest(trial, options, lowpass, at_rest),
    )


def markers_of(trial: Trial, options: DummyOptions, instants: str) -> DummyMarkers:
    """Markers of foot and leg, not filtered.

    Parameters
    ----------
    trial : Trial
        Markers (m).
    options : DummyOptions
        Which of them are on the leg (m), and on the belt.
    instants : {"aligned", "as-sampled"}
        Whether sequential marker sampling is corrected.

    Returns
    -------
    DummyMarkers
        Positions (m) and samples that were filled.

    Raises
    ------
    InputError
        If a marker is missing.
    """
    hidden = trial.optional("marker_hidden")
    if hidden is not None and instants == "aligned":
        # a sample at a common instant lies between two that were recorded
        around = np.asarray(hidden, dtype=bool)
        hidden = around.copy()
        hidden[1:] |= around[:-1]
        hidden[:-1] |= around[1:]
    return dummy_markers(
        trial.values(MARKER_SIGNALS[instants]),
        trial.axes["marker"].tolist(),
        options.leg_markers,
        options.belt_fixed_labels,
        hidden,
    )


def belt_fixed_position(trial: Trial, labels: tuple[str, ...], instants: str) -> np.ndarray:
    """Mean position of the belt-fixed markers along the belt (m), shape (n,).

    Parameters
    ----------
    trial : Trial
        Markers (m).
    labels : tuple of str
        The belt-fixed markers.
    instants : {"aligned", "as-sampled"}
        Whether sequential marker sampling is corrected.

    Returns
    -------
    ndarray, shape (n,)
        Position, unfiltered (m).

    Raises
    ------
    InputError
        If a marker is missing, or none is named.
    """
    known = trial.axes["marker"].tolist()
    missing = [label for label in labels if label not in known]
    if missing or not labels:
        raise InputError(
            f"expected belt-fixed markers among {listed(known)}, found {listed(missing or ['none'])}: "
            "name them in dummy.foot.belt_fixed_labels in the configuration"
        )
    columns = [known.index(label) for label in labels]
    return trial.values(MARKER_SIGNALS[instants])[:, columns, 1].astype(float).mean(axis=1)


def _noise_at_rest(trial: Trial, options: DummyOptions, lowpass, at_rest: np.ndarray) -> float:
    labels = trial.axes["marker"].tolist()
    columns = [labels.index(label) for label in options.leg_markers.labels]
    positions = trial.values(MARKER_SIGNALS["as-sampled"])[:, columns, 1:]
    return float(np.sqrt(np.mean((positions - lowpass(positions))[at_rest] ** 2)))


def bootstrap_pathways(analysis: DummyAnalysis, draws: int, seed: int) -> dict[str, Interval]:
    """Intervals of the means of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) and VAF (%) of every pathway.

    Parameters
    ----------
    analysis : DummyAnalysis
        Output of `analyse_dummy`.
    draws : int
        Bootstrap samples (-).
    seed : int
        Seed of the generators that draw perturbations, one per pathway (-): intervals do not depend on the
        other pathways.

    Returns
    -------
    dict of str to Interval
        Pathway -> standard errors and intervals, each of shape (4,).
    """
    return {
        name: _with_wald(
            regression,
            bootstrap_mean(
                np.column_stack([regression.parameters, regression.vaf_per_perturbation]),
                draws,
                np.random.default_rng([seed, zlib.crc32(name.encode())]),
            ),
        )
        for name, regression in analysis.regressions.items()
    }


def _with_wald(regression: WindowedFits, interval: Interval) -> Interval:
    """The interval with that of the likelihood for I, B, K, if the regression has one (units of both)."""
    if not isinstance(regression, JointLikelihood):
        return interval
    own = regression.interval()
    return Interval(
        *(
            np.concatenate([getattr(own, name), getattr(interval, name)[3:]])
            for name in ("standard_error", "low", "high")
        )
    )


def dummy_estimates(
    condition: str, analysis: DummyAnalysis, intervals: dict[str, Interval]
) -> list[Estimate]:
    """Tidy rows of one trial: I, B, K, and VAF (%) per perturbation and over the trial.

    For output error and joint likelihood also the VAF (%) of the angle, VAF_theta_trial, and for the joint
    likelihood I, B, K of small movements.

    Parameters
    ----------
    condition : str
        Name of the condition.
    analysis : DummyAnalysis
        Output of `analyse_dummy`.
    intervals : dict of str to Interval
        From `bootstrap_pathways`.

    Returns
    -------
    list of Estimate
        Values are means over perturbations; intervals are bootstrapped over them. The output error has
        no SEM as printed.
    """
    rows = []
    for name, regression in analysis.regressions.items():
        names = ("dummy", condition, name, analysis.pathways[name].estimator)
        interval = intervals[name]
        mean = [*regression.mean, regression.vaf_per_perturbation.mean()]
        printed = np.mean([fit.sem_as_printed for fit in regression.fits], axis=0)
        count = len(regression.fits)
        quantities = [*[(q, UNITS[q]) for q in PARAMETERS], ("VAF_perturbation", "%")]
        for k, (quantity, unit) in enumerate(quantities):
            rows.append(
                Estimate(
                    *names,
                    quantity,
                    unit,
                    float(mean[k]),
                    float(interval.standard_error[k]),
                    float(interval.low[k]),
                    float(interval.high[k]),
                    float(printed[k]) if quantity in PARAMETERS and np.isfinite(printed[k]) else None,
                    count,
                )
            )
        rows.append(Estimate(*names, "VAF_trial", "%", regression.vaf_trial, n_perturbations=count))
        if name in analysis.joint_likelihoods:
            rows += joint_estimates(names, analysis.joint_likelihoods[name], count)
        if name in analysis.output_errors:
            of_angle = analysis.output_errors[name].vaf_angle
            rows.append(Estimate(*names, "VAF_theta_trial", "%", of_angle, n_perturbations=count))
    return rows


def dummy_result(analysis: DummyAnalysis, intervals: dict[str, Interval]) -> Result:
    """Arrays and facts of one trial, for figures and for cross-validation (units in the result).

    ``intervals`` are those of `bootstrap_pathways`.
    """
    arrays: dict[str, np.ndarray] = {
        "time": analysis.time,
        "belt_velocity": analysis.belt_velocity,
    }
    units = {"time": "s", "belt_velocity": "m/s"}
    if analysis.belt_command is not None:
        arrays["belt_command"], units["belt_command"] = analysis.belt_command, "m/s"
    some = next(iter(analysis.regressions.values()))
    arrays["windows"] = np.array([[p.start, p.stop] for p in some.perturbations])
    units["windows"] = "samples"
    for name, regression in analysis.regressions.items():
        for key, values, unit in (
            ("torque", regression.torque, "Nm"),
            ("predicted_torque", regression.predicted, "Nm"),
            ("regressors", regression.regressors, "rad/s2, rad/s, rad"),
            ("parameters", regression.parameters, "Nms2/rad, Nms/rad, Nm/rad"),
            ("mean_and_interval", _mean_and_interval(regression, intervals[name]), "as parameters"),
            ("vaf_per_perturbation", regression.vaf_per_perturbation, "%"),
            ("standard_errors", _standard_errors(regression), "Nms2/rad, Nms/rad, Nm/rad"),
        ):
            arrays[f"{name}/{key}"], units[f"{name}/{key}"] = values, unit
    for name, found in analysis.output_errors.items():
        for key, values in (("angle", found.angle), ("simulated_angle", found.simulated)):
            arrays[f"{name}/{key}"], units[f"{name}/{key}"] = values, "rad"
    for name, values in analysis.loads.items():
        arrays[f"loads/{name}"] = values.astype(np.float32)
        units[f"loads/{name}"] = LOAD_UNITS[name.partition("/")[0]]
    lengths = np.diff(arrays["windows"], axis=1) * (analysis.time[1] - analysis.time[0])
    facts = {
        "pathways": list(analysis.regressions),
        "marker_residual_rms_m": analysis.marker_residual_rms_m,
        "marker_noise_m": analysis.marker_noise_m,
        "theta_rest_rad": some.theta_rest_rad,
        "mean_window_s": float(lengths.mean()),
        "damping_per_skew_Nms_per_rad_per_s": analysis.damping_per_skew,
        "output_error_delay_s": {name: found.delay_s for name, found in analysis.output_errors.items()},
        "joint_likelihood": {name: joint_facts(f) for name, f in analysis.joint_likelihoods.items()},
        "estimators": {name: pathway.estimator for name, pathway in analysis.pathways.items()},
        "condition_numbers": {
            name: float(np.mean([fit.condition_number for fit in regression.fits]))
            for name, regression in analysis.regressions.items()
        },
    }
    return Result(arrays, units, facts)


def _standard_errors(regression: WindowedFits) -> np.ndarray:
    """Ordinary standard errors of I, B, K of every perturbation, for white residuals (units of I, B, K)."""
    return np.array([fit.standard_error for fit in regression.fits])


def _mean_and_interval(regression: WindowedFits, interval: Interval) -> np.ndarray:
    """Rows mean, low, high; columns I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad)."""
    return np.array([regression.mean, interval.low[:3], interval.high[:3]])


def cross_validate_dummy(results: dict[str, Result], pathway: str) -> np.ndarray:
    """Predict every trial's torque with every trial's mean parameters (thesis section 3-1-2).

    Parameters
    ----------
    results : dict of str to Result
        Condition -> `dummy_result`.
    pathway : str
        Name of the pathway.

    Returns
    -------
    ndarray, shape (conditions, conditions)
        VAF (%) over the whole trial, parameters of the row's condition, trial of the column's.

    Raises
    ------
    InputError
        If a trial lacks the pathway.
    """
    for condition, result in results.items():
        if f"{pathway}/parameters" not in result.arrays:
            raise InputError(f"{condition}: expected the pathway {pathway!r}, found none: fit it again")
    matrix = np.empty((len(results), len(results)))
    for i, reference in enumerate(results.values()):
        mean = reference.arrays[f"{pathway}/parameters"].mean(axis=0)
        for j, trial in enumerate(results.values()):
            theta_dd, theta_d, theta = trial.arrays[f"{pathway}/regressors"].T
            predicted = impedance_torque(mean, theta, theta_d, theta_dd)
            matrix[i, j] = vaf(trial.arrays[f"{pathway}/torque"], predicted)
    return matrix


def cross_validation_estimates(
    conditions: list[str], matrix: np.ndarray, pathway: str, estimator: str
) -> list[Estimate]:
    """Mean VAF (%) of each condition's parameters on the other conditions."""
    if len(conditions) < 2:
        return []
    others = ~np.eye(len(conditions), dtype=bool)
    return [
        Estimate(
            "dummy",
            condition,
            pathway,
            estimator,
            "VAF_cross_validated",
            "%",
            float(matrix[k][others[k]].mean()),
        )
        for k, condition in enumerate(conditions)
    ]
