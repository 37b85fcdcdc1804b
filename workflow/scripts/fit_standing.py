"""Post-process one trial of a standing person, cut its epochs, and estimate the ankle impedance."""

import job

job.start(snakemake)

from standing_choices import active_options, estimators_of, person_of

from tepsipe.experiments.standing.epochs import EpochOptions, cut_standing_epochs
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import StanceLimits, StandingOptions, TorquePathway
from tepsipe.experiments.standing.results import (
    fit_all,
    fit_estimates,
    over_sway,
    standing_result,
    trial_epochs_result,
)
from tepsipe.io.estimates import write_estimates
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.emg import EmgOptions
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.registry import load_treadmill_models

params, analysis, condition = snakemake.params, snakemake.params.analysis, snakemake.wildcards.condition
name = f"standing/{condition}"
person = person_of(params.person)
trial = read_trial(snakemake.input.trial)
standing = process_standing(
    trial,
    name,
    StandingOptions(
        person=person,
        belt=params.belt,
        lowpass=Lowpass(analysis["lowpass_cutoff_hz"], analysis["lowpass_order"], True),
        stretch_lowpass=Lowpass(analysis["stretch_cutoff_hz"], analysis["lowpass_order"], True),
        window=WindowOptions(**analysis["window"]),
        quiet_after_s=analysis["quiet_after_s"],
        limits=StanceLimits(**params.stance),
    ),
    {key: TorquePathway(**pathway) for key, pathway in params.pathways.items()},
    {
        load: load_treadmill_models(path)
        for load, path in zip(("Fy", "Mx"), snakemake.input.models, strict=False)
    },
)
responses = cut_standing_epochs(
    trial,
    standing,
    name,
    EpochOptions(
        before_s=analysis["before_s"],
        after_s=analysis["after_s"],
        baseline_s=tuple(analysis["baseline_s"]),
        least_perturbations=analysis["least_perturbations"],
        max_gap_s=params.max_gap_s,
        lowpass_cutoff_hz=analysis["lowpass_cutoff_hz"],
        lowpass_order=analysis["lowpass_order"],
        emg=EmgOptions(**params.emg),
        mains_hz=analysis["line_hz"],
    ),
)
fits, notes = fit_all(
    [responses],
    name,
    list(params.pathways),
    estimators_of(params.estimators),
    active_options(params.active, params.ankle_action),
    analysis["bootstrap_draws"],
    params.seed,
)
torques = {"as_printed": params.as_printed, "recommended": params.recommended}
facts = {
    "left_out": [*responses.left_out, *(notes if responses.count else [])],
    "perturbations": int(standing.onsets_s.size),
    "responses": responses.count,
    "muscles": responses.muscles,
    **over_sway(responses, params.recommended),
    "marker_delay_s": standing.delay_s,
    "critical_stiffness_Nm_per_rad": person.body.critical_stiffness,
}
write_result(snakemake.output.responses, trial_epochs_result(standing, responses, torques))
write_result(snakemake.output.fit, standing_result([responses], fits, params.recommended, [], facts))
write_estimates(
    snakemake.output.estimates, fit_estimates(condition, fits, person.body.critical_stiffness, [])
)
