"""Refuse an invalid configuration in one sentence before any computation."""

import difflib
import math
from pathlib import Path

import jsonschema
import yaml

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.text_file import read_text


def load_yaml(path: str | Path) -> dict:
    """Read a YAML file; refuse one that is missing, damaged or holds a key twice."""
    text = read_text(Path(path), "a configuration file")
    try:
        return yaml.load(text, Loader=_UniqueKeys) or {}
    except yaml.YAMLError as error:
        place = getattr(error, "problem_mark", None)
        line = f" on line {place.line + 1}" if place else ""
        problem = getattr(error, "problem", None) or error
        raise InputError(f"{path}: expected YAML, found a mistake{line} ({problem}): correct it") from None


class _UniqueKeys(yaml.SafeLoader):
    """A loader that refuses the same key twice, which YAML readers otherwise pass over."""


def _mapping(loader: yaml.SafeLoader, node: yaml.MappingNode) -> dict:
    seen = set()
    for key_node, _ in node.value:
        if key_node.tag == "tag:yaml.org,2002:merge":
            continue
        if not isinstance(key_node, yaml.ScalarNode):
            raise yaml.constructor.ConstructorError(
                None, None, "a key that is not a word", key_node.start_mark
            )
        key = loader.construct_object(key_node, deep=True)
        if key in seen:
            raise yaml.constructor.ConstructorError(
                None, None, f"the key {key!r} stands twice", key_node.start_mark
            )
        seen.add(key)
    loader.flatten_mapping(node)
    return loader.construct_mapping(node, deep=True)


_UniqueKeys.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)


def check_against_schema(content: dict, schema_path: str | Path, name: str) -> None:
    """Raise one sentence for the first thing in ``content`` that the closed schema refuses."""
    _refuse_not_finite(content, name, "")
    schema = yaml.safe_load(Path(schema_path).read_text(encoding="utf-8"))
    errors = list(jsonschema.Draft202012Validator(schema).iter_errors(content))
    # a misspelt key is also a missing one: report the key that is present
    errors.sort(key=lambda e: (e.validator != "additionalProperties", list(map(str, e.path))))
    if errors:
        raise InputError(f"{name}: {_sentence(errors[0], schema)}")


def _refuse_not_finite(content, name: str, where: str) -> None:
    if isinstance(content, float) and not math.isfinite(content):
        raise InputError(f"{name}: expected a finite number for {where!r}, found {content}: correct it")
    if isinstance(content, dict | list):
        items = content.items() if isinstance(content, dict) else enumerate(content)
        for key, value in items:
            _refuse_not_finite(value, name, f"{where}.{key}" if where else str(key))


def _sentence(error: jsonschema.ValidationError, schema: dict) -> str:
    where = ".".join(map(str, error.path))
    found = f"found {quoted(error.instance)}"
    if error.validator == "additionalProperties":
        known = list(error.schema.get("properties", {}))
        unknown = next(key for key in error.instance if key not in known)
        key = f"{where}.{unknown}" if where else str(unknown)
        close = difflib.get_close_matches(str(unknown), known, n=1, cutoff=0.5)
        everywhere = _all_keys(schema)
        elsewhere = [path for path in everywhere if path.rpartition(".")[2] == str(unknown)]
        if elsewhere:
            hint = f"did you mean {' or '.join(map(repr, elsewhere))}?"
        elif close:
            hint = f"did you mean {close[0]!r}?"
        else:
            hint = f"known here: {', '.join(known)}"
        return f"unknown key {key!r}: {hint}"
    if error.validator == "required":
        missing = next(key for key in error.validator_value if key not in error.instance)
        key = f"{where}.{missing}" if where else missing
        return f"expected the key {key!r}, found none: add it (config/README.md describes it)"
    expected = {
        "type": lambda: f"a value of type {_or(error.validator_value)}",
        "enum": lambda: f"one of {', '.join(map(repr, error.validator_value))}",
        "exclusiveMinimum": lambda: f"a number above {error.validator_value}",
        "exclusiveMaximum": lambda: f"a number below {error.validator_value}",
        "minimum": lambda: f"a number of at least {error.validator_value}",
        "maximum": lambda: f"a number of at most {error.validator_value}",
        "minProperties": lambda: f"at least {error.validator_value} entry",
        "minItems": lambda: f"at least {error.validator_value} items",
        "maxItems": lambda: f"at most {error.validator_value} items",
    }.get(error.validator, lambda: error.message)()
    return f"expected {expected} for {where!r}, {found}: correct it"


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


