"""Check a study without running it: ``python -m workflow.check [CONFIG...]``, as after ``--configfile``.

Configuration and trial sheet first, then every recording is read as its job would read it. The last lines are
verdicts on K of a dummy and of standing persons. The status is 0, 2 where the run would stop, or 1 where it
would not, but a recording has a fault, or no K that has a verdict will be quotable.
"""

import math
import sys

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from workflow.support import job_outputs
from workflow.support.checked_study import (
    checked_sections,
    checked_study,
    merged_settings,
    shipped,
    with_its_file,
)
from workflow.support.recordings import refused_recordings
from workflow.support.to_record import Read, faults_of, to_record
from workflow.support.verdict import QUOTABLE, verdicts

# usual ranges of settings; beyond them, the user is asked
# radius of gyration of the leg about its centre of mass, per distance of that centre from the ankle
GYRATION = (0.2, 1.5)
BODY_MASS_INDEX = (14.0, 45.0)
PERSON = {"ankle_height_m": (0.04, 0.15), "foot_com_m": (0.0, 0.12), "com_height": (0.5, 0.62)}
CUTOFF_HZ = (5.0, 60.0)
LONGEST_S = 3600.0


def main(files: list[str]) -> int:
    """Say what the study holds, or in one sentence each what would stop it; 0, 1 or 2."""
    configfiles, config = [shipped(), *files], {}
    try:
        config = merged_settings(configfiles)
        study = checked_study(config, configfiles)
        for key in ("virtual_lab", "reported"):
            checked_sections(config, key)
        found = job_outputs.changes(config["pathvars"]["logs"])
        job_outputs.refuse_edited(found)
    except InputError as error:
        print(f"tepsipe: {with_its_file(error, config, configfiles)}", file=sys.stderr)
        return 2
    read = Read()
    refused = refused_recordings(study, read)
    for sentence in refused:
        print(f"tepsipe: {sentence}", file=sys.stderr)
    if refused:
        return 2
    try:
        judged = verdicts(study, read)
    except InputError as error:
        print(f"tepsipe: {error}", file=sys.stderr)
        return 2
    faults = faults_of(read)
    for question in (*odd_settings(study), *faults):
        print(f"to be confirmed: {question}")
    for wanted in to_record(study, read):
        print(f"to be recorded: {wanted}")
    counts = ", ".join(f"{len(study.conditions(name))} of {name}" for name in study.experiments)
    trials = "1 trial" if len(study.trials) == 1 else f"{len(study.trials)} trials"
    print(f"{files[-1] if files else shipped()}: {trials} ({counts})")
    print(f"trial sheet: {config['study']['trial_sheet']}; results: {config['pathvars']['results']}")
    left = job_outputs.of_no_trial(config["pathvars"]["logs"], study.trials, EXPERIMENTS)
    for what, paths in (("missing or damaged", found.missing + found.damaged), ("of no trial", left)):
        if paths:
            print(f"results that are {what}: {len(paths)}, for example {paths[0]}")
    for verdict in judged:
        print(f"verdict: {verdict}")
    lost = bool(judged) and not any(QUOTABLE in verdict for verdict in judged)
    if lost:
        print("tepsipe: no K will be quotable: follow the verdicts before the run", file=sys.stderr)
    if faults:
        print("tepsipe: recordings have faults: see the lines to be confirmed", file=sys.stderr)
    return int(lost or bool(faults))


def odd_settings(study) -> list[str]:
    """Questions about values that are possible but rare, of the experiments in the study.

    Parameters
    ----------
    study : Study
        A checked study.
    """
    asked = []
    if study.has("dummy"):
        asked += _of_dummy(study.settings["dummy"]["geometry"])
    if study.has("standing"):
        asked += _of_people(study)
    if any(study.has(name) for name in ("dummy", "weight", "standing")):
        cutoff = study.config["plate_treadmill"]["lowpass_cutoff_hz"]
        if not CUTOFF_HZ[0] <= cutoff <= CUTOFF_HZ[1]:
            asked.append(
                f"plate_treadmill.lowpass_cutoff_hz is {cutoff:g} Hz: below {CUTOFF_HZ[0]:g} Hz pulses are "
                f"flattened, above {CUTOFF_HZ[1]:g} Hz noise passes; is it meant?"
            )
    asked += [
        f"duration_s of {experiment}/{condition} is {row.duration_s:g} s: is it in s?"
        for (experiment, condition), row in study.trials.items()
        if row.duration_s > LONGEST_S
    ]
    return asked


def _of_dummy(leg: dict) -> list[str]:
    asked = []
    ratio = math.sqrt(leg["leg_inertia_kgm2"] / leg["leg_mass_kg"]) / leg["leg_com_m"]
    if not GYRATION[0] <= ratio <= GYRATION[1]:
        asked.append(
            f"dummy.geometry.leg_inertia_kgm2 is {leg['leg_inertia_kgm2']:g}: its radius of "
            f"gyration would be {ratio:.2g} times leg_com_m, a rod has 0.58; is it about its centre of mass?"
        )
    highest = max(marker["longitudinal_offset_m"] for marker in leg["leg_markers"])
    if leg["leg_com_m"] > 2.0 * highest:
        asked.append(
            f"dummy.geometry.leg_com_m is {leg['leg_com_m']:g} m, the highest marker stands {highest:g} m "
            "above the ankle: is the centre of mass so far above it?"
        )
    return asked


def _of_people(study) -> list[str]:
    asked = []
    names = study.participants("standing") or [None]
    for name in names:
        person, who = study.person(name), "standing.person" if name is None else f"participant {name}"
        index = person["mass_kg"] / person["stature_m"] ** 2
        if not BODY_MASS_INDEX[0] <= index <= BODY_MASS_INDEX[1]:
            asked.append(
                f"{who}: {person['mass_kg']:g} kg and {person['stature_m']:g} m make a body mass index of "
                f"{index:.3g}: are both right?"
            )
        for key, (low, high) in PERSON.items():
            if not low <= person[key] <= high:
                asked.append(
                    f"{who}: {key} is {person[key]:g}, of most people {low:g} to {high:g}: is it meant?"
                )
    return asked


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
