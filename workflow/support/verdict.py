"""Verdict on K of every recorded trial of a dummy and every task of a standing person, before the run.

The functions of the run analyse the recordings, with the recommended torque and estimator, and with the
models of the treadmill that they need. Whether K is quoted, its flags and its interval are therefore the same
as in the run. The value of K is not shown, so that it cannot influence the choice of trials.
"""

from tepsipe.experiments.dummy.fit import fit as fit_dummy
from tepsipe.experiments.dummy.rig import flag_rig, rig_flags
from tepsipe.experiments.standing import fit_task
from tepsipe.experiments.standing.fit import fit as fit_standing
from tepsipe.experiments.standing.muscle_torque import NONE
from tepsipe.experiments.weight.calibrate import PlateCalibration, PlateTrial, calibrate_plate
from tepsipe.io.estimates import FLAGS, Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.treadmill.options import FRAMES, Weight
from workflow.support.people import BELTS
from workflow.support.recordings import ingested
from workflow.support.study import Study
from workflow.support.to_record import Read

QUOTABLE = "K will be quotable"
MOST = 2  # trials that are named as left out
# flags of a K that is not quoted; other flags beside them are their consequences
DECIDING = ("uncompensated", "other-calibration", "negative", "treadmill-model", "treadmill-not-converged")


def verdicts(study: Study, read: Read) -> list[str]:
    """One sentence for every trial of the dummy and every person and task, see `sentence`.

    study: a study whose recordings can all be used.
    read: from these recordings.
    """
    return _of_dummies(study, read) + _of_people(study, read)


def _trial(study: Study, read: Read, experiment: str, condition: str) -> Trial:
    """A trial as it has been read, or read again."""
    kept = read.trials.get((experiment, condition))
    return kept if kept is not None and kept.signals else ingested(study, experiment, condition)


def _of_dummies(study: Study, read: Read) -> list[str]:
    fitted = {}
    for condition in study.recorded("dummy"):
        section = study.of_trial("dummy", condition)
        names = section["recommended"], section["quoted"]
        fitted[condition] = fit_dummy(
            _trial(study, read, "dummy", condition),
            section | {"pathways": {name: section["pathways"][name] for name in names}},
            condition,
            study.config["study"]["seed"],
            study.settings["uncertainty"]["dummy"],
        )
    faults, said = rig_flags({condition: found.result.facts for condition, found in fitted.items()}), []
    for condition, found in fitted.items():
        rows = [row for row in flag_rig(found.estimates, faults) if row.quantity == "K"]
        usual = study.settings["dummy"]["recommended"]
        row = next((row for row in rows if row.recommended), None)
        row = row or next((row for row in rows if row.pathway == usual), None)
        said.append(f"dummy/{condition}: {sentence(row, [])}")
    return said


def _of_people(study: Study, read: Read) -> list[str]:
    pools = [
        pool
        for pool in study.tasks.pools().values()
        if set(pool.conditions) <= set(study.recorded("standing"))
    ]
    if not pools:
        return []
    section = _recommended_only(study.settings["standing"])
    model = section["pathways"][section["recommended"]["pathway"]]["treadmill_model"]
    belts = {belt for pool in pools for c in pool.conditions for belt in _belts(study, c)}
    plates = {} if model is None else {belt: _calibrated(study, read, belt, model) for belt in sorted(belts)}
    said = []
    for participant in dict.fromkeys(pool.participant for pool in pools):
        own = [pool for pool in pools if pool.participant == participant]
        responses = {c: _responses(study, read, c, section, plates) for pool in own for c in pool.conditions}
        for pool in own:
            fitted = fit_task.fit(
                [responses[c] for c in pool.conditions],
                section | {"person": study.person(participant)},
                pool.name,
                study.config["study"]["seed"],
                study.settings["uncertainty"]["standing"],
                [found for c, found in responses.items() if c not in pool.conditions],
            )
            left_out = [text for c in pool.conditions for text in responses[c].facts["left_out"]]
            row = _stiffness(fitted.estimates, section["recommended"])
            said.append(f"standing/{pool.name}: {sentence(row, left_out)}")
    return said


