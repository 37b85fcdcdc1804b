"""Conditions and numbers of the chapter on the belt-induced force, and the sentences that they choose."""

import numpy as np
import pandas as pd
import pytest
from typst_builders import chapter_words, evaluated, findings_of

from tepsipe.io.result import Result
from tepsipe.reporting.chapters import weight
from tepsipe.reporting.run import Run, report_content

SPEEDS = [0.1, 0.2, 0.3, 0.4, 0.5]
FALLING, RISING = [20.4, 20.3, 20.2, 20.1, 20.0], [20.0, 20.1, 20.2, 20.3, 20.4]
# as the standard deviation of the mass, which falls and rises again
WAVERING = [0.24, 0.10, 0.07, 0.12, 0.09]
CONDITIONS = [f"sine-{speed}" for speed in SPEEDS]
FRAME = {"empty_hz": 52.0, "loaded_hz": 48.0, "motion": [0.1, 3.0, 2.0, 0.5], "lag_s": 0.004}
FRAME |= {"friction_speed_m_per_s": 0.05, "mount_share": 0.1, "mount_time_s": 0.02}
BRISTLES = {
    "terms": ["bristles", "lever"],
    "converged": True,
    "masses_kg": [0.0, 20.0, 60.0],
    "resonance_sd_hz": [0.0, 0.2, 0.11],
}
BRISTLES |= {"resonance_hz": [1e6, 48.7, 43.9]}
OTHERS = {"made": 0, "claims": None}


def pulses(size, lag_s=0.0):
    """Trials whose force grows with the belt speed to the power of 0.5."""
    found = {}
    for condition, speed in zip(CONDITIONS, SPEEDS, strict=True):
        pulse = np.sin(np.linspace(0.0, np.pi, 21))[None]
        names = ("20 Hz/added_force", "10 Hz/added_force", "belt/added_force")
        arrays = dict.fromkeys(names, size * speed**0.5 * pulse)
        facts = {"carried_kg": 20.0, "marker_lag_s": lag_s}
        found[condition] = Result(arrays | {"20 Hz/belt_velocity": speed * pulse}, {}, facts)
    return found


def score(model, train, test, r2, converged=True, load="Fy", after=2.0):
    names = {"model": model, "train": train, "test": test, "load": load, "order": 2, "cutoff_hz": 20.0}
    numbers = {"r2": r2, "rms_before": 8.0, "rms_after": after, "r2_limit": 0.99, "unit": "N"}
    return names | numbers | {"converged": converged}


SCORES = (
    score("fir", "empty", "empty", 0.9),
    score("fir", "empty", "weight", 0.53, after=3.0),
    score("fir", "weight", "weight", 0.96, converged=False),
    score("loaded-frame", "empty+weight", "weight", 0.86),
    score("bristle-frame", "empty+weight", "weight", 0.99),
    score("loaded-frame", "empty+weight", "weight", 0.83, load="Mx"),
    score("bristle-frame", "empty+weight", "weight", 0.98, load="Mx"),
)


