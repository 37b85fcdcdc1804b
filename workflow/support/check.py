"""Checks of the configuration before anything is computed; each raises one sentence."""

import difflib
import math
from functools import cache
from pathlib import Path

import jsonschema

from tepsipe.errors import InputError, quoted
from tepsipe.identification.estimators import ESTIMATORS
from workflow.support.names import check_text
from workflow.support.renames import PATHWAYS, VALUES, answer_for_key, moved_from, renamed
from workflow.support.settings import ON_THE_PLATE, plate_key, settings_of
from workflow.support.several_joints import check_several_joints
from workflow.support.trial_sheet import TrialRow
from workflow.support.walking import check_walking
from workflow.support.yaml_file import read_settings


def check_against_schema(content: dict, schema_path: str | Path, name: str) -> None:
    """Raise one sentence for the first part of ``content`` that the closed schema refuses."""
    _refuse_not_finite(content, name, "")
    _refuse_marks(content, name)
    schema = _schema(Path(schema_path))
    errors = list(jsonschema.Draft202012Validator(schema).iter_errors(content))
    # a misspelt key also counts as a missing one: report the key that was found
    errors.sort(key=lambda e: (e.validator != "additionalProperties", list(map(str, e.path))))
    if errors:
        raise InputError(f"{name}: {_sentence(errors[0], schema, content)}")


@cache
def _schema(path: Path) -> dict:
    return read_settings(path)


def _refuse_not_finite(content, name: str, where: str) -> None:
    if isinstance(content, float) and not math.isfinite(content):
        raise InputError(f"{name}: expected a finite number for {where!r}, found {content}: correct it")
    if isinstance(content, dict | list):
        items = content.items() if isinstance(content, dict) else enumerate(content)
        for key, value in items:
            _refuse_not_finite(value, name, f"{where}.{key}" if where else str(key))


def _refuse_marks(content, name: str) -> None:
    """Keys go through Snakemake, which fills in what braces hold; text goes into its HTML report."""
    if isinstance(content, str):
        check_text(content, name)
    if isinstance(content, list):
        for value in content:
            _refuse_marks(value, name)
    if isinstance(content, dict):
        for key, value in content.items():
            if set("{}") & set(str(key)):
                raise InputError(f"{name}: expected a key without braces, found {quoted(key)}: rename it")
            _refuse_marks(value, name)


def _sentence(error: jsonschema.ValidationError, schema: dict, content: dict) -> str:
    where = ".".join(map(str, error.path))
    if error.validator == "additionalProperties":
        unknown = next(key for key in error.instance if key not in error.schema.get("properties", {}))
        return _unknown_key(where, str(unknown), list(error.schema.get("properties", {})), schema)
    if error.validator == "required":
        missing = next(key for key in error.validator_value if key not in error.instance)
        key = f"{where}.{missing}" if where else missing
        hint = _old_name(error.path, content)
        hint = hint or "add it (config/README.md describes it)"
        return f"expected the key {quoted(key, 120)}, found none: {hint}"
    found = f"found {quoted(error.instance)}"
    if error.validator == "enum":
        hint = renamed(VALUES, error.instance, error.validator_value) or "correct it"
        known = ", ".join(map(repr, error.validator_value))
        return f"expected one of {known} for {where!r}, {found}: {hint}"
    expected = {
        "type": lambda: f"a value of type {_or(error.validator_value)}",
        "exclusiveMinimum": lambda: f"a number above {error.validator_value}",
        "exclusiveMaximum": lambda: f"a number below {error.validator_value}",
        "minimum": lambda: f"a number of at least {error.validator_value}",
        "maximum": lambda: f"a number of at most {error.validator_value}",
        "minProperties": lambda: f"at least {error.validator_value} entry",
        "minItems": lambda: f"at least {error.validator_value} items",
        "maxItems": lambda: f"at most {error.validator_value} items",
        "uniqueItems": lambda: "different items",
        "pattern": lambda: f"a value of the pattern {error.validator_value}",
    }.get(error.validator, lambda: error.message[:200])()
    return f"expected {expected} for {quoted(where, 120)}, {found}: correct it"


