"""Settings of the trials on an instrumented treadmill, as far as their files provide them.

The forward direction follows from the feet or the belt, and the belts from the places of the plates.
"""

import re
from collections.abc import Sequence

import numpy as np

from tepsipe.errors import listed
from tepsipe.io.readers.recording import DIRECTIONS
from tepsipe.new_study.measures import Pulses, pulses_of, rests
from tepsipe.new_study.pairing import Group
from tepsipe.new_study.plan import PLACEHOLDER, Missing, Plan
from tepsipe.new_study.treadmill_trials import (
    AGREES,
    KNEE,
    Seen,
    is_on,
    leg_of,
    muscles_of,
    of_leg,
    plain,
    usual_belt,
)

PERSON_N, WEIGHT_N, LOAD_N = 350.0, 100.0, 10.0
LONGEST_GAP_S = 0.1
EMG_BAND_HZ = (20.0, 300.0)  # of the shipped configuration
# cutoffs of the shipped configuration that cameras of 100 Hz are too slow for
CUTOFFS_HZ = {"standing.analysis.stretch_cutoff_hz": 60.0, "standing.free_reflex.lowpass_cutoff_hz": 60.0}
CAMERAS = re.compile(r"vicon|qualisys|motion analysis|optitrack|natural ?point|oqus|simi|bts", re.IGNORECASE)
MANY_MARKERS = 12
# pathways of the shipped configuration with windows of this length (s) from the onset of every pulse
LONG_WINDOWS, LONG_S = ("foot-long", "foot-compensated"), 2.0
REST_MARGIN_S = 0.5  # of the shipped configuration: what it leaves out of a rest
ONSET_S = 0.02  # by how much a detected onset may differ from its schedule
LOW = "low markers that move together"
TOES, HEELS = r"toe|fm\d|mt\d", r"hee|fcc|calc"
CARRIED_N = 50.0  # load of a belt that carries something
BOTH = 0.2  # load of the other belt, as a share, from which a foot stands on it
BELTS = ("left", "right")
ON_PLATES = ("dummy", "weight", "empty", "standing")
ALONG = 0.8  # least component of a foot along an axis of the file that it shows


def experiment_of(group: Group, seen: Seen, named: str | None) -> str:
    """Experiment of a treadmill trial by the name of its files or folders, then by load and channels."""
    load = abs(seen.load_N)
    if seen.emg:
        shown, why = "standing", f"{len(seen.emg)} electromyograms"
    elif load > PERSON_N or len(seen.markers) > MANY_MARKERS:
        shown, why = "standing", f"{load:.0f} N on the plate, {len(seen.markers)} markers"
    elif load > WEIGHT_N:
        shown, why = "weight", f"{load:.0f} N on the plate"
    elif seen.markers:
        shown, why = "dummy", f"markers, and {load:.0f} N on the plate"
    else:
        shown, why = "empty", f"no markers, and {load:.0f} N on the plate"
    if named is None:
        group.notes.append(f"taken for {shown} by its content: {why}")
        return shown
    if named != shown and not (load < WEIGHT_N and named in ("dummy", "empty", "weight")):
        group.notes.append(f"taken for {named} by its name, its content ({why}) looks like {shown}")
    return named


