"""The experiment platform: from a table to rows, result, figures, page and numbers of the report."""

import os
import re
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from page_builders import page_data
from typst_builders import typeset_words

from tepsipe.drawing.trial_page import render
from tepsipe.errors import InputError
from tepsipe.experiments.platform import figures
from tepsipe.experiments.platform.analysis import analyse_platform, platform_estimates, platform_result
from tepsipe.experiments.platform.fit import begin, fit
from tepsipe.experiments.platform.options import PlatformOptions
from tepsipe.experiments.platform.page import platform_page
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulator_options import PlatformTableOptions
from tepsipe.ingest.platform import ingest_platform
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.result import read_result, write_result
from tepsipe.reporting.chapters import platform
from tepsipe.reporting.run import Run, report_content
from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform

OPTIONS = PlatformOptions(
    band_hz=(0.05, 5.0),
    averaged_bins=20,
    taper_fraction=0.02,
    delays_s=(0.04, 0.24),
    delay_step_s=0.05,
    models=("intrinsic", "own-reflex"),
    rejected_below=0.01,
    largest_share=0.1,
    mode_below_hz=0.5,
    training_fraction=0.5,
)
TABLE = PlatformTableOptions(50.0, 0.05, "rad", 1, "m")
DURATION_S = 150.0


def table_of(record):
    names = ("ankle", "hip")
    table = {"time": record.time, "platform": record.platform}
    table |= {f"{name}_angle": record.angle[:, k] for k, name in enumerate(names)}
    return table | {f"{name}_torque": record.torque[:, k] for k, name in enumerate(names)}


@pytest.fixture(scope="module")
def table():
    quiet = replace(PlatformPerson(), own_torque_Nm=(4.0, 2.0))
    return table_of(record_platform(quiet, PlatformProtocol(DURATION_S), np.random.default_rng(2)))


@pytest.fixture(scope="module")
def trial(table):
    return ingest_platform(table, TABLE, DURATION_S - 0.1, "person.csv")


@pytest.fixture(scope="module")
def analysis(trial):
    return analyse_platform(trial, OPTIONS)


def test_fit_takes_the_section_of_the_configuration(trial, analysis):
    section = {"analysis": vars(OPTIONS)}
    fitted = fit(trial, section, "a")
    assert str(fitted.estimates) == str(platform_estimates("platform", "a", analysis, OPTIONS))  # NaN
    assert not fitted.contributions
    whole, *_ = begin(trial, section, "platform/a")
    assert np.array_equal(whole.frequency_hz, analysis.spectra.frequency_hz)


