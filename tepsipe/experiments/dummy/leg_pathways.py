"""TEP-SIPE on the ankle dummy, from one trial to its estimates by every pathway (thesis section 3-1-2)."""

from dataclasses import dataclass, field, replace
from typing import Annotated, Self

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.dummy.foot_treadmill import TreadmillCheck
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.identification.budgets.leg import LegUncertainty
from tepsipe.identification.estimators import LEAST_SQUARES_THESIS, Record, find_estimator
from tepsipe.identification.leg_fit import fit_record
from tepsipe.identification.likelihood.channels import DummyMarkers, dummy_markers
from tepsipe.identification.likelihood.result import LikelihoodEstimates
from tepsipe.identification.regression.output_error import OutputError
from tepsipe.identification.regression.windows import WindowedFits, damping_per_com_lag
from tepsipe.identification.result import Quantity
from tepsipe.io.trial import Trial, recorded_faults
from tepsipe.mechanics.inverse_dynamics import Foot, Leg, leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import (
    SegmentMarkers,
    SegmentMotion,
    marker_positions,
    motion_of_markers,
)
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.signals.sample_faults import flags_of
from tepsipe.signals.time_alignment import advanced, common_signal_delay
from tepsipe.statistics.uncertainty import Budget, Source, sources_of
from tepsipe.treadmill.prepared import PreparedTrial, prepare_trial

# attribute of a trial whose belt velocity was derived from markers
MARKED_BELT = "belt_velocity_from"
# delay of the belt's log after belt-fixed markers: the longest that needs no correction, the longest that is
# searched (s), and the least correlation of both velocities for a delay to be measured
LOG_DELAY_S, LONGEST_LOG_DELAY_S, LEAST_CORRELATION = 6e-3, 0.2, 0.9
MARKER_SIGNALS = {"aligned": "marker_position", "as-sampled": "marker_position_as_sampled"}


@dataclass(frozen=True)
class DummyOptions:
    """Options of the thesis (section 3-1-2) and properties of the dummy (Table 2-2)."""

    leg: Leg
    """The leg (kg, m, kg·m²)."""
    leg_markers: SegmentMarkers
    """Its markers and their offsets (m)."""
    lowpass_cutoff_hz: float
    lowpass_order: int
    """Zero-lag Butterworth filter."""
    window: WindowOptions
    """Search for perturbations and rest (s)."""
    belt_fixed_labels: tuple[str, ...] = ()
    """Belt-fixed markers, whose mean is the motion of the foot, for output error and joint likelihood."""
    sources: dict[str, Source] = field(default_factory=dict)
    """Uncertain constants; without any, Type B is not evaluated."""
    foot: Foot | None = None
    """The foot (kg, m), for Type B: it tilts on a compliant belt."""

    @classmethod
    def from_settings(
        cls, geometry: dict, analysis: dict, belt_fixed_labels=(), uncertainty: dict | None = None
    ) -> Self:
        """Options of a study.

        geometry: constants of the leg (kg, m, kg·m²) and ``leg_markers``, and for Type B those of the foot.
        analysis: ``lowpass_cutoff_hz``, ``lowpass_order``, the attributes of `WindowOptions`, and others.
        belt_fixed_labels: belt-fixed markers.
        uncertainty: sources, as `sources_of` takes them.
        """
        return cls(
            leg=Leg.from_settings(geometry),
            leg_markers=SegmentMarkers.from_settings(geometry["leg_markers"]),
            lowpass_cutoff_hz=analysis["lowpass_cutoff_hz"],
            lowpass_order=analysis["lowpass_order"],
            window=WindowOptions(**{k: analysis[k] for k in WindowOptions.__dataclass_fields__}),
            belt_fixed_labels=tuple(belt_fixed_labels),
            sources=sources_of(uncertainty or {}),
            foot=Foot.from_settings(geometry) if "foot_mass_kg" in geometry else None,
        )

    @property
    def lowpass(self) -> Lowpass:
        """Zero-lag filter of all signals (Hz)."""
        return Lowpass(self.lowpass_cutoff_hz, self.lowpass_order, True)