def _unknown_key(where: str, unknown: str, known: list[str], schema: dict) -> str:
    key = f"{where}.{unknown}" if where else unknown
    everywhere = _all_keys(schema)
    answer = answer_for_key(key, known, everywhere)
    if answer is None:
        elsewhere = [path for path in everywhere if path.rpartition(".")[2] == unknown]
        # a misspelt key may have moved
        likely = {name: name for name in known} | moved_from(where)
        close = difflib.get_close_matches(unknown, likely, n=1, cutoff=0.5)
        if elsewhere:
            # the sections whose names are most like the one where the key stands
            nearest = difflib.get_close_matches(key, elsewhere, n=3, cutoff=0.0)
            more = f", or one of {len(elsewhere) - 3} more" if len(elsewhere) > 3 else ""
            answer = f"did you mean {' or '.join(map(repr, nearest))}{more}?"
        elif close:
            answer = f"did you mean {likely[close[0]]!r}?"
        else:
            answer = f"known here: {', '.join(known)}"
    if where.startswith("uncertainty.") and not answer.startswith("known here"):
        answer += f" (known here: {', '.join(known)})"
    return f"unknown key {quoted(key, 120)}: {answer}"


def _old_name(path, content: dict) -> str | None:
    """Hint for an incomplete entry under an old name, for example a pathway, or None."""
    for name in path:
        known = content if isinstance(content, dict) else ()
        answer = renamed(PATHWAYS, name, known) or renamed(VALUES, name, known)
        if answer:
            return f"{name} was {answer}, write that, or complete a pathway of your own"
        content = content[name]
    return None


def _or(types) -> str:
    return types if isinstance(types, str) else " or ".join(types)


def _all_keys(schema: dict, where: str = "", shared: dict | None = None) -> list[str]:
    """Every key that the schema names, with the sections around it, dots in between."""
    shared = schema.get("$defs", {}) if shared is None else shared
    schema = shared[schema["$ref"].removeprefix("#/$defs/")] if "$ref" in schema else schema
    keys: list[str] = []
    for name, inner in schema.get("properties", {}).items():
        path = f"{where}.{name}" if where else name
        keys += [path, *_all_keys(inner, path, shared)]
    return keys


def _refuse_unknown(name: str, key: str, found: str | None, section: str, known) -> None:
    """Refuse a name that is looked up in a section, or list, and not found."""
    if found in known:
        return
    close = difflib.get_close_matches(str(found), known, n=1)
    hint = f"did you mean {close[0]!r}?" if close else "correct one of the two"
    raise InputError(
        f"{name}: expected {key} to name one of {section} ({', '.join(map(str, known))}), found "
        f"{quoted(found)}: {renamed(PATHWAYS, found, known) or renamed(VALUES, found, known) or hint}"
    )


