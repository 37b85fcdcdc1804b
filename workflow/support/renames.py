"""Former names and places of keys, values and experiments, for messages about old configurations.

The table is consulted only where a name is refused: an unknown key, an unexpected value, or a name that is
looked up and not found. A pathway of your own may have any name.
"""

# sections and keys of all files, and experiments of the trial sheet
KEYS = {
    "pilot": "standing",
    "ankle": "position_manipulator",
    "treadmill": "belt",
    "across_m": "anterior_offset_m",
    "along_m": "longitudinal_offset_m",
    "riding_labels": "belt_fixed_labels",
    "strober_frequency_hz": "marker_sampling_hz",
    "strober_hz": "marker_sampling_hz",
    "bidirectional": "zero_lag",
    "published_evaluations": "hnat2014_evaluations",
    "intrinsic_reflex": "parallel_cascade",
    "judged": "also_evaluated",
    "occlusion_frames": "occlusion_s",
}
# names of the dummy's pathways whose meaning changed: markers as sampled are the thesis's own
PATHWAYS = {
    "leg-printed": "leg-thesis-aligned",
    "leg-printed-as-strobed": "leg-thesis",
    "leg-thesis-as-sampled": "leg-thesis",
}
# estimators, torques, models, other pathways and other values
VALUES = {
    "leg-printed": "leg-thesis",
    "foot-printed": "foot-thesis",
    "ankle-printed": "ankle-thesis",
    "as-strobed": "as-sampled",
    "segment-regression": "windowed-least-squares",
    "segment-regression-printed": "windowed-least-squares-thesis",
    "reflex-free": "pre-reflex-window",
    "published": "hnat2014",
}
# keys of the configuration that moved, in sections under their present names
MOVED = {
    "dummy.ingest.resample_rate_hz": "plate_treadmill.resample_rate_hz",
    "dummy.analysis.lowpass_cutoff_hz": "plate_treadmill.lowpass_cutoff_hz",
    "dummy.analysis.lowpass_order": "plate_treadmill.lowpass_order",
    "dummy.foot.belt": "plate_treadmill.belt",
    "weight.ingest.resample_rate_hz": "plate_treadmill.resample_rate_hz",
    "weight.analysis.cutoffs_hz": (
        "plate_treadmill.lowpass_cutoff_hz, all but the first to weight.analysis.other_cutoffs_hz"
    ),
    "weight.analysis.lowpass_order": "plate_treadmill.lowpass_order",
    "weight.belt": "plate_treadmill.belt",
    "empty.ingest.resample_rate_hz": "plate_treadmill.resample_rate_hz",
    "standing.ingest.resample_rate_hz": "plate_treadmill.resample_rate_hz",
    "standing.analysis.lowpass_cutoff_hz": "plate_treadmill.lowpass_cutoff_hz",
    "standing.analysis.lowpass_order": "plate_treadmill.lowpass_order",
    "standing.belt": "plate_treadmill.belt",
}
# keys of the configuration that did nothing, or do nothing any more
REMOVED = {
    "empty.ingest.max_gap_s": "the empty belt has no markers",
    "empty.ingest.marker_sampling_hz": "the empty belt has no markers",
    "empty.ingest.strober_frequency_hz": "the empty belt has no markers",
    "weight.models.ripple": "no ripple is tracked under the weight",
    "weight.analysis.bootstrap_draws": "the interval of the mass is Student's, with Type B",
}


def answer_for_key(path: str, known: list[str], everywhere: list[str]) -> str | None:
    """Hint for an unknown key that was renamed, moved or removed, or None.

    ``path`` has the sections around the key, dots in between; ``known`` are the keys that are known in its
    place, ``everywhere`` the paths of all keys of the file.
    """
    if path in MOVED and MOVED[path].partition(",")[0] in everywhere:
        return f"moved to {MOVED[path]}"
    if path in REMOVED:
        return f"no longer needed, because {REMOVED[path]}: remove it"
    return renamed(KEYS, path.rpartition(".")[2], known)


def moved_from(section: str) -> dict[str, str]:
    """Name -> present path of the former keys of a section."""
    return {
        old.rpartition(".")[2]: new.partition(",")[0]
        for old, new in MOVED.items()
        if old.rpartition(".")[0] == section
    }


def renamed(table: dict[str, str], name: object, known) -> str | None:
    """Hint with the present name of an old one, if that is known; else None."""
    new = table.get(name) if isinstance(name, str) else None
    return f"renamed to {new!r}" if new is not None and new in known else None