def plan_treadmill(plan: Plan, trials: list[tuple[Group, Seen]]) -> None:
    """Add the settings that all treadmill trials share, and those of each experiment."""
    every = [seen for _, seen in trials]
    rates = sorted({s.frame_rate_hz for s in every if s.frame_rate_hz})
    whole = [(g, s) for g, s in trials if g.first.kind == "whole trial"]
    if whole:
        _plan_recording(plan, whole)
        _plan_other_markers(plan, whole)
    else:
        loads = {b: max(abs(s.loads_N.get(b, 0.0)) for s in every) for b in BELTS}
        belt = max(loads, key=loads.get)
        if loads[belt] > LOAD_N:
            plan.put("plate_treadmill.belt", belt, f"it carries up to {loads[belt]:.0f} N, by the logs")
        else:
            plan.assume("plate_treadmill.belt", "right", "no belt carries a load", "belt that is perturbed")
    if rates:
        plan.put("plate_treadmill.resample_rate_hz", rates[0], "rate of the markers")
        for key, shipped_hz in CUTOFFS_HZ.items():
            if 2.0 * shipped_hz >= rates[0]:
                plan.put(key, float(f"{0.4 * rates[0]:.3g}"), "below half of that rate")
    for experiment, add in (("dummy", _plan_dummy), ("weight", _plan_weight), ("standing", _plan_standing)):
        of_experiment = [(g, s) for g, s in trials if g.experiment == experiment]
        if of_experiment:
            add(plan, of_experiment, {g.experiment for g, _ in trials})
    if any(g.experiment == "empty" for g, _ in trials) and not any(
        g.experiment == "weight" for g, _ in trials
    ):
        _plan_window(plan, "weight.analysis.window", [t for t in trials if t[0].experiment == "empty"])


# ---- one file that holds all ---------------------------------------------------------------------


def _plan_recording(plan: Plan, whole: list[tuple[Group, Seen]]) -> None:
    """Plates, channels and axes of the files."""
    key, group, seen = "plate_treadmill.recording", *whole[0]
    name = group.first.name
    forward, how = forward_of([s for _, s in whole])
    plan.assume(f"{key}.axes.forward", forward, how, "direction to which the person or dummy faces")
    plan.put(f"{key}.axes.up", seen.up, "by the plates, the markers and the screen of the file")
    loads = {number: max((s.loads_N.get(number, 0.0) for _, s in whole), key=abs) for number in seen.loads_N}
    chosen = plates_of_belts([s for _, s in whole], forward)
    if len(chosen) == 2:
        left, right = chosen
        plan.put(f"{key}.plates.left", [int(left)], f"mean vertical force up to {loads[left]:.0f} N")
        plan.put(f"{key}.plates.right", [int(right)], f"mean vertical force up to {loads[right]:.0f} N")
        belt = "left" if abs(loads[left]) > abs(loads[right]) else "right"
        plan.assume("plate_treadmill.belt", belt, "it carries more load", "belt that is perturbed")
    elif chosen:
        plan.put(f"{key}.plates.left", [], "one plate")
        plan.put(f"{key}.plates.right", [int(chosen[0])], f"the only plate of {name}")
        plan.put("plate_treadmill.belt", "right", "the only plate is called right")
    if min(loads.values(), default=0.0) < -LOAD_N:
        plan.put(f"{key}.force_sign", -1, "vertical forces are negative under load")
    _plan_belt_velocity(plan, key, whole, 1.0 if forward[0] == "+" else -1.0)
    triggers = [t for _, s in whole for t in s.triggers]
    if triggers:
        plan.put(
            f"{key}.trigger", None, f"{triggers[0]} looks like a trigger; null: the first frame is time 0"
        )


def _plan_belt_velocity(plan: Plan, key: str, whole: list[tuple[Group, Seen]], sign: float) -> None:
    """Channel of the belt velocity with its scale (m/s per unit), turned by ``sign``, or markers."""
    group, seen = whole[0]
    name = group.first.name
    b = usual_belt(s for _, s in whole)
    if b is not None:
        note = f"channel of {name}"
        if np.isfinite(b.correlation):
            note += f" that follows a low marker with r = {abs(b.correlation):.3f}"
        scale = f"from {b.name} in {b.unit or 'its unit'} against the markers"
        if "record" in group.partners:
            note = f"column of {group.partners['record'].name}"
            scale = "D-Flow's belt speeds are positive backward"
        plan.put(f"{key}.belt_velocity.channel", b.name, note)
        plan.assume(
            f"{key}.belt_velocity.m_per_s_per_unit",
            _rounded(sign * b.m_per_s_per_unit),
            scale,
            "factor of the amplifier",
        )
        plan.put(f"{key}.belt_velocity.offset", float(f"{b.offset:.4g}"), "value of the channel at rest")
        belts = [(g.first.name, s.belt) for g, s in whole if s.belt is not None]
        unlike = [file for file, x in belts if abs(x.m_per_s_per_unit / b.m_per_s_per_unit - 1.0) > AGREES]
        if unlike:
            meaning = f"this scale was assumed for {listed(unlike, 4)}, too, whose markers deny it"
            how = "correct sign or scale in these files, or make a study of its own of these trials"
            plan.check.append(Missing(f"{key}.belt_velocity.m_per_s_per_unit", meaning, how))
        if "record" in group.partners and seen.belt_fixed:
            plan.assume(f"{key}.belt_velocity.markers", seen.belt_fixed[:3], LOW, "belt-fixed markers")
    else:
        labels = [s.belt_fixed for _, s in whole if s.belt_fixed]
        plan.put(f"{key}.belt_velocity.channel", None, f"no channel of {name} follows the belt")
        if labels:
            plan.assume(f"{key}.belt_velocity.markers", labels[0][:3], LOW, "belt-fixed markers")
        else:
            plan.ask(
                f"{key}.belt_velocity.markers",
                "labels of belt-fixed markers",
                "name markers on the belt or the foot",
            )