def check_config(config: dict, name: str) -> None:
    """Checks beyond the schema: names that refer to each other, and order."""
    config = settings_of(config)
    dummy, wristalyzer = config["dummy"], config["wristalyzer"]
    for key in ("as_printed", "recommended", "quoted"):
        _refuse_unknown(name, f"dummy.{key}", dummy[key], "dummy.pathways", dummy["pathways"])
    labels = [marker["label"] for marker in dummy["geometry"]["leg_markers"]]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise InputError(
            f"{name}: expected dummy.geometry.leg_markers to place every marker once, found "
            f"{quoted(twice[0])} twice: correct one of the two"
        )
    unknown = sorted(set(labels) - set(dummy["files"]["marker_labels"]))
    if unknown:
        raise InputError(
            f"{name}: expected dummy.geometry.leg_markers to name markers of "
            f"dummy.files.marker_labels, found {quoted(unknown[0])}: correct one of the two"
        )
    _check_plausible(config["plausible"], name)
    _check_filters(config, name)
    _check_estimators(dummy, name)
    _check_specification(config, name)
    analysis = wristalyzer["analysis"]
    for key in ("fit_band_hz", "excited_band_hz", "profile_stiffness_Nm_per_rad"):
        low, high = analysis[key]
        if not low < high:
            raise InputError(
                f"{name}: expected wristalyzer.analysis.{key} from low to high, found [{low}, {high}]: "
                "turn it round"
            )
    for key, start in analysis["start"].items():
        low, high = analysis["lower"][key], analysis["upper"][key]
        if not low < start < high:
            raise InputError(
                f"{name}: expected wristalyzer.analysis.start.{key} between its bounds {low} and "
                f"{high}, found {start}: correct one of the three"
            )
    for stiffness in analysis["tried_stiffness_Nm_per_rad"]:
        low, high = analysis["lower"]["K_Nm_per_rad"], analysis["upper"]["K_Nm_per_rad"]
        if not low < stiffness < high:
            raise InputError(
                f"{name}: expected wristalyzer.analysis.tried_stiffness_Nm_per_rad between the bounds "
                f"{low} and {high}, found {stiffness}: correct it"
            )
    _check_treadmill(config, name)
    if config["plan"] is not None:
        _check_plan(config, name)
    if config["walking"] is not None:
        check_walking(config["walking"], name)
    if config["noise"]["table_snr_db"] not in config["noise"]["snr_db"]:
        raise InputError(
            f"{name}: expected noise.table_snr_db to be one of noise.snr_db ({config['noise']['snr_db']}), "
            f"found {config['noise']['table_snr_db']}: correct one of the two"
        )
    _check_reflex(config["position_manipulator"]["analysis"]["parallel_cascade"], name)
    _check_standing(config["standing"], config["weight"]["models"]["family"], name)


def _check_plausible(limits: dict, name: str) -> None:
    """Limits of signals must be in order."""
    for key, value in limits.items():
        if isinstance(value, list) and not value[0] < value[1]:
            raise InputError(
                f"{name}: expected plausible.{key} from low to high, found [{value[0]}, {value[1]}]: turn it "
                "round"
            )


def _check_filters(config: dict, name: str) -> None:
    """Every cutoff must lie below half of the rate of what is filtered."""
    filters = []
    for section in ("wristalyzer", "position_manipulator"):
        keys = (f"{section}.analysis.lowpass_cutoff_hz", f"{section}.ingest.resample_rate_hz")
        filters.append((section, *keys, config[section]["analysis"]["lowpass_cutoff_hz"]))
    for section in ("dummy", "standing"):
        keys = [plate_key(config, section, key) for key in ("lowpass_cutoff_hz", "resample_rate_hz")]
        filters.append((section, *keys, config[section]["analysis"]["lowpass_cutoff_hz"]))
    stretch = config["standing"]["analysis"]["stretch_cutoff_hz"]
    filters.append(("standing", "standing.analysis.stretch_cutoff_hz", keys[1], stretch))
    first, *others = config["weight"]["analysis"]["cutoffs_hz"]
    rate_key = "plate_treadmill.resample_rate_hz"
    filters.append(("weight", "plate_treadmill.lowpass_cutoff_hz", rate_key, first))
    filters += [("weight", "weight.analysis.other_cutoffs_hz", rate_key, cutoff) for cutoff in others]
    for section, cutoff_key, rate_key, cutoff in filters:
        half = 0.5 * config[section]["ingest"]["resample_rate_hz"]
        if cutoff >= half:
            raise InputError(
                f"{name}: expected {cutoff_key} below half of {rate_key} ({half:g} Hz), found {cutoff:g}: "
                "lower it"
            )
    if first in others:
        raise InputError(
            f"{name}: expected weight.analysis.other_cutoffs_hz beside plate_treadmill.lowpass_cutoff_hz, "
            f"found {first:g} Hz for both: take it out"
        )