def run_of(
    masses=FALLING,
    spreads=FALLING,
    size=15.0,
    lag_s=0.0,
    scores=SCORES,
    frame=FRAME,
    bristles=BRISTLES,
    dummy=(),
    amplitudes=None,
    pathways=("foot", "foot-compensated"),
):
    """Run of five trials with a weight; ``dummy`` are pathway, condition, K and flags of its estimates."""
    rows = [
        {"experiment": "weight", "condition": c, "pathway": "mass", "quantity": q, "value": x, "flags": ""}
        for q, values in (("mass", masses), ("mass_sd", spreads))
        for c, x in zip(CONDITIONS, values, strict=True)
    ]
    for pathway, condition, stiffness, flags in dummy:
        own = {"experiment": "dummy", "condition": condition, "pathway": pathway, "flags": flags}
        rows += [own | {"quantity": q, "value": stiffness} for q in ("I", "B", "K", "VAF_perturbation")]
    table = pd.DataFrame(rows).assign(estimator="ls", unit="1", ci_low="", ci_high="")
    plate = Result({}, {}, {"loaded_frame": frame, "bristle_frame": bristles})
    fits = {"weight": pulses(size, lag_s), "empty": pulses(10.0), "plate": {"plate": plate}}
    settings = {
        "weight": {"weight": {"mass_kg": 20.0}, "analysis": {"cutoffs_hz": [20.0, 10.0], "segment_s": 0.3}}
    }
    settings |= {"dummy": {"recommended": "leg", "foot": {"pathways": dict.fromkeys(pathways)}}}
    experiments = {"weight": CONDITIONS} | ({"dummy": ["a", "b"]} if dummy else {})
    study = {"title": "t", "recordings_source": None, "experiments": experiments, "made": {}}
    study |= {"models": {"weight": "plate"}, "belt_of_models": None, "amplitudes": amplitudes or {}}
    return Run({"estimates": table, "plate": pd.DataFrame(list(scores))}, fits, settings, study)


def content(run):
    def text(rows):
        return rows.replace({True: "true", False: "false"}).to_csv(index=False)

    data = report_content(run, {"weight": weight}) | OTHERS
    return data, {name: text(rows) for name, rows in run.tables.items()}


def words(run):
    return chapter_words("weight", *content(run), cells="|")


@pytest.mark.parametrize(
    ("masses", "spreads", "told"),
    [
        (FALLING, FALLING, (True, False)),
        (RISING, FALLING, (False, False)),
        (FALLING, WAVERING, (True, True)),
        (FALLING, RISING, (True, False)),
    ],
)
def test_mass_falls_only_if_it_falls_from_every_amplitude_to_the_next(masses, spreads, told):
    found = words(run_of(masses, spreads))
    wavering = "is largest at the smallest amplitude of each profile, but does not decrease in"
    assert ("The estimate decreases with amplitude." in found, wavering in found) == told


def with_linear(own, other):
    found = [score("fir", "weight", "weight", r2) for r2 in own]
    return run_of(scores=(*found, *(score("fir", "empty", "weight", r2) for r2 in other)))


@pytest.mark.parametrize(
    ("own", "other", "needed"),
    [([0.95, 0.97], [0.52, 0.54], True), ([0.95, 0.97], [0.93, 0.96], False), ([0.95], [], False)],
)
def test_linear_models_fail_only_if_they_do(own, other, needed):
    run = with_linear(own, other)
    assert bool(weight.linear_needs_load(run)) is needed
    assert ("the load matters more than the order" in words(run)) is needed
    assert not weight.frame_scored(run)


def test_growth_of_the_force_is_that_of_the_run():
    found = weight.numbers(run_of())
    assert found["speed_at_peak"] == pytest.approx([1.0] * 5)
    assert found["exponent"] == pytest.approx(0.5)
    chapter = words(run_of())
    assert (
        "moves at 100 % of its top speed. On average, the peak grows with the top speed: a power law fitted"
        in chapter
    )
    assert "over the conditions has the exponent 0.50." in chapter


@pytest.mark.parametrize(
    ("size", "lag_s", "matters"), [(15.0, 0.001, True), (10.5, -0.001, False), (5.0, 0.00005, True)]
)
def test_load_and_clocks_matter_only_if_they_do(size, lag_s, matters):
    run = run_of(size=size, lag_s=lag_s)
    assert weight.load_matters(run) is matters
    chapter = words(run)
    assert ("This is not the case" in chapter) is matters
    milliseconds = f"{1e3 * abs(lag_s):.2g}" if abs(lag_s) < 1e-3 else "1.0"
    assert f"the clock of the markers is off by {milliseconds}" in chapter