def _plan_other_markers(plan: Plan, whole: list[tuple[Group, Seen]]) -> None:
    """Belt-fixed markers of experiments whose trials do not have those of the belt's velocity."""
    usual = plan.tree["plate_treadmill"]["recording"]["belt_velocity"]
    shared = usual["markers"].value if "markers" in usual else []
    for experiment in dict.fromkeys(g.experiment for g, _ in whole):
        own = [s for g, s in whole if g.experiment == experiment and s.belt_fixed]
        if not isinstance(shared, list) or not own or all(set(shared) <= set(s.markers) for s in own):
            continue
        labels = [m for m in own[0].belt_fixed if all(m in s.belt_fixed for s in own)][:3]
        key = f"plate_treadmill.exceptions.{experiment}.recording.belt_velocity"
        values = {name: setting.value for name, setting in usual.items()}
        for name, value in ({"channel": None, "m_per_s_per_unit": None, "offset": 0.0} | values).items():
            plan.put(f"{key}.{name}", value, "as for the others")
        plan.assume(f"{key}.markers", labels, LOW, "belt-fixed markers")


def _rounded(scale: float) -> float:
    """A factor to two digits if it differs from them by less than half a percent, else to four."""
    two = float(f"{scale:.2g}")
    return two if abs(two - scale) < 0.005 * abs(scale) else float(f"{scale:.4g}")


# ---- experiments ---------------------------------------------------------------------------------


def _state_uncertainty(plan: Plan, experiment: str) -> None:
    """Ask for Type B of the intervals, because the defaults belong to another rig."""
    plan.check.append(
        Missing(
            f"uncertainty.{experiment}",
            "the defaults were assumed: those of the simulated laboratory",
            "state how well you know masses, lengths, calibrations and delays (docs/uncertainty.md)",
        )
    )


def _plan_dummy(plan: Plan, trials: list[tuple[Group, Seen]], _: set[str]) -> None:
    seen = trials[0][1]
    _plan_markers(plan, "dummy", trials)
    _plan_window(plan, "dummy.analysis", trials)
    fixed = [m for m in seen.belt_fixed if m in _visible(trials)]
    ankle = next((m for m in _visible(trials) if is_on("ankle", m)), None)
    ask = plan.ask
    key = "dummy.geometry"
    ask(f"{key}.leg_mass_kg", "mass of the leg (kg)", "weigh the leg without the foot")
    ask(
        f"{key}.leg_com_m",
        "distance of the leg's centre of mass from the ankle (m)",
        "balance the leg on an edge",
    )
    ask(
        f"{key}.leg_inertia_kgm2",
        "moment of inertia of the leg about its centre of mass (kg·m²)",
        "swing it as a pendulum about the ankle: T² m g d / (4 π²) - m d²",
    )
    ask(f"{key}.foot_mass_kg", "mass of the foot (kg)", "weigh it")
    ask(f"{key}.foot_height_m", "height of the ankle above the belt (m)", "measure it with a ruler")
    free_s = _shortest_s(trials) - ONSET_S
    for pathway in LONG_WINDOWS if free_s < LONG_S else ():
        window_s = max(0.1, float(np.floor(10.0 * free_s) / 10.0))
        plan.put(f"dummy.foot.pathways.{pathway}.window_s", window_s, "no longer than from pulse to pulse")
    leg = [m for m in _visible(trials) if m == ankle or not (m in fixed or is_on("foot", m))]
    _plan_segment(plan, f"{key}.leg_markers", leg, ankle, trials, "the axis of the leg")
    if ankle is not None:
        plan.put("dummy.foot.ankle_label", ankle, "by its name")
    elif fixed:
        plan.assume("dummy.foot.ankle_label", fixed[-1], "no marker is called ankle", "marker on the ankle")
    if fixed:
        plan.put("dummy.foot.belt_fixed_labels", fixed, "they follow the belt")
    else:
        ask(
            "dummy.foot.belt_fixed_labels", "labels of the belt-fixed markers", "name the markers on the foot"
        )
    _state_uncertainty(plan, "dummy")