def _check_estimators(dummy: dict, name: str) -> None:
    """Estimators must be in the library's registry, and each pathway must have what its estimator needs."""
    windowed = [key for key, estimator in ESTIMATORS.items() if estimator.windowed]
    for section, pathways, known in (
        ("dummy.pathways", dummy["pathways"], list(ESTIMATORS)),
        ("dummy.foot.pathways", dummy["foot"]["pathways"], windowed),
    ):
        for pathway, choice in pathways.items():
            key = f"{section}.{pathway}.estimator"
            _refuse_unknown(name, key, choice["estimator"], "the estimators", known)
    for pathway, choice in dummy["pathways"].items():
        if "torque" in ESTIMATORS[choice["estimator"]].needs:
            continue
        if choice["torque"] != "leg":
            raise InputError(
                f"{name}: expected the torque leg in dummy.pathways.{pathway}, because the estimator "
                f"{choice['estimator']} uses a torque for its VAF only, found {quoted(choice['torque'])}: "
                "correct one of the two"
            )
        for key in ("as_printed", "recommended"):
            if dummy[key] == pathway:
                raise InputError(
                    f"{name}: expected dummy.{key} to name a pathway with windowed least squares, because "
                    f"tables and figures show every perturbation, found {quoted(pathway)}: name another"
                )
        unknown = sorted(set(dummy["foot"]["belt_fixed_labels"]) - set(dummy["files"]["marker_labels"]))
        if unknown:
            raise InputError(
                f"{name}: expected dummy.foot.belt_fixed_labels to name markers of "
                f"dummy.files.marker_labels, found {quoted(unknown[0])}: correct one of the two"
            )


def _check_specification(config: dict, name: str) -> None:
    """The other filter must be another one, and below half of the rate."""
    dummy = config["dummy"]
    tried, cutoff = dummy["specification"]["other_cutoff_hz"], dummy["analysis"]["lowpass_cutoff_hz"]
    half = 0.5 * dummy["ingest"]["resample_rate_hz"]
    if tried == cutoff or tried >= half:
        cutoff_key, rate_key = (
            plate_key(config, "dummy", key) for key in ("lowpass_cutoff_hz", "resample_rate_hz")
        )
        raise InputError(
            f"{name}: expected dummy.specification.other_cutoff_hz below half of {rate_key} ({half:g} Hz) "
            f"and not {cutoff_key} ({cutoff:g} Hz), found {tried:g}: correct it"
        )


def _check_reflex(reflex: dict, name: str) -> None:
    """Delays must be in order, and a reflex response needs a knot between its ends."""
    where = f"{name}: expected position_manipulator.analysis.parallel_cascade"
    shortest, longest = reflex["reflex_delays_s"]
    if not shortest <= reflex["expected_delay_s"] <= longest:
        raise InputError(
            f"{where}.expected_delay_s within reflex_delays_s, from short to long ([{shortest}, {longest}]), "
            f"found {reflex['expected_delay_s']}: correct one of the two"
        )
    if not reflex["profiled_delays_s"][0] <= reflex["profiled_delays_s"][1]:
        raise InputError(
            f"{where}.profiled_delays_s from short to long, found {reflex['profiled_delays_s']}: turn it "
            "round"
        )
    if reflex["reflex_length_s"] < 2.0 * reflex["reflex_knot_s"]:
        raise InputError(
            f"{where}.reflex_knot_s of at most half of reflex_length_s ({reflex['reflex_length_s']:g} s), "
            f"found {reflex['reflex_knot_s']:g} s: correct one of the two"
        )