def test_cells_of_models_are_those_of_the_scores():
    scores = (
        score("fir", "empty", "empty", 0.9),
        score("fir", "empty", "weight", -20.0),
        score("arx", "weight", "weight", 0.8, converged=False),
    )
    chapter = words(run_of(scores=scores, bristles=None))
    assert "impulse response|empty|2|0.900|2.00|< −10|2.00|" in chapter
    assert "arx *|weight|2|–|–|0.800|2.00|" in chapter
    assert "bristle frame is the loaded frame" not in chapter


def test_frame_names_its_terms_and_no_resonance_that_nobody_sees():
    chapter = words(run_of())
    kept = "bristle friction (which depends on the path of the belt) and a lever arm of the friction"
    assert kept in chapter and "about the x axis. We fitted force and moment together" in chapter
    assert "above 200 Hz at 0 kg, at 48.7 ± 0.20 Hz at 20 kg and at 43.9 ± 0.11 Hz at 60 kg" in chapter
    assert "|weight|0.980|0.830|0.990|" in chapter
    assert "For this treadmill we kept no further term." in words(run_of(bristles=BRISTLES | {"terms": []}))
    assert "search for the constants did not converge" not in words(run_of(bristles=BRISTLES))
    assert "search for the constants did not converge" in words(
        run_of(bristles=BRISTLES | {"converged": False})
    )
    free = words(run_of(bristles=BRISTLES | {"terms": ["without-physics"]}))
    assert "A linear response to the acceleration of the belt takes its place" in free
    assert "resonance of the frame is" not in free


@pytest.mark.parametrize(
    ("empty_hz", "loaded_hz", "told"),
    [
        (52.0, 48.0, "is at 52.0 Hz without and at 48.0 Hz with the weight."),
        (5e7, 48.0, "is at 48.0 Hz with the weight; without it there is none below 200 Hz."),
        (52.0, float("inf"), "is at 52.0 Hz without the weight; with it there is none below 200 Hz."),
        (5e7, float("inf"), "lies above 200 Hz, with and without the weight."),
    ],
)
def test_a_resonance_that_is_not_seen_is_not_located(empty_hz, loaded_hz, told):
    assert told in words(run_of(frame=FRAME | {"empty_hz": empty_hz, "loaded_hz": loaded_hz}))


DUMMY = (
    ("leg", "a", 10.0, ""),
    ("leg", "b", 9.0, ""),
    ("foot", "a", 3.0, ""),
    ("foot", "b", 3.0, ""),
    ("foot-compensated", "a", 10.5, ""),
    ("foot-compensated", "b", 8.1, "treadmill-model"),
)


def test_foot_pathways_are_compared_with_the_leg_and_the_gate_is_told():
    chapter = words(run_of(dummy=DUMMY, amplitudes={"a": 0.3, "b": 0.5}))
    told = "the K of foot, compensated differs from the K of leg by −10.0 to 5.0 %."
    assert f"At 0.3 m/s and above, {told}" in chapter
    assert "is rejected in 1 of the 2 conditions of" in chapter and "in 1 of all 2. Over all" in chapter
    accepted = [(*row[:3], "") for row in DUMMY]
    chapter = words(run_of(dummy=accepted, amplitudes={"a": 0.3, "b": 0.5}))
    assert "is rejected in 0 of the 2 conditions of" in chapter


@pytest.mark.slow
@pytest.mark.parametrize(
    ("amplitudes", "told"),
    [
        ({"a": 0.1, "b": 0.5}, "0.5"),
        ({"a": 0.1, "b": 0.2}, "0.1"),
        ({"a": None, "b": None}, None),
    ],
)
def test_velocities_of_the_foot_are_those_of_the_sheet(amplitudes, told):
    data, tables = content(run_of(dummy=DUMMY, amplitudes=amplitudes))
    (found,) = evaluated(
        ["if clear-from != none { num(clear-from, digits: 1) }"], "weight_values.typ", data, tables
    )
    assert found == told


FIGURES = [f"figure_{name}" for name in ("4_5", "4_6", "5_1", "plate_models", "plate_responses", "foot")]