def _plan_weight(plan: Plan, trials: list[tuple[Group, Seen]], _: set[str]) -> None:
    _plan_markers(plan, "weight", trials)
    _plan_window(plan, "weight.analysis.window", trials)
    _state_uncertainty(plan, "weight")


def _plan_standing(plan: Plan, trials: list[tuple[Group, Seen]], experiments: set[str]) -> None:
    _state_uncertainty(plan, "standing")
    labels = next((s.emg for _, s in trials if s.emg), [])
    leg, why = leg_of(labels, trials[0][1].markers)
    plan.check.append(Missing("standing", f"the {leg} leg was assumed: {why}", "labels of the other one"))
    _plan_segments(plan, trials, leg)
    _plan_window(plan, "standing.analysis.window", trials)
    load = max((abs(s.load_N) for _, s in trials), default=0.0)
    key = "standing.person"
    plan.ask(
        f"{key}.mass_kg",
        "mass of the person (kg)",
        "weigh the person; the plate must agree within 15 %",
        f"the plates show {load / 9.81:.1f} kg",
    )
    plan.ask(f"{key}.stature_m", "stature (m)", "measure it")
    plan.ask(
        f"{key}.com_height",
        "height of the body's centre of mass as a fraction of the stature (–)",
        "0.55 for women, 0.56 for men",
    )
    plan.ask(
        f"{key}.ankle_height_m", "height of the outer ankle bone above the sole (m)", "measure it carefully"
    )
    plan.ask(
        f"{key}.foot_com_m",
        "anterior offset of the feet's centre of mass from the ankle (m)",
        "half the distance from the ankle to the ball of the foot",
    )
    muscles, others = muscles_of(labels, leg)
    for muscle, label in muscles.items():
        plan.put(f"standing.muscles.{muscle}.channel", label, "by its name")
    if others and labels:
        plan.check.append(
            Missing("standing.muscles", f"not taken for a muscle: {', '.join(others)}", "add them")
        )
    rate = min((s.emg_rate_hz for _, s in trials if s.emg_rate_hz), default=np.inf)
    if 0.5 * rate <= EMG_BAND_HZ[1]:
        band = [EMG_BAND_HZ[0], float(f"{0.45 * rate:.3g}")]
        plan.put("standing.emg.band_hz", band, f"below half of the {rate:g} Hz of the electromyograms")
    trigger = next((s.emg_trigger for _, s in trials if s.emg_trigger), None)
    if trigger:
        plan.put("standing.files.emg_trigger", trigger[0], "two levels, by its name")
        plan.put("standing.files.emg_trigger_threshold", float(f"{trigger[1]:.4g}"), "half way between them")
    elif any("emg" in g.partners for g, _ in trials):
        plan.ask(
            "standing.files.emg_trigger",
            "label of the trigger in the file of electromyograms",
            "name the channel of the trigger line; null if the trigger started the recorder",
        )
    if not {"weight", "empty"} <= experiments:
        plan.put(
            "standing.pathways.ankle-compensated.treadmill_model", None, "no trials of weight and empty belt"
        )
        plan.put("standing.recommended.pathway", "ankle", "the belt-induced load is not compensated")