def check_config(config: dict, name: str) -> None:
    """Conditions beyond the schema: references between names, and order of values."""
    dummy, wristalyzer = config["dummy"], config["wristalyzer"]
    for key in ("as_printed", "recommended"):
        if dummy[key] not in dummy["pathways"]:
            close = difflib.get_close_matches(dummy[key], dummy["pathways"], n=1)
            hint = f": did you mean {close[0]!r}?" if close else ""
            raise InputError(
                f"{name}: expected dummy.{key} to name one of dummy.pathways "
                f"({', '.join(dummy['pathways'])}), found {dummy[key]!r}{hint or ': correct it'}"
            )
    labels = [marker["label"] for marker in dummy["geometry"]["leg_markers"]]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise InputError(
            f"{name}: expected dummy.geometry.leg_markers to place every marker once, found {twice[0]!r} "
            "twice: correct one of the two"
        )
    unknown = sorted(set(labels) - set(dummy["files"]["marker_labels"]))
    if unknown:
        raise InputError(
            f"{name}: expected dummy.geometry.leg_markers to name markers of "
            f"dummy.files.marker_labels, found {unknown[0]!r}: correct one of the two"
        )
    _check_output_error(dummy, name)
    _check_specification(dummy, name)
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
    if config["noise"]["table_snr_db"] not in config["noise"]["snr_db"]:
        raise InputError(
            f"{name}: expected noise.table_snr_db to be one of noise.snr_db ({config['noise']['snr_db']}), "
            f"found {config['noise']['table_snr_db']}: correct one of the two"
        )
    _check_reflex(config["position_manipulator"]["analysis"]["parallel_cascade"], name)
    _check_standing(config["standing"], config["weight"]["models"]["family"], name)
    for section in ("wristalyzer", "dummy", "position_manipulator", "standing"):
        half = 0.5 * config[section]["ingest"]["resample_rate_hz"]
        cutoff = config[section]["analysis"]["lowpass_cutoff_hz"]
        if cutoff >= half:
            raise InputError(
                f"{name}: expected {section}.analysis.lowpass_cutoff_hz below half of "
                f"{section}.ingest.resample_rate_hz ({half:g} Hz), found {cutoff:g}: lower it"
            )


def _check_output_error(dummy: dict, name: str) -> None:
    """Output error needs the foot's markers, uses the torque for its VAF only, and has no SEM as printed."""
    for pathway, choice in dummy["pathways"].items():
        if choice["estimator"] != "output-error":
            continue
        if choice["torque"] != "leg":
            raise InputError(
                f"{name}: expected the torque leg in dummy.pathways.{pathway}, because the estimator "
                f"output-error does not use a torque, found {choice['torque']!r}: correct one of the two"
            )
        for key in ("as_printed", "recommended"):
            if dummy[key] == pathway:
                raise InputError(
                    f"{name}: expected dummy.{key} to name a pathway with windowed least squares, because "
                    f"tables and figures show every perturbation, found {pathway!r}: name another"
                )
        unknown = sorted(set(dummy["foot"]["belt_fixed_labels"]) - set(dummy["files"]["marker_labels"]))
        if unknown:
            raise InputError(
                f"{name}: expected dummy.foot.belt_fixed_labels to name markers of "
                f"dummy.files.marker_labels, found {unknown[0]!r}: correct one of the two"
            )