@pytest.fixture(scope="module")
def rows(analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("platform") / "estimates.csv"
    ESTIMATES.write(path, platform_estimates("platform", "a", analysis, OPTIONS))
    return path


@pytest.fixture(scope="module")
def result(analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("platform") / "fit.h5"
    write_result(path, platform_result(analysis, OPTIONS, "m"))
    return read_result(path)


@pytest.mark.slow
def test_known_person_is_found_and_predicted(analysis, rows):
    assert analysis.chosen == "intrinsic"
    found = {(row.estimator, row.quantity): row for row in ESTIMATES.read(rows)}
    for quantity, true in (("K_ankle_ankle", 1000.0), ("K_hip_hip", 420.0), ("B_ankle_ankle", 120.0)):
        row = found["iv-intrinsic", quantity]
        assert row.value == pytest.approx(true, rel=0.1)
        assert row.ci_low < true < row.ci_high
        assert row.recommended
        assert not row.flags
    for joint in ("ankle", "hip"):
        assert found["iv-intrinsic", f"VAF_driven_held_out_{joint}"].value > 98.0
        assert found["iv-intrinsic", f"VAF_held_out_{joint}"].value > 80.0
        assert not found["direct-intrinsic", f"K_{joint}_hip"].recommended


def test_what_is_not_identified_has_a_row_without_a_value(rows):
    refused = [row for row in ESTIMATES.read(rows) if "not-identified" in row.flags]
    # this person has no reflex whose delay could be found
    assert {"delay_ankle", "delay_hip"} <= {row.quantity for row in refused}
    for row in refused:
        assert np.isnan(row.value)
        assert row.flags == "not-identified"
        assert row.standard_error is row.ci_low is row.ci_high is None


def test_torque_of_the_other_sign_is_refused(table):
    turned = ingest_platform(table, replace(TABLE, torque_sign=-1), DURATION_S - 0.1, "person.csv")
    with pytest.raises(InputError, match=r"ankle torque that resists a slow lean, found -1.* torque_sign"):
        analyse_platform(turned, OPTIONS)


def test_reversed_torque_of_the_hip_is_flagged_and_not_recommended(table):
    turned = table | {"hip_torque": -table["hip_torque"]}
    analysis = analyse_platform(ingest_platform(turned, TABLE, DURATION_S - 0.1, "person.csv"), OPTIONS)
    rows = platform_estimates("platform", "person", analysis, OPTIONS)
    chosen = [row for row in rows if row.estimator == f"iv-{analysis.chosen}" and row.quantity[:2] == "K_"]
    assert chosen and not any(row.recommended for row in rows)
    assert all("negative" in row.flags for row in chosen)


PAIRS = (("ankle", "hip"), ("hip", "ankle"))
NEW = {"joints-exchanged", "halves-differ", "filtered-signal", "spikes", "held-samples", "clipped"}
QUICK = {"analysis": vars(replace(OPTIONS, models=("intrinsic",)))}


def flags_of(table):
    """Flags of the rows of K and B by the instrument, as the study's job makes them."""
    fitted = fit(ingest_platform(table, TABLE, DURATION_S - 0.1, "person.csv"), QUICK, "a")
    own = [
        row
        for row in fitted.estimates
        if row.estimator == "iv-intrinsic" and row.quantity[:2] in ("K_", "B_")
    ]
    return set.intersection(*(set(row.flags.split(";")) for row in own)) & NEW


def second_half(factor):
    def change(table):
        late = table["time"] > 0.5 * table["time"][-1]
        return {"ankle_torque": np.where(late, factor, 1.0) * table["ankle_torque"]}

    return change


def spiked(table):
    torque = table["ankle_torque"].copy()
    torque[[1000, 4000]] += np.ptp(torque)
    return {"ankle_torque": torque}


@pytest.mark.parametrize(
    ("spoil", "flags"),
    [
        (lambda t: {}, set()),
        (lambda t: {"ankle_torque": t["hip_torque"], "hip_torque": t["ankle_torque"]}, {"joints-exchanged"}),
        (lambda t: {"ankle_angle": t["hip_angle"], "hip_angle": t["ankle_angle"]}, {"joints-exchanged"}),
        (
            lambda t: {f"{a}_{what}": t[f"{b}_{what}"] for a, b in PAIRS for what in ("angle", "torque")},
            {"joints-exchanged"},
        ),
        (lambda t: {"hip_angle": t["hip_angle"] + t["ankle_angle"]}, {"joints-exchanged"}),
        (second_half(1.02), set()),
        (second_half(1.4), {"halves-differ"}),
        (spiked, {"spikes"}),
    ],
    ids=[
        "sound",
        "torques",
        "angles",
        "joints",
        "trunk-from-vertical",
        "gain-of-2-percent",
        "gain",
        "spikes",
    ],
)
def test_a_spoiled_recording_is_flagged_by_what_was_spoiled(table, spoil, flags):
    assert flags_of(table | spoil(table)) == flags


def test_platform_that_does_not_move_the_joints_is_refused(table, rng):
    other = table | {"platform": rng.standard_normal(table["time"].size)}
    unmoved = ingest_platform(other, TABLE, DURATION_S - 0.1, "person.csv")
    with pytest.raises(InputError, match="angles that follow the platform"):
        analyse_platform(unmoved, OPTIONS)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda t: {"ankle_angle": 100.0 * t["ankle_angle"]}, "half a revolution.*angle_unit"),
        (
            lambda t: {"hip_torque": np.where(t["time"] > 9.0, 3.0, t["hip_torque"])},
            "torque of the hip to change",
        ),
        (
            lambda t: {"hip_torque": 1e-6 * t["hip_torque"]},
            "torque of at least 0.1 N·m per rad of the angle of the hip",
        ),
        (lambda t: {"hip_angle": 1e-3 * t["hip_angle"]}, "torque of the hip of .* N·m per rad of the angle"),
        (lambda t: {"ankle_torque": 100.0 * t["ankle_torque"]}, "joint torque of -500 to 500 Nm.* in ankle"),
    ],
)
def test_impossible_signals_are_refused(table, spoil, said, shipped_config):
    limits = Limits(**{k: shipped_config["plausible"][k] for k in Limits.__dataclass_fields__})
    with pytest.raises(InputError, match=said):
        plausible_trial(
            ingest_platform(table | spoil(table), TABLE, DURATION_S - 0.1, "person.csv"),
            limits,
            Rig(),
            {"log": "person.csv"},
        )


def test_degrees_and_a_second_perturbation_are_ingested(table):
    in_degrees = {name: np.degrees(table[name]) for name in ("ankle_angle", "hip_angle")}
    other = table | in_degrees | {"second_perturbation": 2.0 * table["platform"]}
    found = ingest_platform(other, replace(TABLE, angle_unit="deg"), DURATION_S - 0.1, "person.csv")
    expected = np.column_stack([table["ankle_angle"], table["hip_angle"]])
    assert found.values("joint_angle") == pytest.approx(expected, abs=1e-9)
    assert found.values("second_perturbation") == pytest.approx(2.0 * found.values("platform"))
    with pytest.raises(InputError, match=r"found 50 Hz: lower platform\.ingest\.resample_rate_hz"):
        ingest_platform(table, replace(TABLE, resample_rate_hz=100.0), DURATION_S - 0.1, "person.csv")