def _plan_segments(plan: Plan, trials: list[tuple[Group, Seen]], leg: str) -> None:
    """Markers of the foot, the shank and the thigh of one leg."""
    seen = trials[0][1]
    visible = _visible(trials)
    one_side = of_leg(visible, leg)
    ankle = next((m for m in one_side if is_on("ankle", m)), None)
    knee = next((m for m in one_side if re.search(KNEE, plain(m), re.IGNORECASE)), None)
    used = []
    for segment, axis in (
        ("foot", "the ankle"),
        ("shank", "the line from ankle to knee"),
        ("thigh", "the line from knee to hip"),
    ):
        reference = ankle if segment != "thigh" else knee
        labels = [m for m in one_side if is_on(segment, m) or m == reference]
        used += labels
        _plan_segment(plan, f"standing.person.{segment}_markers", labels, reference, trials, axis)
    keep = (
        [m for m in visible if m in used or m in seen.belt_fixed] if len(visible) > MANY_MARKERS else visible
    )
    _plan_markers(plan, "standing", trials, keep)


def _visible(trials: list[tuple[Group, Seen]]) -> list[str]:
    """Markers that no trial hides for longer than `LONGEST_GAP_S`, in the order of the file."""
    first = trials[0][1].markers
    kept = [m for m in first if all(s.longest_gap_s.get(m, np.inf) <= LONGEST_GAP_S for _, s in trials)]
    return list(dict.fromkeys(kept))


def _plan_markers(plan: Plan, experiment: str, trials: list[tuple[Group, Seen]], labels=None) -> None:
    """Labels of the markers, and how they are sampled."""
    name = trials[0][0].partners.get("markers", trials[0][0].first).name
    seen = trials[0][1]
    labels = _visible(trials) if labels is None else labels
    hidden = len(seen.markers) - len(_visible(trials))
    note = f"found in {name}" + (f"; {hidden} are hidden for more than {LONGEST_GAP_S} s" if hidden else "")
    if labels:
        plan.put(f"{experiment}.files.marker_labels", labels, note)
    else:
        plan.ask(
            f"{experiment}.files.marker_labels", "labels of the markers, a list", "see tepsipe info", note
        )
    key = f"{experiment}.ingest.marker_sampling_hz"
    if CAMERAS.search(seen.maker):
        plan.put(key, None, f"cameras sample all markers at once ({seen.maker})")
    else:
        plan.ask(
            key,
            "rate of sequential marker sampling within a frame (Hz)",
            "null for cameras; for an Optotrak the rate of its strober, and marker_labels in its order",
        )


def _plan_segment(plan: Plan, key: str, labels: list[str], joint: str | None, trials, axis: str) -> None:
    """Offsets of the markers of a segment: placeholders, with the position of each marker at rest."""
    if len(labels) < 2:
        plan.ask(
            key,
            "markers of this segment and their offsets, a list of at least two",
            "as in docs/recordings: {label: ..., anterior_offset_m: ..., longitudinal_offset_m: ...}, of the "
            "markers that files.marker_labels lists",
        )
        return
    items = []
    for label in labels:
        offsets = 0.0 if label == joint else PLACEHOLDER
        note = "on the joint" if label == joint else _place(label, joint, trials)
        items.append(({"label": label, "anterior_offset_m": offsets, "longitudinal_offset_m": offsets}, note))
    plan.put(key, items)
    plan.missing.append(
        Missing(
            key,
            f"place of each marker (m): anterior_offset_m from {axis}, longitudinal_offset_m along it",
            "with a ruler, or on a photograph from the side; heights of markers on heel and toe to 1 mm; "
            "take out markers that are not on it",
        )
    )