def _check_specification(dummy: dict, name: str) -> None:
    """The cutoff of the alternative filter must differ from the study's and be below half of the rate."""
    tried, cutoff = dummy["specification"]["other_cutoff_hz"], dummy["analysis"]["lowpass_cutoff_hz"]
    half = 0.5 * dummy["ingest"]["resample_rate_hz"]
    if tried == cutoff or tried >= half:
        raise InputError(
            f"{name}: expected dummy.specification.other_cutoff_hz below half of "
            f"dummy.ingest.resample_rate_hz ({half:g} Hz) and not that of dummy.analysis.lowpass_cutoff_hz "
            f"({cutoff:g} Hz), found {tried:g}: correct it"
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
    if reflex["reflex_length_s"] < 2.0 * reflex["reflex_knot_s"]:
        raise InputError(
            f"{where}.reflex_knot_s of at most half of reflex_length_s ({reflex['reflex_length_s']:g} s), "
            f"found {reflex['reflex_knot_s']:g} s: correct one of the two"
        )


def _check_treadmill(config: dict, name: str) -> None:
    """Models that are named must be in the family, families must suit the experiment, filters the rate."""
    plate, table = config["weight"], config["belt"]
    for pathway, choice in config["dummy"]["foot"]["pathways"].items():
        model = choice["treadmill_model"]
        if model is not None and model not in plate["models"]["family"]:
            raise InputError(
                f"{name}: expected dummy.foot.pathways.{pathway}.treadmill_model to name one of "
                f"weight.models.family ({', '.join(plate['models']['family'])}) or null, found {model!r}: "
                "correct one of the two"
            )
    if table["chosen"] not in table["models"]["family"]:
        raise InputError(
            f"{name}: expected belt.chosen to name one of belt.models.family "
            f"({', '.join(table['models']['family'])}), found {table['chosen']!r}: correct one of the two"
        )
    for section, unsuited, why in (
        ("belt", ("mean-subtraction", "loaded-frame"), "needs an empty belt beside a weight"),
        ("weight", ("ripple-tracking",), "needs a belt that travels"),
    ):
        for model in unsuited:
            if model in config[section]["models"]["family"]:
                raise InputError(
                    f"{name}: expected models in {section}.models.family that suit this experiment, found "
                    f"{model!r}, which {why}: take it out"
                )
    half = 0.5 * plate["ingest"]["resample_rate_hz"]
    for cutoff in plate["analysis"]["cutoffs_hz"]:
        if cutoff >= half:
            raise InputError(
                f"{name}: expected weight.analysis.cutoffs_hz below half of weight.ingest.resample_rate_hz "
                f"({half:g} Hz), found {cutoff:g}: lower it"
            )
    analysis = table["analysis"]
    if analysis["zero_lag"] and analysis["lowpass_order"] % 2:
        raise InputError(
            f"{name}: expected an even belt.analysis.lowpass_order, because the filter is "
            f"zero-lag (two passes), found {analysis['lowpass_order']}: correct one of the two"
        )


def _check_standing(standing: dict, family: list[str], name: str) -> None:
    """Pathways, estimators, models, markers and windows that are named must exist, and windows must fit."""
    recommended = standing["recommended"]
    for key, wanted, known in (
        ("as_printed", standing["as_printed"], standing["pathways"]),
        ("recommended.pathway", recommended["pathway"], standing["pathways"]),
        ("recommended.estimator", recommended["estimator"], standing["estimators"]),
    ):
        if wanted not in known:
            section = "estimators" if key.endswith("estimator") else "pathways"
            raise InputError(
                f"{name}: expected standing.{key} to name one of standing.{section} ({', '.join(known)}), "
                f"found {wanted!r}: correct it"
            )
    for pathway, choice in standing["pathways"].items():
        model = choice["treadmill_model"]
        if model is not None and model not in family:
            raise InputError(
                f"{name}: expected standing.pathways.{pathway}.treadmill_model to name one of "
                f"weight.models.family ({', '.join(family)}) or null, found {model!r}: correct one of the two"
            )
    for segment in ("foot", "shank", "thigh"):
        for marker in standing["person"][f"{segment}_markers"]:
            if marker["label"] not in standing["files"]["marker_labels"]:
                raise InputError(
                    f"{name}: expected standing.person.{segment}_markers to name markers of "
                    f"standing.files.marker_labels, found {marker['label']!r}: correct one of the two"
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
    half = 0.5 * standing["ingest"]["resample_rate_hz"]
    if analysis["stretch_cutoff_hz"] >= half:
        raise InputError(
            f"{name}: expected standing.analysis.stretch_cutoff_hz below half of "
            f"standing.ingest.resample_rate_hz ({half:g} Hz), found {analysis['stretch_cutoff_hz']:g}: "
            "lower it"
        )


def check_same_processing(config: dict, carried: str, name: str) -> None:
    """Models of the treadmill hold for one rate and one filter: what is carried must have the weight's.

    ``carried`` is dummy or standing.
    """
    rates = {key: config[key]["ingest"]["resample_rate_hz"] for key in ("weight", "empty", carried)}
    if len(set(rates.values())) > 1:
        found = ", ".join(f"{rate:g} Hz for {key}" for key, rate in rates.items())
        raise InputError(
            f"{name}: expected one ingest.resample_rate_hz for weight, empty and {carried}, because models "
            f"of the treadmill hold for one rate, found {found}: make them equal"
        )
    weight, own = config["weight"]["analysis"], config[carried]["analysis"]
    of_weight = (weight["cutoffs_hz"][0], weight["lowpass_order"])
    of_own = (own["lowpass_cutoff_hz"], own["lowpass_order"])
    if of_weight != of_own:
        raise InputError(
            f"{name}: expected the {carried}'s filter to be the weight's first one, because models of the "
            f"treadmill hold for one filter, found {of_own[0]:g} Hz of order {of_own[1]} and "
            f"{of_weight[0]:g} Hz of order {of_weight[1]}: make {carried}.analysis and weight.analysis agree"
        )


def check_same_belt(config: dict, carried: str, name: str) -> None:
    """Models hold for the belt that carried the weight: dummy or person (``carried``) must be on it."""
    own = config["dummy"]["foot"]["belt"] if carried == "dummy" else config["standing"]["belt"]
    if own != config["weight"]["belt"]:
        key = "dummy.foot.belt" if carried == "dummy" else "standing.belt"
        raise InputError(
            f"{name}: expected {key} to be weight.belt ({config['weight']['belt']}), because models of the "
            f"treadmill are those of one belt, found {own}: correct one of the two"
        )


def check_plate_models(config: dict, name: str) -> None:
    """Treadmill models of a standing person's pathways need trials with the weight and the empty belt."""
    for pathway, choice in config["standing"]["pathways"].items():
        if choice["treadmill_model"] is not None:
            raise InputError(
                f"{name}: expected trials of weight and empty beside those of standing, because "
                f"standing.pathways.{pathway} takes the model {choice['treadmill_model']!r} of the "
                "treadmill, found none: add their rows to the trial sheet, or set its treadmill_model to null"
            )