def test_frames_fitted_to_all_weights_are_not_said_to_extrapolate():
    heavy = [
        score("bristle-frame", "empty+weight", "weight of 60 kg", 0.995),
        score("loaded-frame", "empty+weight only", "weight of 60 kg", 0.7),
        score("bristle-frame", "empty+weight only", "weight of 60 kg", 0.9),
    ]
    usual, other = run_of(), run_of(scores=(*SCORES, *heavy))
    laboratory = [
        {"kind": "true", "key": f"treadmill.plate.{name}", "value": value}
        for name, value in (("resonance_hz", 52.0), ("resonance_mass_kg", 150.0), ("second_share", "0.4 0.2"))
    ]
    known = Run(
        other.tables | {"laboratory": pd.DataFrame(laboratory)}, other.fits, other.settings, other.study
    )
    assert "whether they extrapolate" not in words(usual) and "(true" not in words(usual)
    told = words(known)
    assert "fitted to the empty belt and all weights together" in told
    assert "so their R2 does not test whether they extrapolate to another weight" in told
    assert "|bristle frame|empty, all weights|" in told and "|bristle frame|empty, 20.0 kg|" in told
    # 52 / sqrt(1 + 0.6 kg / 150)
    assert "(true first mode: 52.0 and 50.0 Hz)" in told
    assert "at 43.9 ± 0.11 Hz at 60 kg (true: 46.7)" in told
    assert (
        "are used in the fit, the frames reach R2 = 0.700 to 0.900 under the left-out weight of 60 kg" in told
    )


def test_kept_studies_with_other_plates_are_compared():
    measures = {
        "misfit to the statements (sum of squares of the fit)": ("", "", "42", "6", "7"),
        "largest error of K of the standing person over the tasks": ("%", "", "10", "64", "11"),
        "largest error of K from the foot (compensated), 0.3 m/s and above": (
            "%",
            "",
            "9",
            "76",
            "15",
        ),
        "change of the mass with amplitude": ("kg", "< 0", "-0.6", "-0.1", "-0.2"),
    }
    columns = ["measure", "unit", "thesis", "shipped", "fitted", "damped"]
    plates = pd.DataFrame([(name, *row) for name, row in measures.items()], columns=columns)
    usual = run_of()
    other = Run(usual.tables | {"plate_constants": plates}, usual.fits, usual.settings, usual.study)
    assert "Plates fitted" not in words(usual)
    told = words(other)
    assert "is more damped. The plate of this study agrees worst with the thesis." in told
    assert "|largest error of K of the standing person over the tasks (%)||10|64|11|" in told
    assert "|change of the mass with amplitude (kg)|< 0|−0.6|−0.1|−0.2|" in told


def test_captions_tell_only_what_was_found():
    found = findings_of(FIGURES, *content(run_of(dummy=DUMMY, amplitudes={"a": 0.3, "b": 0.5})))
    assert list(found) == FIGURES
    assert found["figure_4_5"] == (
        "Under the weight the root mean square of the belt-induced force is 1.5 times that of the empty belt."
    )
    assert found["figure_4_6"].endswith("of 20.0 kg is 20.00 to 20.40 kg over the trials.")
    assert found["figure_plate_models"].endswith(
        "the bristle frame, fitted to the empty belt and the weight, reaches R² = 0.990."
    )
    assert "over all held-out trials from 8.00 to" in found["figure_plate_responses"]
    assert found["figure_foot"] == (
        "At 0.3 m/s and above, K is 9.00 to 10.00 (leg), 3.00 (foot) and 8.10 to 10.50 (foot, compensated) "
        "N·m/rad. In 1 of these 2 conditions, the treadmill model of “foot, compensated” is rejected."
    )
    other = findings_of(FIGURES, *content(run_of(size=10.5, scores=SCORES[:3], dummy=DUMMY, pathways=())))
    assert set(other) == {"figure_4_6", "figure_5_1", "figure_plate_responses"}
