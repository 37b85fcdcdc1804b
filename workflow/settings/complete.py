"""Complete settings of each experiment, where the configuration has every value once; parts of settings."""

ON_THE_PLATE = ("dummy", "weight", "empty", "standing")


def plate_treadmill(config: dict, experiment: str) -> dict:
    """Belt, rate (Hz), filter (Hz, -) and recording of an experiment on the plate treadmill."""
    shared = {key: value for key, value in config["plate_treadmill"].items() if key != "exceptions"}
    own = config["plate_treadmill"]["exceptions"].get(experiment, {})
    return shared | own | {"recording": shared["recording"] | own.get("recording", {})}


def plate_key(config: dict, experiment: str, key: str) -> str:
    """Place of the setting in the configuration, for messages."""
    own = config["plate_treadmill"]["exceptions"].get(experiment, {})
    return f"plate_treadmill.exceptions.{experiment}.{key}" if key in own else f"plate_treadmill.{key}"


def settings_of(config: dict) -> dict:
    """A configuration with the settings of the plate treadmill in its experiments; other values are shared.

    ``ingest`` of each gets ``resample_rate_hz``; that of the empty belt gets None for settings of markers.
    Each gets ``recording``, with what differs for it. All but the empty belt get ``belt``. ``analysis`` gets
    ``lowpass_order`` and ``lowpass_cutoff_hz``; that of the weight gets ``cutoffs_hz``, the shared one first.
    """
    settings = dict(config)
    no_markers = {"max_gap_s": None, "marker_sampling_hz": None}
    for experiment in ON_THE_PLATE:
        section, plate = dict(config[experiment]), plate_treadmill(config, experiment)
        rate = {"resample_rate_hz": plate["resample_rate_hz"]}
        section["ingest"] = no_markers | section["ingest"] | rate
        section["recording"] = plate["recording"]
        settings[experiment] = section
        if experiment == "empty":
            continue
        section["belt"] = plate["belt"]
        analysis = section["analysis"] = dict(section["analysis"])
        analysis["lowpass_order"] = plate["lowpass_order"]
        if experiment == "weight":
            analysis["cutoffs_hz"] = [plate["lowpass_cutoff_hz"], *analysis.pop("other_cutoffs_hz")]
        else:
            analysis["lowpass_cutoff_hz"] = plate["lowpass_cutoff_hz"]
    return settings


def only(section: dict, *keys: str) -> dict:
    """Selected entries of a section: a rule with these parameters is not rerun for changes of the others."""
    return {key: section[key] for key in keys}


def without(section: dict, *keys: str) -> dict:
    """All of a section's entries but some."""
    return {key: value for key, value in section.items() if key not in keys}


def pick(settings: dict, *paths: str) -> dict:
    """Values at given paths (keys joined by dots), in their sections.

    A key ``*`` stands for all keys of its section. A path after ``-`` is left out of what was picked before.
    """
    picked: dict = {}
    for path in paths:
        if path.startswith("-"):
            picked = _left_out(picked, path[1:].split("."))
        else:
            _picked(settings, picked, path.split("."))
    return picked


def _picked(source: dict, target: dict, path: list[str]) -> None:
    key, *rest = path
    for name in source if key == "*" else (key,):
        if rest:
            _picked(source[name], target.setdefault(name, {}), rest)
        else:
            target[name] = source[name]


def _left_out(section: dict, path: list[str]) -> dict:
    key, *rest = path
    content = section[key]
    return section | {key: _left_out(content, rest)} if rest else without(section, key)