def _place(label: str, joint: str | None, trials) -> str:
    """Position of a marker before the first pulse, from the marker on the joint if there is one."""
    seen = trials[0][1]
    pulses = _pulses(seen)
    stop = None if pulses is None else max(1, int(pulses.first_s * seen.frame_rate_hz))
    when = "on average" if pulses is None else "at rest"

    def place(name: str) -> np.ndarray | None:
        places = seen.positions[:stop, seen.markers.index(name)]
        places = places[np.isfinite(places).all(axis=1)]
        return np.median(places, axis=0) if len(places) else None

    at = place(label)
    if at is None:
        return "hidden at rest"
    centre = None if joint is None else place(joint)
    if centre is None:
        return f"{when} {at @ DIRECTIONS[seen.up]:.3f} m high"
    along, up = (at - centre)[seen.forward], (at - centre) @ DIRECTIONS[seen.up]
    return f"{when} {along:+.3f} m along {'xyz'[seen.forward]} and {up:+.3f} m up from {joint}"


def _pulses(seen: Seen) -> Pulses | None:
    return None if seen.velocity is None else pulses_of(seen.velocity, seen.velocity_rate_hz)


def _shortest_s(trials: list[tuple[Group, Seen]]) -> float:
    """Shortest time from the onset of a pulse to the next, or to the end of the trial (s)."""
    found = [(pulses, s) for _, s in trials if (pulses := _pulses(s)) is not None]
    times = [x for p, s in found for x in (p.shortest_s, s.duration_s - p.last_s)]
    return float(np.nanmin([np.inf, *times]))


def _plan_window(plan: Plan, key: str, trials: list[tuple[Group, Seen]]) -> None:
    """Rests before the first and after the last pulse of all trials."""
    rests_and_counts = []
    for group, seen in trials:
        pulses = _pulses(seen)
        if pulses is None:
            group.notes.append("no separate pulses of the belt found")
            plan.check.append(
                Missing(
                    f"trials.tsv, {group.experiment}/{group.condition}",
                    "no separate pulses of the belt were found in it",
                    "a trial holds pulses of the belt with rests between: if not, remove its row",
                )
            )
        else:
            rests_and_counts.append((*rests(pulses, seen.duration_s), pulses.count))
    before, after = (min((f[k] for f in rests_and_counts), default=None) for k in (0, 1))
    # of a person all time between the pulses is rest, and a margin is left out on each side of a rest
    before_s, after_s = (REST_MARGIN_S, 0.0) if key.startswith("standing.") else (2.0 * REST_MARGIN_S,) * 2
    how = "by your protocol"
    counts = " or ".join(map(str, sorted({f[2] for f in rests_and_counts})))
    if before is not None and before > before_s:
        plan.put(f"{key}.rest_before_s", before, f"{counts} pulses found; until the first")
    else:
        what = "time from the start to the first perturbation (s)"
        what += "" if before is None else f", more than {before_s:g}, found {before:g} and {counts} pulses"
        plan.ask(f"{key}.rest_before_s", what, how)
    if after is not None and after > after_s:
        plan.assume(f"{key}.rest_after_s", after, "after the decay of the last pulse", how)
    else:
        what = "unperturbed time at the end (s)"
        what += "" if after is None else f", more than {after_s:g}, found {after:g} and {counts} pulses"
        plan.ask(f"{key}.rest_after_s", what, how)


def forward_of(trials: Sequence[Seen]) -> tuple[str, str]:
    """Direction in which a person or dummy faces, in the axes of the files, and why.

    The feet of the first trial with toes and heels show it, whatever the order of the trials is.

    trials: at least one trial of one file.
    """
    for seen in trials:
        foot = _foot(seen)
        if foot is None:
            continue
        axis = int(np.argmax(np.abs(foot)))
        if np.abs(foot[axis]) < ALONG:
            axis = seen.forward
        sign = "+" if foot[axis] >= 0.0 else "-"
        return f"{sign}{'xyz'[axis]}", f"toes are to that side of the heels, along {'xyz'[axis]}"
    seen = next((s for s in trials if s.positions is not None), trials[0])
    axis = "xyz"[seen.forward]
    if seen.up == "+y" and axis == "z":
        return "-z", "z is backward where y is upward, as in D-Flow"
    return f"+{axis}", f"the belt moves along {axis}; no file shows to which side it is forward"