def _check_treadmill(config: dict, name: str) -> None:
    """Models that are named must be in the family, families must suit the experiment, filters the rate."""
    plate, table = config["weight"], config["belt"]
    foot = config["dummy"]["foot"]["pathways"]
    _check_models_of_pathways("dummy.foot", foot, plate["models"]["family"], name)
    family = table["models"]["family"]
    _refuse_unknown(name, "belt.chosen", table["chosen"], "belt.models.family", family)
    for section, unsuited, why in (
        (
            "belt",
            ("mean-subtraction", "loaded-frame", "bristle-frame"),
            "needs an empty belt beside a weight",
        ),
        ("weight", ("ripple-tracking",), "needs a belt that travels"),
    ):
        for model in unsuited:
            if model in config[section]["models"]["family"]:
                raise InputError(
                    f"{name}: expected models in {section}.models.family that suit this experiment, found "
                    f"{quoted(model)}, which {why}: take it out"
                )
    analysis = table["analysis"]
    if analysis["zero_lag"] and analysis["lowpass_order"] % 2:
        raise InputError(
            f"{name}: expected an even belt.analysis.lowpass_order, because the filter is "
            f"zero-lag, found {analysis['lowpass_order']}: correct one of the two"
        )


def _check_standing(standing: dict, family: list[str], name: str) -> None:
    """Pathways, estimators, models, markers and windows that are named must exist, and windows must fit."""
    recommended = standing["recommended"]
    for key, wanted, section in (
        ("as_printed", standing["as_printed"], "pathways"),
        ("recommended.pathway", recommended["pathway"], "pathways"),
        ("recommended.estimator", recommended["estimator"], "estimators"),
    ):
        _refuse_unknown(name, f"standing.{key}", wanted, f"standing.{section}", standing[section])
    _check_models_of_pathways("standing", standing["pathways"], family, name)
    people = {"person": standing["person"]}
    people |= {f"participants.{participant}": own for participant, own in standing["participants"].items()}
    for key, person in people.items():
        for segment in ("foot_markers", "shank_markers", "thigh_markers"):
            for marker in person.get(segment, ()):
                if marker["label"] not in standing["files"]["marker_labels"]:
                    raise InputError(
                        f"{name}: expected standing.{key}.{segment} to name markers of "
                        f"standing.files.marker_labels, found {quoted(marker['label'])}: correct one of the "
                        "two"
                    )
    analysis = standing["analysis"]
    for estimator, choice in standing["estimators"].items():
        if choice["window_s"] > analysis["after_s"]:
            raise InputError(
                f"{name}: expected standing.estimators.{estimator}.window_s of at most "
                f"standing.analysis.after_s ({analysis['after_s']:g} s), found {choice['window_s']:g} s: "
                "correct one of the two"
            )
    for key, (low, high), least, most in (
        ("analysis.baseline_s", analysis["baseline_s"], -analysis["before_s"], 0.0),
        (
            "latency.search_s",
            standing["latency"]["search_s"],
            standing["latency"]["baseline_until_s"],
            analysis["after_s"],
        ),
        ("emg.band_hz", standing["emg"]["band_hz"], 0.0, math.inf),
    ):
        if not least <= low < high <= most:
            raise InputError(
                f"{name}: expected standing.{key} from low to high between {least:g} and {most:g}, found "
                f"[{low}, {high}]: correct it"
            )
    if max(analysis["tried_windows_s"]) > analysis["after_s"]:
        raise InputError(
            f"{name}: expected standing.analysis.tried_windows_s of at most standing.analysis.after_s "
            f"({analysis['after_s']:g} s), found {max(analysis['tried_windows_s']):g} s: correct one of the "
            "two"
        )


def _check_models_of_pathways(section: str, pathways: dict, family: list[str], name: str) -> None:
    """A pathway's model of the treadmill must be one that is fitted."""
    for pathway, choice in pathways.items():
        if choice["treadmill_model"] is not None:
            key = f"{section}.pathways.{pathway}.treadmill_model, if not null,"
            _refuse_unknown(name, key, choice["treadmill_model"], "weight.models.family", family)