def _recommended_only(section: dict) -> dict:
    """Settings with the recommended torque and estimator only, and with the estimators that check them."""
    pathway, estimator = (section["recommended"][key] for key in ("pathway", "estimator"))
    estimators = {
        name: choice
        for name, choice in section["estimators"].items()
        if name == estimator or (choice["active"] == NONE and not choice["inertia"])
    }
    pathways = {pathway: section["pathways"][pathway]}
    return section | {"pathways": pathways, "estimators": estimators, "as_printed": pathway}


def _belts(study: Study, condition: str) -> tuple[str, ...]:
    belt = study.treadmill.belt_of("standing", condition)
    return BELTS if belt == "both" else (belt,)


def _calibrated(study: Study, read: Read, belt: str, model: str) -> PlateCalibration:
    """Models of a plate as the run fits them: one model by its name, and those that are judged together."""
    section, trials = study.settings["weight"], []
    for experiment, condition, role in study.treadmill.plate_trials(belt):
        weight = study.treadmill.weight_of(experiment, condition)
        known = None if weight is None else Weight(**weight)
        trial = _trial(study, read, experiment, condition)
        trials.append(PlateTrial(experiment, condition, role, known, trial))
    analysis, models = section["analysis"], section["models"]
    family = [name for name in models["family"] if name in (*FRAMES, model)]
    return calibrate_plate(
        trials,
        study.treadmill.plate_of(belt),
        belt,
        section["weight"]["mass_kg"],
        analysis | {"cutoffs_hz": analysis["cutoffs_hz"][:1]},
        models | {"family": family},
        study.config["study"]["seed"],
    )


def _responses(
    study: Study, read: Read, condition: str, section: dict, plates: dict[str, PlateCalibration]
) -> Result:
    """Responses of a trial, as its fit stores them."""
    known = [plates[belt] for belt in _belts(study, condition) if belt in plates]
    of_trial = study.of_trial("standing", condition)
    fitted = fit_standing(
        _trial(study, read, "standing", condition),
        of_trial | {key: section[key] for key in ("pathways", "estimators", "as_printed")},
        condition,
        study.config["study"]["seed"],
        study.settings["uncertainty"]["standing"],
        [{each.name: each for each in plate.models[load]} for plate in known for load in ("Fy", "Mx")],
        [plate.held_out for plate in known],
    )
    return fitted.further["responses"]


def _stiffness(rows: list[Estimate], recommended: dict[str, str]) -> Estimate | None:
    """K of a task by the recommended torque and estimator, if it could be estimated."""
    names = recommended["pathway"], recommended["estimator"]
    return next((row for row in rows if row.quantity == "K" and (row.pathway, row.estimator) == names), None)


def sentence(row: Estimate | None, left_out: list[str]) -> str:
    """How well K will be known, or why it will not be quotable.

    row: K of the trial or task.
    left_out: reasons for what was omitted of its trials.
    """
    flags = [] if row is None else list(filter(None, row.flags.split(";")))
    reasons = [f"{flag}: {FLAGS[flag]}" for flag in flags]
    if row is not None and row.recommended:
        known = row.ci_low is not None and row.ci_high is not None
        half = 50.0 * (row.ci_high - row.ci_low) / row.value if known else None
        width = "no interval" if half is None else f"± {half:.2g} % expected"
        return f"{QUOTABLE}, {width}" + "".join(f"; {reason}" for reason in reasons)
    reasons = [reason for flag, reason in zip(flags, reasons, strict=True) if flag in DECIDING] or reasons
    whole = [text for text in left_out if "left out as a whole: " in text]
    reasons = reasons or (whole or left_out)[:MOST] or ["no response to a perturbation was usable"]
    return f"K will not be quotable: {'; '.join(reasons)}"