@dataclass(frozen=True)
class DummyAnalysis:
    """Results of one trial."""

    time: np.ndarray
    belt_velocity: np.ndarray
    """Instants (s), and filtered measured velocity (m/s)."""
    belt_command: np.ndarray | None
    """Commanded velocity (m/s), for figures only; None where it was not recorded."""
    regressions: dict[str, WindowedFits]
    """Pathway -> parameters and predictions."""
    pathways: dict[str, Pathway]
    """Definition of each pathway."""
    budgets: dict[str, Budget]
    """Pathway -> uncertainty of the means of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    quantities: dict[str, dict[str, Quantity]]
    """Pathway -> these means with their intervals, and the further ones of `fit_record`."""
    damping_per_com_lag: dict[str, float]
    """Pathway -> change of B per lag of the centre of mass behind the angle (N·m·s/rad per s)."""
    marker_residual_rms_m: float
    """Marker residual RMS: root mean square distance between markers and the rigid leg."""
    layout_scale: float
    """Size of the leg's markers over the size of their layout (`SegmentMotion`)."""
    marker_noise_m: float
    """Root mean square of the component that the filter removes from the leg's markers at rest (m per
    coordinate)."""
    loads: dict[str, np.ndarray] = field(default_factory=dict)
    """``Fy/measured`` (N), ``Mx/measured`` (N·m) and the same compensated by each treadmill model that a
    pathway uses, for example ``Fy/loaded-frame``; empty without pathways from the foot."""
    checks: dict[str, TreadmillCheck] = field(default_factory=dict)
    """Pathway -> examination of its treadmill model; empty without such pathways."""
    flags: tuple[str, ...] = ()
    """Failed checks of the whole trial, names in `tepsipe.flags.FLAGS`."""

    @property
    def simulating_fits(self) -> dict[str, OutputError | LikelihoodEstimates]:
        """Pathway -> measured and simulated angle (rad), where the estimator simulates the angle."""
        simulated = (OutputError, LikelihoodEstimates)
        return {name: fit for name, fit in self.regressions.items() if isinstance(fit, simulated)}

    @property
    def likelihood_estimates(self) -> dict[str, LikelihoodEstimates]:
        """Pathway -> fit, where the joint likelihood was the estimator."""
        return {name: fit for name, fit in self.regressions.items() if isinstance(fit, LikelihoodEstimates)}


def analyse_dummy(trial: Trial, options: DummyOptions, pathways: dict[str, Pathway]) -> DummyAnalysis:
    """Estimate I, B, K of the ankle dummy by every pathway.

    pathways: name -> pathway.
    Returns: one regression per pathway, all over the same perturbations.
    """
    prepared, flags = prepare_dummy(trial, options, "belt velocity")
    trial = prepared.trial
    perturbations, at_rest = prepared.perturbations, prepared.at_rest
    motions = {
        instants: leg_motion(prepared, options, instants)
        for instants in sorted({pathway.marker_instants for pathway in pathways.values()})
    }
    regressions, budgets, quantities, skews = {}, {}, {}, {}
    for name, pathway in pathways.items():
        motion, estimator = motions[pathway.marker_instants], find_estimator(pathway.estimator)
        fields = {
            "motion": motion,
            "perturbations": perturbations,
            "at_rest": at_rest,
            "leg": options.leg,
            "belt_velocity": prepared.belt_velocity,
            "belt_log": None if MARKED_BELT in trial.attributes else trial.values("belt_velocity"),
        }
        if "torque" in estimator.needs:
            fields["torque"] = leg_pathway_torque(pathway.torque, options.leg, motion)
            thesis = pathway.estimator == LEAST_SQUARES_THESIS
            skews[name] = damping_per_com_lag(
                motion, options.leg, perturbations, at_rest, pathway.torque, thesis=thesis
            )
        if "foot_position" in estimator.needs:
            foot = belt_fixed_position(trial, options.belt_fixed_labels, pathway.marker_instants)
            fields["foot_position"] = prepared.filtered(foot)
        if "markers" in estimator.needs:
            fields["markers"] = trial_markers(trial, options, pathway.marker_instants)
        known = leg_knowledge(prepared, options, pathway, motion)
        regressions[name], quantities[name], budgets[name] = fit_record(
            pathway.estimator, Record(**fields), known, pathway.torque
        )
    return DummyAnalysis(
        time=prepared.time,
        belt_velocity=prepared.belt_velocity,
        belt_command=trial.optional("belt_command"),
        regressions=regressions,
        pathways=pathways,
        budgets=budgets,
        quantities=quantities,
        damping_per_com_lag=skews,
        marker_residual_rms_m=max(motion.marker_residual_rms_m for motion in motions.values()),
        layout_scale=next(iter(motions.values())).layout_scale,
        marker_noise_m=_noise_at_rest(prepared, options),
        flags=(*flags, *_faults_of_markers(prepared, options)),
    )


def prepare_dummy(trial: Trial, options: DummyOptions, name: str) -> tuple[PreparedTrial, tuple[str, ...]]:
    """Perturbations and rest of a trial by `belt_in_time`, and its flags; ``name`` is for messages."""
    trial, flags = belt_in_time(trial, options)
    return prepare_trial(trial, name, options.lowpass, options.window), flags