def test_figures_show_every_joint(result, rows):
    results = {"a": result}
    assert len(figures.plot_responses(results).axes) == 6
    shown = figures.plot_quantities(results, {"a": ESTIMATES.read(rows)})
    ticks = [label.get_text() for label in shown.axes[0].get_yticklabels()]
    assert {"at once, ankle", "at once, hip", "slow mode"} <= set(ticks)
    assert [axis.get_title() for axis in figures.plot_prediction(results).axes] == ["a, ankle", "a, hip"]


def test_page_and_report_say_what_is_identified(trial, result, rows):
    choices = {"study": "A study", "condition": "a", "made": False}
    html = render(platform_page(trial, result, ESTIMATES.read(rows), choices))
    panels = [panel["title"] for panel in page_data(html)["panels"]]
    assert panels == [
        "Platform",
        "Angle of the ankle",
        "Angle of the hip",
        "Torque of the ankle",
        "Torque of the hip",
    ]
    words = told(result, rows)
    assert " ; intrinsic ; " in words and " ; own-reflex ; " in words
    assert "The trial identifies 10 of the 10 quantities of this model" in words
    assert "Trial a," not in words and "is not identified" not in words
    assert "The simplest model that is not rejected is intrinsic." in words


def told(result, rows, **changes):
    """Words of the chapter, for a trial whose fit has other facts."""
    estimates = pd.read_csv(rows, dtype={"condition": str})
    fits = {"platform": {"a": replace(result, facts=result.facts | changes)}}
    study = {"title": "t", "recordings_source": None, "experiments": {"platform": ["a"]}, "made": {}}
    settings = {"platform": {"analysis": asdict(OPTIONS)}}
    content = report_content(Run({"estimates": estimates}, fits, settings, study), {"platform": platform})
    source = '#show ref: none\n#include "chapters/platform.typ"'
    return typeset_words(source, content, {"estimates": rows}, cells=" ; ")


@pytest.mark.slow
def test_refused_quantities_are_named_with_their_joint(result, rows):
    words = told(result, rows, chosen="own-reflex")
    known, count = map(int, re.search(r"The trial identifies (\d+) of the (\d+) quantities", words).groups())
    assert known < count
    together = re.findall(
        r"Trial a, (?:ankle|hip): the perturbation does not separate (.*?) from other", words
    )
    named = [name for names in together for name in re.split(", | and ", names)]
    named += re.findall(r"Trial a: (.*?) is not identified", words)
    assert len(named) == count - known
    assert "delay of the reflex (ankle)" in named
    assert words.count("not identified ;") == count - known


def test_a_person_whom_no_model_describes_is_told(result, rows):
    words = told(result, rows, rejected=True)
    assert "Every model leaves torque that is coherent with the platform, so no parameter" in words
    assert "The simplest model that is not rejected" not in words


@pytest.mark.slow
def test_public_recording_rejects_simple_models():
    """Of H. Wang and A. J. van den Bogert, as docs/recordings/platform.md makes a table of it."""
    folder = os.environ.get("TEPSIPE_PLATFORM_DATA")
    if not folder or not (Path(folder) / "subject5.csv").is_file():
        pytest.skip(
            "TEPSIPE_PLATFORM_DATA names no folder with subject5.csv: see docs/recordings/platform.md"
        )
    names = ("time_s", "platform_m", "ankle_angle_rad", "hip_angle_rad", "ankle_torque_Nm", "hip_torque_Nm")
    columns = {name.rpartition("_")[0]: name for name in names}
    recorded = read_text_table(Path(folder) / "subject5.csv", columns, ",")
    trial = ingest_platform(recorded, TABLE, 309.0, "subject5.csv")
    models = ("intrinsic", "own-reflex", "all-reflex")
    found = analyse_platform(
        trial,
        replace(OPTIONS, band_hz=(0.1, 3.0), delays_s=(0.04, 0.3), delay_step_s=0.02, models=models),
    )
    assert found.chosen == "all-reflex"
    assert not found.models["all-reflex"].rejected(0.01)
    quantities = [one for of in found.models["all-reflex"].quantities for one in of.values()]
    assert sum(one.identified for one in quantities) < 6
    # ordinary regression predicts as well as the first tries on this recording
    assert min(vaf.held_out for vaf in found.models["all-reflex"].direct_vaf) > 90.0