def _foot(seen: Seen) -> np.ndarray | None:
    """Horizontal unit vector from the heels to the toes, shape (3,), or None."""
    ends = [_median(seen, pattern) for pattern in (TOES, HEELS)]
    if any(end is None for end in ends):
        return None
    foot = (ends[0] - ends[1]) * (1.0 - np.abs(DIRECTIONS[seen.up]))
    length = np.linalg.norm(foot)
    return foot / length if length > 0.0 else None


def _median(seen: Seen, pattern: str) -> np.ndarray | None:
    """Median position (m) of the markers whose labels have a pattern, or None."""
    columns = [k for k, m in enumerate(seen.markers) if re.search(pattern, plain(m), re.IGNORECASE)]
    if not columns or seen.positions is None:
        return None
    places = seen.positions[:, columns].reshape(-1, 3)
    places = places[np.isfinite(places).all(axis=1)]
    return np.median(places, axis=0) if len(places) else None


def plates_of_belts(trials: Sequence[Seen], forward: str) -> list[str]:
    """Numbers of the two plates with the largest loads from left to right, or of the only one, or none.

    forward: direction in the axes of the files.
    """
    loads: dict[str, float] = {}
    for seen in trials:
        for number, load in seen.loads_N.items():
            loads[number] = max(abs(load), loads.get(number, 0.0))
    chosen = sorted(sorted(loads, key=lambda n: -loads[n])[:2], key=int)
    places = [across(trials[0], number, forward) for number in chosen]
    if len(chosen) == 2 and None not in places and places[0] > places[1]:
        chosen.reverse()
    return chosen


def belts_of(groups: Sequence[Group], seen: dict[str, Seen]) -> dict[str, str]:
    """Name of a trial's first file -> its belt: left, right or both; empty if it is the same for all.

    Loads show the belt, and names that of an empty one. A trial without its belt carries nothing, and neither
    its name nor its channel of the velocity tells which belt moves.

    seen: name of the first file -> what it shows (SI units).
    """
    belts, empty = {}, {}
    for kind in ("whole trial", "treadmill log"):
        own = [g for g in groups if g.experiment in ON_PLATES and g.first.kind == kind]
        belts |= _loaded_belts({g.first.name: seen[g.first.name] for g in own})
        empty |= {g.first.name: seen[g.first.name].belt for g in own if g.first.name not in belts}
    named = {name: _belt_named(name) for name in empty}
    carrying = set(belts.values())
    if len(carrying) < 2 and "both" not in carrying and not set(BELTS) <= set(named.values()):
        return {}
    for name, channel in empty.items():
        belt = named[name] or (None if channel is None else _belt_named(channel.name))
        belts |= {} if belt is None else {name: belt}
    return belts


def _loaded_belts(trials: dict[str, Seen]) -> dict[str, str]:
    """Name of a trial -> the belt that carries it: left, right or both."""
    every = list(trials.values())
    plates: Sequence[str] = BELTS  # of logs, whose loads are those of the belts
    if not all(set(seen.loads_N) <= set(BELTS) for seen in every):
        plates = plates_of_belts(every, forward_of(every)[0])
    belts = {}
    for name, seen in trials.items() if len(plates) == 2 else ():
        loads = np.abs([seen.loads_N.get(number, 0.0) for number in plates])
        if loads.max() > CARRIED_N:
            both = loads.min() > BOTH * loads.max()
            belts[name] = "both" if both else BELTS[int(np.argmax(loads))]
    return belts


def _belt_named(name: str) -> str | None:
    """Belt named by a file and its folders, or by a channel; None if none is."""
    words = re.split(r"[^a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower())
    return next((word for word in reversed(words) if word in BELTS), None)


def across(seen: Seen, number: str, forward: str) -> float | None:
    """Place of a force plate to the right (m), or None where the file does not give its corners."""
    centre = seen.plate_centres_m.get(number)
    return None if centre is None else float(np.cross(DIRECTIONS[forward], DIRECTIONS[seen.up]) @ centre)