def belt_in_time(trial: Trial, options: DummyOptions) -> tuple[Trial, tuple[str, ...]]:
    """Trial whose logged belt moves with the markers on it, and flags.

    A late log shifts the windows of the perturbations, over which a joint that softens has another K.

    Returns:
        trial: the same unless the log is late or early by more than a sample or so.
        flags: ``log-delay`` if it was.
    """
    known = trial.axes["marker"].tolist()
    if MARKED_BELT in trial.attributes or not set(options.belt_fixed_labels) & set(known):
        return trial, ()
    riding = belt_fixed_position(trial, options.belt_fixed_labels, "aligned")
    belt = trial.signals["belt_velocity"]
    velocity = derivative(trial.time, options.lowpass(riding, trial.rate_hz))
    logged = options.lowpass(belt.values, trial.rate_hz)
    delay, correlation, _ = common_signal_delay(velocity, logged, trial.rate_hz, LONGEST_LOG_DELAY_S)
    if abs(delay) <= LOG_DELAY_S or correlation < LEAST_CORRELATION:
        return trial, ()
    moved = replace(
        belt,
        values=advanced(trial.time, belt.values, delay),
        processing=(*belt.processing, f"moved by {-1e3 * delay:.3g} ms to the belt-fixed markers"),
    )
    return replace(trial, signals=trial.signals | {"belt_velocity": moved}), ("log-delay",)


def leg_motion(prepared: PreparedTrial, options: DummyOptions, instants: str) -> SegmentMotion:
    """Motion of the leg from its filtered markers (s, rad, m).

    instants: {"aligned", "as-sampled"}: Whether sequential marker sampling is corrected.
    """
    positions = prepared.trial.values(MARKER_SIGNALS[instants])
    on_leg = prepared.filtered(marker_positions(positions, prepared.markers, options.leg_markers))
    return motion_of_markers(prepared.time, on_leg, options.leg_markers, options.leg.com_m)


def trial_markers(trial: Trial, options: DummyOptions, instants: str) -> DummyMarkers:
    """Markers of foot and leg, not filtered.

    options: markers on the leg, and on the belt.
    instants: {"aligned", "as-sampled"}: Whether sequential marker sampling is corrected.
    Returns: positions and samples that were filled.
    """
    hidden = trial.optional("marker_hidden")
    if hidden is not None and instants == "aligned":
        # a sample at a common instant lies between two that were recorded
        around = np.asarray(hidden, dtype=bool)
        hidden = around.copy()
        hidden[1:] |= around[:-1]
        hidden[:-1] |= around[1:]
    markers = dummy_markers(
        trial.values(MARKER_SIGNALS[instants]),
        trial.axes["marker"].tolist(),
        options.leg_markers,
        options.belt_fixed_labels,
        hidden,
    )
    return markers if instants == "aligned" else replace(markers, places=None)


def leg_knowledge(
    prepared: PreparedTrial, options: DummyOptions, pathway: Pathway, motion: SegmentMotion
) -> LegUncertainty:
    """Leg and markers as a pathway assumes them (m, kg, s), with their uncertainty.

    The thesis's equation is wrong, so only Type A is reported for it.
    """
    markers, sources = options.leg_markers, options.sources
    if pathway.torque != "leg":
        return LegUncertainty(options.leg, markers, {}, motion)
    later = None
    if "marker_sampling_s" in sources and pathway.marker_instants == "aligned":
        labels, time = prepared.markers, prepared.time
        positions = marker_positions(prepared.trial.values(MARKER_SIGNALS["aligned"]), labels, markers)
        lag = sources["marker_sampling_s"].standard_uncertainty * np.array(
            [labels.index(label) for label in markers.labels]
        )
        filtered = prepared.filtered(positions)
        rate = derivative(time, filtered.reshape(len(filtered), -1)).reshape(filtered.shape)
        later = motion_of_markers(time, filtered + lag[:, None] * rate, markers, options.leg.com_m)
    return LegUncertainty(options.leg, markers, sources, motion, later, options.foot)


def belt_fixed_position(
    trial: Trial, labels: tuple[str, ...], instants: str
) -> Annotated[np.ndarray, "(n,)", "m"]:
    """Mean position of the belt-fixed markers along the belt (m), shape (n,).

    instants: {"aligned", "as-sampled"}: Whether sequential marker sampling is corrected.
    Returns: position, unfiltered.
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


def _faults_of_markers(prepared: PreparedTrial, options: DummyOptions) -> tuple[str, ...]:
    """Faults of the leg's markers as recorded, and another amplitude of the belt.

    Names in `tepsipe.flags.FLAGS`.
    """
    along = prepared.trial.values(MARKER_SIGNALS["as-sampled"])[:, :, 1].astype(float)
    signals = {label: along[:, prepared.markers.index(label)] for label in options.leg_markers.labels}
    of_belt = tuple(fault for fault in recorded_faults(prepared.trial) if fault == "other-amplitude")
    return flags_of(prepared.rate_hz, prepared.at_rest, **signals) + of_belt


def _noise_at_rest(prepared: PreparedTrial, options: DummyOptions) -> float:
    """Root mean square of the noise filtered out of the leg's markers at rest (m per coordinate)."""
    columns = [prepared.markers.index(label) for label in options.leg_markers.labels]
    positions = prepared.trial.values(MARKER_SIGNALS["as-sampled"])[:, columns, 1:]
    return float(np.sqrt(np.mean((positions - prepared.filtered(positions))[prepared.at_rest] ** 2)))