def check_one_treadmill(config: dict, experiments, name: str, by_belt: bool = False) -> None:
    """Models of the treadmill hold for one belt, rate and filter; exceptions are refused with the weight.

    If the trial sheet names belts, each has models of its own (``by_belt``).
    """
    shared = config["plate_treadmill"]
    for experiment, own in shared["exceptions"].items():
        if not {experiment, "weight"} <= set(experiments):
            continue
        for key, value in own.items():
            if key != "recording" and value != shared[key] and not (by_belt and key == "belt"):
                column = ", or name the belt of every trial in the trial sheet" if key == "belt" else ""
                raise InputError(
                    f"{name}: expected plate_treadmill.{key} ({shared[key]}) for {experiment}, too, because "
                    "models of the treadmill, fitted to trials of weight and empty, hold for one belt, rate "
                    f"and filter, found {value} in plate_treadmill.exceptions.{experiment}: take "
                    f"it out{column}"
                )


def check_recordings(settings: dict, trials: dict[tuple, TrialRow], name: str) -> None:
    """Trials that are one file need to know the plates of the belt, and where its velocity is."""
    whole = {
        experiment
        for (experiment, _), row in trials.items()
        if experiment in ON_THE_PLATE and row.source == "recorded" and "calibration" not in row.files
    }
    for experiment in sorted(whole):
        section, here = settings[experiment]["recording"], f"{name}: expected plate_treadmill.recording"
        belts = {belt: section["plates"][belt] for belt in ("left", "right")}
        both = sorted(set(belts["left"]) & set(belts["right"]))
        if both:
            raise InputError(
                f"{here}.plates to give every force plate to one belt, found {both[0]} for both: correct "
                "one of the two"
            )
        belt = settings[experiment].get("belt", settings["plate_treadmill"]["belt"])
        if not belts[belt] and not section["load_cells"][belt]:
            raise InputError(
                f"{here}.plates to number a force plate of the {belt} belt, which is perturbed in the "
                f"trials of {experiment}, found none: add its number, or correct plate_treadmill.belt"
            )
        if section["axes"]["forward"][1] == section["axes"]["up"][1]:
            raise InputError(
                f"{here}.axes to be two different axes, found {section['axes']['forward']!r} and "
                f"{section['axes']['up']!r}: correct one of the two"
            )
        velocity = section["belt_velocity"]
        if velocity["channel"] is None and not velocity["markers"]:
            raise InputError(
                f"{here}.belt_velocity to name a channel or belt-fixed markers for the trials of "
                f"{experiment}, found none of both: name one of them"
            )


def check_plate_models(config: dict, name: str) -> None:
    """Without weight and empty belt there are no models for the pathways of a standing person."""
    for pathway, choice in config["standing"]["pathways"].items():
        if choice["treadmill_model"] is not None:
            raise InputError(
                f"{name}: expected trials of weight and empty beside those of standing, because "
                f"standing.pathways.{pathway} takes the model {choice['treadmill_model']!r} of the "
                "treadmill, found none: add their rows to the trial sheet, or set its treadmill_model to null"
            )


def _check_plan(config: dict, name: str) -> None:
    """A plan study names its own designs, and tries filters on simulated trials with a treadmill model."""
    plan, study = config["plan"], config["study"]
    for key, named in (("references", plan["references"]), ("filters.design", [plan["filters"]["design"]])):
        for design in named:
            _refuse_unknown(name, f"plan.{key}", design, "plan.designs", plan["designs"])
    if study["virtual_lab"] is None or config["coverage"] is not None:
        found = "study.virtual_lab null" if study["virtual_lab"] is None else "coverage, too"
        raise InputError(
            f"{name}: expected a plan study of simulated trials, whose truth is known, found {found}: "
            "correct "
            "it, or set plan to null"
        )
    pathway = config["dummy"]["foot"]["pathways"].get("foot-compensated")
    if pathway is None or pathway["treadmill_model"] not in config["weight"]["models"]["family"]:
        raise InputError(
            f"{name}: expected weight.models.family to fit the treadmill_model of "
            "dummy.foot.pathways.foot-compensated for a plan study, found none: add it"
        )
    check_several_joints(plan["several_joints"], config["dummy"]["simulation"]["engine"], name)
