"""Configuration and trial sheet: what is not understood stops the run with one sentence."""

import copy
from dataclasses import replace

import pytest
import yaml
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.experiments.standing.muscle_torque import ACTIVE
from tepsipe.reporting.claims import MEASURES, Findings, check_claims, findings_of_cells
from tepsipe.reporting.ledger import null_cells, tolerances_of
from workflow.settings.check import check_content
from workflow.settings.complete import only, pick, settings_of, without
from workflow.settings.config import Config, check_config
from workflow.settings.reported import Reported
from workflow.settings.virtual_lab import VirtualLab
from workflow.support.checked_study import check_one_treadmill, check_plate_models, checked_constants
from workflow.support.imported_files import reached_by
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS, check_sources, read_trial_sheet
from workflow.support.version import code_version
from workflow.support.yaml_file import read_constants, read_settings


def merged(base, changes):
    """A copy of nested mappings, overridden as Snakemake does it: key by key."""
    result = dict(base)
    for key, value in changes.items():
        both = isinstance(value, dict) and isinstance(base.get(key), dict)
        result[key] = merged(base[key], value) if both else value
    return result


# ---- what is shipped ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "model"),
    [
        ("config.yaml", Config),
        ("virtual_lab.yaml", VirtualLab),
        ("reported.yaml", Reported),
    ],
)
def test_shipped_file_agrees_with_its_model(name, model, root):
    check_content(read_settings(root / "config" / name), model, name)


def test_shipped_configuration_refers_to_what_is_there(config, root):
    check_config(config, "configuration")
    trials = read_trial_sheet(root / config["study"]["trial_sheet"], ".")
    assert len(trials) == 56
    assert ("wristalyzer", config["wristalyzer"]["best_condition"]) in trials
    assert ("dummy", config["dummy"]["example_condition"]) in trials
    assert ("standing", config["standing"]["example_condition"]) in trials


def test_shipped_person_does_all_of_the_protocol(config, root):
    # thesis Figure 2-14: two tasks, two profiles, four amplitudes, every 4 to 8 s for 65 s
    trials = read_trial_sheet(root / config["study"]["trial_sheet"], ".")
    rows = [row for row in trials.values() if row.experiment == "standing"]
    assert len({(row.task, row.profile, row.amplitude) for row in rows}) == len(rows) == 16
    assert {row.amplitude for row in rows} == {0.2, 0.3, 0.4, 0.5}
    assert {(row.interval_s, row.longest_interval_s, row.duration_s) for row in rows} == {(4.0, 8.0, 65.0)}


def test_shipped_study_of_recordings_is_a_valid_override(config, root):
    override = read_settings(root / "config/human-ankle/config.yaml")
    both = merged(config, override)
    check_config(both, "human-ankle")
    trials = read_trial_sheet(root / both["study"]["trial_sheet"], "folder")
    assert {row.source for row in trials.values()} == {"recorded"}
    assert trials["position_manipulator", "trial1"].files == {"log": "folder/ankle_trial1.csv.gz"}


def test_overlay_for_computers_without_pybullet_changes_the_engine_and_nothing_else(config, root):
    both = merged(config, read_settings(root / "config/any-engine.yaml"))
    check_config(both, "any-engine")
    assert both["dummy"]["simulation"]["engine"] == "auto"
    assert config["dummy"]["simulation"]["engine"] == "pybullet"
    both["dummy"]["simulation"]["engine"] = "pybullet"
    assert both == config


def test_shipped_study_with_passive_cameras_is_a_valid_override(config, root, monkeypatch):
    monkeypatch.chdir(root)
    override = read_settings("config/passive-cameras/config.yaml")
    both = merged(config, override)
    check_config(both, "passive-cameras")
    own, base = checked_constants(both["study"]["virtual_lab"]), checked_constants("config/virtual_lab.yaml")
    capture = own["treadmill"].pop("capture")
    assert capture == base["treadmill"].pop("capture") | {"rate_hz": 200.0, "noise_m": 0.0002}
    assert own == base
    assert both["plate_treadmill"]["resample_rate_hz"] == capture["rate_hz"]


def test_cameras_of_100_hz_need_no_other_filter(config):
    changes = {"plate_treadmill": {"resample_rate_hz": 100.0}}
    check_config(merged(config, changes), "my-study")


def test_base_of_a_laboratory_is_a_path(tmp_path):
    (tmp_path / "lab.yaml").write_text("base: [a, b]\n")
    with pytest.raises(InputError, match="expected the path of a file for 'base'"):
        read_constants(tmp_path / "lab.yaml")


def test_shipped_study_of_a_treadmill_is_a_valid_override(config, root):
    override = read_settings(root / "config/rmill-treadmill/config.yaml")
    both = merged(config, override)
    check_config(both, "rmill-treadmill")
    trials = read_trial_sheet(root / both["study"]["trial_sheet"], "folder")
    assert [(row.condition, row.role) for row in trials.values()] == [
        ("slow-1", "calibrate"),
        ("slow-2", "validate"),
    ]
    assert trials["belt", "slow-1"].files == {"log": "folder/RandomSlowSpeed1.txt"}
    assert trials["belt", "slow-1"].names == {
        "files.columns.time": "Timestamp (s)",
        "files.columns.load": "Pitch Moment (Nm)",
        "files.columns.velocity": "Belt Velocity (m/s)",
    }


def test_reported_tables_have_the_conditions_of_the_trial_sheet(config, root):
    trials = read_trial_sheet(root / config["study"]["trial_sheet"], ".")
    reported = read_settings(root / "config/reported.yaml")
    for table, experiment in (("table_4_1", "wristalyzer"), ("table_4_2", "dummy")):
        for quantity, row in reported["tables"][table].items():
            for condition in row:
                assert (experiment, condition) in trials, f"{table} {quantity} {condition}"


def test_reported_slips_are_in_the_tables_as_printed(root):
    reported = read_settings(root / "config/reported.yaml")
    assert reported["slips"]
    for slip in reported["slips"]:
        printed = reported["tables"][slip["table"]][slip["quantity"]][slip["condition"]]
        assert printed == slip["printed"]
        assert slip["meant"] == pytest.approx(slip["printed"] / 10.0, abs=5e-4)


def test_every_reported_claim_can_be_measured(root):
    reported = read_settings(root / "config/reported.yaml")
    measured = [claim["measure"] for claim in reported["claims"]]
    assert set(measured) <= set(MEASURES)
    assert len(set(measured)) == len(measured)


def test_every_claim_has_a_null_model_and_names_what_it_rests_on(root):
    reported = read_settings(root / "config/reported.yaml")
    tolerances = tolerances_of(reported["cells"], reported["bases"])
    cells = null_cells(reported["tables"], tolerances, reported["slips"])
    nulls = findings_of_cells(cells, "leg-thesis")
    nothing = Findings([], {}, "leg-thesis")
    rows = check_claims(reported["claims"], nothing, reported["bases"], nulls=nulls)
    assert [row.claim for row in rows if row.null_value is None or not row.used] == []
    # most claims can discriminate: their null model fails
    assert sum(row.null_verdict == "implied" for row in rows) < len(rows) / 4
    assert set(reported["bases"]) == {one["used"] for one in reported["claims"] + reported["cells"]}


def test_every_statement_is_tested_or_says_why_not(root):
    reported = read_settings(root / "config/reported.yaml")
    measures = {claim["measure"] for claim in reported["claims"]}
    named = set()
    for one in reported["assertions"]:
        tests = one.get("measures", []) + one.get("tables", [])
        assert bool(tests) != ("unchecked" in one), one["says"]
        assert set(one.get("tables", [])) <= set(reported["tables"])
        named |= set(one.get("measures", []))
    # no claim tests what the thesis does not say
    assert named == measures
    places = " ".join(one["where"] for one in reported["assertions"])
    for place in ("Section 4-1-1", "Section 4-1-2", "Section 4-1-3", "Section 4-2", "Chapter 5", "Chapter 6"):
        assert place in places


# ---- the closed model --------------------------------------------------------------------------


@pytest.fixture
def refused(config, root):
    """Override the shipped configuration; return what is said about it."""

    def check(changes):
        changed = merged(config, changes)
        with pytest.raises(InputError) as caught:
            check_config(changed, "my-study")
        text = str(caught.value)
        assert text.startswith("my-study: ")
        assert "\n" not in text
        assert len(text) < 400
        return text

    return check


UNKNOWN_KEYS = [
    ({"dumy": {}}, "dumy", "dummy"),
    ({"study": {"sed": 1}}, "study.sed", "seed"),
    (
        {"wristalyzer": {"analysis": {"lowpass_cutof_hz": 20.0}}},
        "wristalyzer.analysis.lowpass_cutof_hz",
        "lowpass_cutoff_hz",
    ),
    (
        {"dummy": {"pathways": {"leg": {"estimater": "x"}}}},
        "dummy.pathways.leg.estimater",
        "estimator",
    ),
    (
        {"position_manipulator": {"random_starts": 20}},
        "position_manipulator.random_starts",
        "wristalyzer.analysis.random_starts",
    ),
]


@pytest.mark.parametrize(
    ("changes", "key", "meant"), UNKNOWN_KEYS, ids=[str(case[1]) for case in UNKNOWN_KEYS]
)
def test_unknown_key_is_named_with_the_one_that_was_meant(changes, key, meant, refused):
    text = refused(changes)
    assert f"unknown key {key!r}" in text
    assert f"did you mean {meant!r}?" in text


def test_unknown_key_of_sections_that_share_their_keys_is_shown_in_each(refused):
    text = refused({"position_manipulator": {"marker_sampling_hz": 250}})
    for section in ("dummy", "weight", "standing"):
        assert f"'{section}.ingest.marker_sampling_hz'" in text


def test_unknown_key_like_no_other_is_shown_beside_those_that_are_known(refused):
    assert "known here: name, title" in refused({"study": {"xyzzy": 1}})


@pytest.mark.parametrize(
    "path", [("study", "seed"), ("dummy", "analysis", "merge_s"), ("position_manipulator",)]
)
def test_missing_key_is_named(path, config, root):
    *parents, last = path
    section = config
    for name in parents:
        section = section[name]
    del section[last]
    with pytest.raises(InputError) as caught:
        check_config(config, "my-study")
    assert_one_sentence(caught.value, "my-study", repr(".".join(path)))


WRONG_VALUES = [
    ({"study": {"seed": "many"}}, "study.seed", "integer"),
    ({"study": {"virtual_lab": 3}}, "study.virtual_lab", "string or null"),
    (
        {"plate_treadmill": {"exceptions": {"dummy": {"lowpass_order": 3}}}},
        "plate_treadmill.exceptions.dummy.lowpass_order",
        "one of 2, 4, 6, 8",
    ),
    ({"dummy": {"ingest": {"max_gap_s": True}}}, "max_gap_s", "number"),
    ({"wristalyzer": {"analysis": {"fit_band_hz": [1.0]}}}, "fit_band_hz", "at least 2 items"),
    ({"wristalyzer": {"analysis": {"fit_band_hz": 9.0}}}, "fit_band_hz", "array"),
    ({"wristalyzer": {"files": {"angle_unit": "degrees"}}}, "angle_unit", "'rad', 'deg'"),
    ({"belt": {"files": {"load_unit": "kNm"}}}, "belt.files.load_unit", "one of 'Nm', 'N'"),
    ({"belt": {"files": {"delimiter": ";"}}}, "belt.files.delimiter", "'comma', 'tab'"),
    ({"belt": {"ingest": {"shortest_s": 0}}}, "belt.ingest.shortest_s", "above 0"),
    ({"dummy": {"pathways": {"leg": {"torque": "foot"}}}}, "leg.torque", "'leg', 'leg-thesis'"),
    ({"dummy": None}, "dummy", "object"),
    ({"standing": {"muscles": {"TA": {"lengthened_by": {"ankle": "1"}}}}}, "lengthened_by.ankle", "number"),
    ({"standing": {"pathways": {"ankle": {"torque": "leg"}}}}, "ankle.torque", "'single-joint'"),
    ({"standing": {"estimators": {"long": {"active": "reflex"}}}}, "long.active", str([*ACTIVE])[1:-1]),
    ({"standing": {"analysis": {"bootstrap_draws": 50}}}, "bootstrap_draws", "at least 100"),
    ({"standing": {"analysis": {"baseline_s": [-0.1, 0.1]}}}, "baseline_s", "a number of at most 0"),
    ({"standing": {"active": {"twitch_s": []}}}, "twitch_s", "at least 1"),
    ({"standing": {"latency": {"detector": "eye"}}}, "latency.detector", "'changepoint'"),
]


@pytest.mark.parametrize(
    ("changes", "where", "expected"), WRONG_VALUES, ids=[str(case[1]) for case in WRONG_VALUES]
)
def test_value_of_the_wrong_type_or_range_is_refused(changes, where, expected, refused):
    text = refused(changes)
    assert where in text
    assert "expected" in text
    assert "found" in text
    assert expected in text


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_number_that_is_not_finite_is_refused(value, refused):
    refused({"dummy": {"analysis": {"signal_to_noise": value}}})


MISFITS = [
    (
        {"dummy": {"pathways": {"leg-output-error": {"torque": "leg-thesis"}}}},
        ["dummy.pathways.leg-output-error", "leg-thesis", "output-error"],
    ),
    ({"dummy": {"recommended": "leg-output-error"}}, ["dummy.recommended", "leg-output-error"]),
    ({"dummy": {"foot": {"belt_fixed_labels": ["foot1", "heel"]}}}, ["belt_fixed_labels", "'heel'"]),
    ({"dummy": {"specification": {"other_cutoff_hz": 20.0}}}, ["other_cutoff_hz", "20"]),
    ({"dummy": {"specification": {"other_cutoff_hz": 200.0}}}, ["other_cutoff_hz", "125"]),
    ({"dummy": {"as_printed": "leg-thsis"}}, ["dummy.as_printed", "did you mean 'leg-thesis'?"]),
    ({"dummy": {"recommended": "foot"}}, ["dummy.recommended", "'foot'"]),
    ({"dummy": {"files": {"marker_labels": ["ankle", "leg1"]}}}, ["leg_markers", "'leg2'"]),
    ({"wristalyzer": {"analysis": {"fit_band_hz": [9.0, 1.0]}}}, ["fit_band_hz", "low to high"]),
    (
        {"wristalyzer": {"analysis": {"start": {"K_Nm_per_rad": 25.0}}}},
        ["start.K_Nm_per_rad", "25.0"],
    ),
    (
        {"wristalyzer": {"analysis": {"tried_stiffness_Nm_per_rad": [5.0, 20.0]}}},
        ["tried_stiffness_Nm_per_rad", "found 20.0"],
    ),
    (
        {"position_manipulator": {"analysis": {"lowpass_cutoff_hz": 125.0}}},
        ["position_manipulator.analysis.lowpass_cutoff_hz", "125 Hz"],
    ),
    (
        {"position_manipulator": {"analysis": {"parallel_cascade": {"expected_delay_s": 0.1}}}},
        ["parallel_cascade.expected_delay_s", "[0.03, 0.06]", "found 0.1"],
    ),
    (
        {"position_manipulator": {"analysis": {"parallel_cascade": {"reflex_delays_s": [0.06, 0.03]}}}},
        ["from short to long", "[0.06, 0.03]"],
    ),
    (
        {"position_manipulator": {"analysis": {"parallel_cascade": {"reflex_knot_s": 0.4}}}},
        ["parallel_cascade.reflex_knot_s", "found 0.4 s"],
    ),
    ({"standing": {"as_printed": "foot"}}, ["standing.as_printed", "standing.pathways", "'foot'"]),
    (
        {"standing": {"recommended": {"pathway": "ankel"}}},
        ["standing.recommended.pathway", "standing.pathways", "ankle-compensated", "'ankel'"],
    ),
    (
        {"standing": {"recommended": {"estimator": "ankle"}}},
        ["standing.recommended.estimator", "standing.estimators", "pre-reflex-window", "'ankle'"],
    ),
    (
        {"standing": {"pathways": {"ankle": {"treadmill_model": "firr"}}}},
        ["standing.pathways.ankle.treadmill_model", "weight.models.family", "'firr'"],
    ),
    (
        {"standing": {"files": {"marker_labels": ["foot1", "foot2", "ankle", "shank1", "shank2"]}}},
        ["standing.person.thigh_markers", "standing.files.marker_labels", "'thigh1'"],
    ),
    (
        {"standing": {"estimators": {"long": {"window_s": 1.2}}}},
        ["standing.estimators.long.window_s", "standing.analysis.after_s (1 s)", "found 1.2 s"],
    ),
    (
        {"standing": {"analysis": {"after_s": 0.4}}},
        ["standing.estimators.emg-driven.window_s", "(0.4 s)", "found 0.5 s"],
    ),
    (
        {"standing": {"analysis": {"baseline_s": [-0.4, -0.02]}}},
        ["standing.analysis.baseline_s", "between -0.3 and 0", "[-0.4, -0.02]"],
    ),
    (
        {"standing": {"analysis": {"baseline_s": [-0.02, -0.1]}}},
        ["standing.analysis.baseline_s from low to high", "[-0.02, -0.1]"],
    ),
    (
        {"standing": {"latency": {"search_s": [0.02, 1.1]}}},
        ["standing.latency.search_s", "between 0 and 1", "[0.02, 1.1]"],
    ),
    (
        {"standing": {"latency": {"baseline_until_s": 0.03}}},
        ["standing.latency.search_s", "between 0.03 and 1", "[0.02, 0.12]"],
    ),
    (
        {"standing": {"analysis": {"tried_windows_s": [0.05, 1.5, 0.1]}}},
        ["standing.analysis.tried_windows_s", "standing.analysis.after_s (1 s)", "found 1.5 s"],
    ),
    (
        {"standing": {"emg": {"band_hz": [300.0, 20.0]}}},
        ["standing.emg.band_hz from low to high", "[300.0, 20.0]"],
    ),
    (
        {"plate_treadmill": {"lowpass_cutoff_hz": 130.0}},
        ["plate_treadmill.lowpass_cutoff_hz", "plate_treadmill.resample_rate_hz", "125 Hz"],
    ),
    (
        {"plate_treadmill": {"exceptions": {"standing": {"resample_rate_hz": 40.0}}}},
        [
            "plate_treadmill.lowpass_cutoff_hz",
            "plate_treadmill.exceptions.standing.resample_rate_hz",
            "20 Hz",
        ],
    ),
    (
        {"plate_treadmill": {"exceptions": {"dummy": {"lowpass_cutoff_hz": 125.0}}}},
        ["plate_treadmill.exceptions.dummy.lowpass_cutoff_hz", "plate_treadmill.resample_rate_hz (125 Hz)"],
    ),
    (
        {"plate_treadmill": {"exceptions": {"dummy": {"lowpass_cutoff_hz": 10.0}}}},
        ["dummy.specification.other_cutoff_hz", "plate_treadmill.exceptions.dummy.lowpass_cutoff_hz (10 Hz)"],
    ),
    (
        {"weight": {"analysis": {"other_cutoffs_hz": [10.0, 20.0]}}},
        ["weight.analysis.other_cutoffs_hz", "plate_treadmill.lowpass_cutoff_hz", "20 Hz"],
    ),
]


@pytest.mark.parametrize(("changes", "names"), MISFITS, ids=[str(case[1]) for case in MISFITS])
def test_values_that_do_not_fit_each_other_are_refused(changes, names, refused):
    text = refused(changes)
    for name in ("expected", "found", *names):
        assert name in text


def test_leg_marker_that_is_placed_twice_is_refused(config, refused):
    placed = copy.deepcopy(config["dummy"]["geometry"]["leg_markers"])
    placed[2]["label"] = placed[1]["label"]
    assert "'leg1'" in refused({"dummy": {"geometry": {"leg_markers": placed}}})


# ---- YAML --------------------------------------------------------------------------------------


def refused_yaml(path, content):
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_settings(path)
    assert_one_sentence(caught.value, path)
    return str(caught.value)


def test_key_that_stands_twice_is_refused_with_its_line(tmp_path):
    text = refused_yaml(tmp_path / "c.yaml", b"study:\n  seed: 1\n  name: x\n  seed: 2\n")
    assert "'seed'" in text
    assert "line 4" in text


def test_damaged_yaml_is_refused_with_its_line(tmp_path):
    assert "line 3" in refused_yaml(tmp_path / "c.yaml", b"study:\n  seed: [1, 2\nname: x\n")


def test_template_that_was_not_filled_in_is_refused(tmp_path):
    refused_yaml(tmp_path / "c.yaml", b"results: {{folder}}\n")


def test_yaml_that_is_not_text_is_refused(tmp_path):
    refused_yaml(tmp_path / "c.yaml", "title: Größe\n".encode("latin-1"))


def test_yaml_that_holds_no_keys_is_refused(tmp_path, root):
    (tmp_path / "c.yaml").write_text("- 1\n- 2\n")
    with pytest.raises(InputError) as caught:
        check_config(read_settings(tmp_path / "c.yaml"), "c.yaml")
    assert_one_sentence(caught.value, "c.yaml")


def test_missing_yaml_is_refused(tmp_path):
    with pytest.raises(InputError) as caught:
        read_settings(tmp_path / "none.yaml")
    assert_one_sentence(caught.value, tmp_path / "none.yaml")


def test_good_yaml_is_read_as_any_reader_would(root):
    text = (root / "config/config.yaml").read_text()
    assert read_settings(root / "config/config.yaml") == yaml.safe_load(text)


def test_yaml_that_merges_one_mapping_into_another_is_read(tmp_path):
    (tmp_path / "c.yaml").write_text("base: &b {x: 1, y: 2}\nmore:\n  <<: *b\n  y: 3\n")
    assert read_settings(tmp_path / "c.yaml")["more"] == {"x": 1, "y": 3}


@pytest.mark.parametrize(
    "text",
    [
        "a: " + "[" * 100_000,  # crashes the parser
        '{"a": ' + "[" * 100_000,
        "".join(" " * k + "a:\n" for k in range(2000)),
        "a0: &a0 [1, 2]\n"
        + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, 10)),
        "a: &a\n  b: *a\n",
    ],
    ids=["brackets", "json", "sections", "aliases", "itself"],
)
def test_configuration_without_end_is_refused(text, tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_settings(path)
    assert str(path) in str(caught.value)


# ---- the trial sheet ---------------------------------------------------------------------------

GOOD = {
    "experiment": "dummy",
    "condition": "sine-0.3",
    "source": "virtual_lab",
    "profile": "sine",
    "amplitude": "0.3",
    "interval_s": "4",
    "duration_s": "70",
    "log": "-",
    "command": "-",
    "calibration": "-",
    "markers": "-",
}
RECORDED = GOOD | {
    "source": "recorded",
    "profile": "-",
    "amplitude": "-",
    "interval_s": "-",
    "log": "log.mat",
    "calibration": "plate.csv",
    "markers": "markers.c3d",
}


@pytest.fixture
def sheet(tmp_path):
    def write(*rows, columns=COLUMNS):
        path = tmp_path / "trials.tsv"
        lines = [columns, *([row[name] for name in columns if name in row] for row in rows)]
        path.write_text("".join("\t".join(line) + "\n" for line in lines))
        return path

    return write


def refuse_sheet(path):
    with pytest.raises(InputError) as caught:
        read_trial_sheet(path, ".")
    text = str(caught.value)
    assert text.startswith(str(path))
    assert "\n" not in text
    return text


def test_good_rows_are_read_in_their_order(sheet):
    path = sheet(RECORDED | {"condition": "mine"}, GOOD)
    trials = read_trial_sheet(path, "/data")
    assert list(trials) == [("dummy", "mine"), ("dummy", "sine-0.3")]
    assert trials["dummy", "mine"].files == {
        "log": "/data/log.mat",
        "calibration": "/data/plate.csv",
        "markers": "/data/markers.c3d",
    }
    made = trials["dummy", "sine-0.3"]
    assert made.files == {}
    assert (made.amplitude, made.interval_s, made.duration_s) == (0.3, 4.0, 70.0)


def test_absolute_paths_in_the_sheet_stay_where_they_are(sheet):
    trials = read_trial_sheet(sheet(RECORDED | {"log": "/elsewhere/log.mat"}), "/data")
    assert trials["dummy", "sine-0.3"].files["log"] == "/elsewhere/log.mat"


def test_empty_lines_of_the_sheet_do_not_matter(sheet):
    path = sheet(GOOD)
    path.write_text(path.read_text() + "\n\t\t\n\n")
    assert len(read_trial_sheet(path, ".")) == 1


def test_unknown_column_is_named_with_the_one_that_was_meant(sheet):
    columns = [name.replace("interval_s", "intervall_s") for name in COLUMNS]
    assert "'intervall_s': did you mean 'interval_s'?" in refuse_sheet(sheet(columns=columns))


def test_missing_column_is_named(sheet):
    columns = [name for name in COLUMNS if name != "markers"]
    text = refuse_sheet(sheet(GOOD, columns=columns))
    assert "expected" in text
    assert "'markers'" in text


def test_column_that_stands_twice_is_refused(sheet):
    assert "'log'" in refuse_sheet(sheet(GOOD, columns=[*COLUMNS, "log"]))


MISTAKES = [
    (GOOD, {"experiment": "dumy"}, ["'dumy'", "dummy"]),
    (GOOD, {"condition": "sine 0.3"}, ["'sine 0.3'", "condition"]),
    (GOOD, {"condition": "../x"}, ["'../x'"]),
    (GOOD, {"condition": ""}, ["condition"]),
    (GOOD, {"source": "recordings"}, ["'recordings'", "recorded"]),
    (GOOD, {"profile": "sinus"}, ["'sinus'", "sine"]),
    (GOOD, {"amplitude": "large"}, ["'large'", "amplitude"]),
    (GOOD, {"interval_s": "-4"}, ["'-4'", "interval_s"]),
    (GOOD, {"duration_s": "inf"}, ["'inf'", "duration_s"]),
    (GOOD, {"duration_s": "0,5"}, ["'0,5'", "duration_s"]),
    (GOOD, {"experiment": "position_manipulator", "profile": "-"}, ["position_manipulator", "recorded"]),
    (RECORDED, {"markers": "-"}, ["markers", "dummy/sine-0.3"]),
    (RECORDED, {"calibration": "-"}, ["calibration"]),
    (RECORDED, {"calibration": ""}, ["calibration"]),
    (RECORDED, {"duration_s": "-"}, ["duration_s"]),
]


@pytest.mark.parametrize(("row", "changes", "names"), MISTAKES, ids=[str(m[1]) for m in MISTAKES])
def test_mistake_in_a_row_is_named_with_its_line(row, changes, names, sheet):
    text = refuse_sheet(sheet(GOOD | {"condition": "first"}, row | changes))
    for name in ("line 3", "expected", "found", *names):
        assert name in text, f"{name!r} is not in: {text}"


def test_trial_that_stands_twice_is_refused(sheet):
    text = refuse_sheet(sheet(GOOD, RECORDED))
    assert "dummy/sine-0.3" in text
    assert "line 3" in text


def test_row_with_too_few_cells_is_refused(sheet):
    path = sheet(GOOD)
    path.write_text(path.read_text().replace("\t70\t", "\t"))
    assert "line 2" in refuse_sheet(path)


def test_sheet_without_trials_is_refused(sheet):
    assert "none" in refuse_sheet(sheet())


def test_missing_or_empty_sheet_is_refused(tmp_path):
    refuse_sheet(tmp_path / "none.tsv")
    (tmp_path / "empty.tsv").write_text("")
    refuse_sheet(tmp_path / "empty.tsv")


def test_sheet_that_ends_within_a_line_is_refused(sheet):
    path = sheet(GOOD)
    path.write_bytes(path.read_bytes()[:-3])
    assert "line break" in refuse_sheet(path)


def test_sheet_that_is_not_text_is_refused(sheet):
    path = sheet(GOOD)
    path.write_bytes(path.read_text().encode("utf-16"))
    refuse_sheet(path)


# ---- trials with a role, tables with columns of their own ---------------------------------------

ALL_COLUMNS = COLUMNS + OPTIONAL_COLUMNS
NO_EXTRAS = dict.fromkeys(OPTIONAL_COLUMNS, "-")
CALIBRATE = (
    dict.fromkeys(ALL_COLUMNS, "-")
    | {"experiment": "belt", "condition": "slow-1", "source": "recorded", "duration_s": "349"}
    | {"log": "slow1.txt", "role": "calibrate"}
    | {"time_column": "Time (s)", "load_column": "My (Nm)", "velocity_column": "Belt (m/s)"}
)
VALIDATE = CALIBRATE | {"condition": "slow-2", "log": "slow2.txt", "role": "validate"}


def test_roles_and_columns_are_read(sheet):
    path = sheet(CALIBRATE, VALIDATE, GOOD | NO_EXTRAS, columns=ALL_COLUMNS)
    trials = read_trial_sheet(path, "/data")
    assert [row.role for row in trials.values()] == ["calibrate", "validate", None]
    assert trials["belt", "slow-2"].names == {
        "files.columns.time": "Time (s)",
        "files.columns.load": "My (Nm)",
        "files.columns.velocity": "Belt (m/s)",
    }
    assert trials["belt", "slow-2"].files == {"log": "/data/slow2.txt"}
    assert trials["dummy", "sine-0.3"].names == {}


def test_sheet_of_other_experiments_needs_no_optional_column(sheet):
    row = read_trial_sheet(sheet(GOOD), ".")["dummy", "sine-0.3"]
    assert (row.role, row.names) == (None, {})


ROLE_MISTAKES = [
    (VALIDATE, {"role": "calibrat"}, ["'calibrat'", "did you mean 'calibrate'?"]),
    (VALIDATE, {"role": "-"}, ["role", "belt/slow-2", "'-'"]),
    (VALIDATE, {"role": ""}, ["role", "belt/slow-2"]),
    (VALIDATE, {"time_column": "-"}, ["time_column", "belt/slow-2"]),
    (VALIDATE, {"load_column": ""}, ["load_column"]),
    (VALIDATE, {"velocity_column": "-"}, ["velocity_column"]),
    (VALIDATE, {"velocity_column": "My (Nm)"}, ["load_column and velocity_column", "'My (Nm)'"]),
    (VALIDATE, {"log": "-"}, ["log file", "belt/slow-2"]),
    (VALIDATE, {"source": "virtual_lab", "log": "-"}, ["belt", "recorded"]),
    (GOOD | NO_EXTRAS, {"role": "calibrate"}, ["role", "dummy", "'calibrate'"]),
    (GOOD | NO_EXTRAS, {"load_column": "My (Nm)"}, ["load_column", "dummy", "'My (Nm)'"]),
]


@pytest.mark.parametrize(("row", "changes", "names"), ROLE_MISTAKES, ids=[str(m[1]) for m in ROLE_MISTAKES])
def test_mistake_in_a_role_or_column_is_named_with_its_line(row, changes, names, sheet):
    text = refuse_sheet(sheet(CALIBRATE, row | changes, columns=ALL_COLUMNS))
    for name in ("line 3", "expected", "found", *names):
        assert name in text, f"{name!r} is not in: {text}"


@pytest.mark.parametrize("missing", ["role", "time_column", "load_column", "velocity_column"])
def test_optional_column_that_a_treadmill_needs_is_named(missing, sheet):
    columns = [name for name in ALL_COLUMNS if name != missing]
    text = refuse_sheet(sheet(CALIBRATE, VALIDATE, columns=columns))
    assert missing in text
    assert "found no such column" in text


def test_optional_column_that_stands_twice_is_refused(sheet):
    assert "'role'" in refuse_sheet(sheet(columns=[*ALL_COLUMNS, "role"]))


def test_misspelt_optional_column_is_named_with_the_one_that_was_meant(sheet):
    columns = [name.replace("load_column", "load_colum") for name in ALL_COLUMNS]
    assert "'load_colum': did you mean 'load_column'?" in refuse_sheet(sheet(columns=columns))


@pytest.mark.parametrize("role", ["calibrate", "validate"])
def test_treadmill_without_trials_of_a_role_is_refused(role, sheet):
    rows = [row | {"role": {"calibrate": "validate"}.get(role, "calibrate")} for row in (CALIBRATE, VALIDATE)]
    text = refuse_sheet(sheet(*rows, columns=ALL_COLUMNS))
    assert f"trial of belt with the role {role}, found none" in text


def test_validation_on_the_recording_that_calibrated_is_refused(sheet):
    text = refuse_sheet(sheet(VALIDATE | {"log": "slow1.txt"}, CALIBRATE, columns=ALL_COLUMNS))
    assert "belt/slow-2" in text
    assert "slow1.txt" in text


@pytest.fixture
def plate_sheet(sheet, monkeypatch):
    """A sheet with recordings of the empty and the loaded plate in the given roles."""
    for experiment in ("empty", "weight"):
        log_only = replace(EXPERIMENTS[experiment], raw_files={"log": "log.mat"})
        monkeypatch.setitem(EXPERIMENTS, experiment, log_only)

    def write(empty=(), weight=()):
        rows = [
            RECORDED
            | NO_EXTRAS
            | {
                "experiment": experiment,
                "condition": f"{number}",
                "role": role,
                "log": f"{experiment}{number}",
            }
            for experiment, roles in (("empty", empty), ("weight", weight))
            for number, role in enumerate(roles)
        ]
        return sheet(*rows, columns=ALL_COLUMNS)

    return write


@pytest.mark.parametrize(
    ("empty", "weight"),
    [
        (["calibrate", "validate"], ["calibrate", "validate"]),
        (["calibrate"], ["calibrate", "validate"]),
        (["calibrate", "validate"], []),
        ([], ["calibrate", "validate"]),
    ],
)
def test_roles_of_the_empty_and_loaded_plate_count_together(empty, weight, plate_sheet):
    trials = read_trial_sheet(plate_sheet(empty, weight), ".")
    assert len(trials) == len(empty) + len(weight)


@pytest.mark.parametrize(
    ("empty", "weight", "said"),
    [
        (["validate"], ["calibrate", "validate"], "trial of empty with the role calibrate"),
        (["calibrate", "validate"], ["validate"], "trial of weight with the role calibrate"),
        (["calibrate"], ["calibrate"], "trial of weight with the role validate"),
        (["calibrate", "validate"], ["calibrate"], "trial of weight with the role validate"),
        ([], ["calibrate"], "trial of weight with the role validate"),
        (["calibrate", "validate"], ["-"], "expected a role of calibrate or validate for weight/0"),
    ],
)
def test_role_that_the_empty_or_loaded_plate_lacks_is_named(empty, weight, said, plate_sheet):
    assert said in refuse_sheet(plate_sheet(empty, weight))


def test_weight_without_the_empty_belt_is_refused(plate_sheet):
    for there, missing in (("weight", "empty"), ("empty", "weight")):
        path = plate_sheet(**{there: ["calibrate", "validate"]})
        with pytest.raises(InputError) as caught:
            check_sources(read_trial_sheet(path, "."), path, None)
        assert_one_sentence(caught.value, path, f"trials of {missing} beside those of {there}")


def test_trial_to_be_made_without_a_laboratory_is_refused(sheet):
    path = sheet(GOOD)
    trials = read_trial_sheet(path, ".")
    check_sources(trials, path, "config/virtual_lab.yaml")
    with pytest.raises(InputError) as caught:
        check_sources(trials, path, None)
    assert_one_sentence(caught.value, path, "dummy/sine-0.3", "study.virtual_lab is null")


# ---- a person who is told something, perturbed at random -----------------------------------------

STANDING = (
    dict.fromkeys(ALL_COLUMNS, "-")
    | {"experiment": "standing", "condition": "relax-pos-0.4", "source": "virtual_lab", "profile": "sine"}
    | {"amplitude": "0.4", "interval_s": "4-8", "duration_s": "65", "task": "relax"}
)
RECORDED_STANDING = (
    RECORDED
    | NO_EXTRAS
    | {"experiment": "standing", "condition": "own", "emg": "porti.edf", "task": "eyes-closed"}
)


def test_task_interval_and_electromyograms_are_read(sheet):
    rows = [STANDING, STANDING | {"condition": "even", "interval_s": "5", "task": "stiff"}, RECORDED_STANDING]
    trials = read_trial_sheet(sheet(*rows, GOOD | NO_EXTRAS, columns=ALL_COLUMNS), "/data")
    made, even, own, dummy = trials.values()
    assert (made.task, made.interval_s, made.longest_interval_s) == ("relax", 4.0, 8.0)
    assert (even.task, even.interval_s, even.longest_interval_s) == ("stiff", 5.0, 5.0)
    assert (own.task, own.interval_s, own.longest_interval_s) == ("eyes-closed", None, None)
    assert own.files == {
        "log": "/data/log.mat",
        "calibration": "/data/plate.csv",
        "markers": "/data/markers.c3d",
        "emg": "/data/porti.edf",
    }
    assert (dummy.task, dummy.interval_s, dummy.longest_interval_s) == (None, 4.0, 4.0)


@pytest.mark.parametrize("interval", ["3.5-3.5", "0.5-12", "4.0-8.0"])
def test_interval_from_short_to_long_is_read(interval, sheet):
    path = sheet(STANDING | {"interval_s": interval}, columns=ALL_COLUMNS)
    row = read_trial_sheet(path, ".")["standing", "relax-pos-0.4"]
    assert [row.interval_s, row.longest_interval_s] == [float(part) for part in interval.split("-")]


STANDING_MISTAKES = [
    (STANDING, {"interval_s": "four-8"}, ["interval_s", "'four'"]),
    (STANDING, {"interval_s": "4-eight"}, ["interval_s", "'eight'"]),
    (STANDING, {"interval_s": "4-"}, ["interval_s", "''"]),
    (STANDING, {"interval_s": "-8"}, ["interval_s", "'-8'"]),
    (STANDING, {"interval_s": "4-8-12"}, ["interval_s", "'8-12'"]),
    (STANDING, {"interval_s": "0-8"}, ["interval_s", "'0'"]),
    (STANDING, {"interval_s": "4-nan"}, ["interval_s", "'nan'"]),
    (STANDING, {"interval_s": "-"}, ["interval_s"]),
    (GOOD | NO_EXTRAS, {"interval_s": "4-8"}, ["interval_s", "'4-8'"]),
    (STANDING, {"profile": "minjerk"}, ["sine, negative-sine", "'minjerk'"]),
    (STANDING, {"task": ""}, ["task of relax or stiff", "the instruction of the person"]),
    (STANDING, {"task": "relaxed"}, ["task of relax or stiff", "'relaxed'"]),
    (STANDING, {"emg": "emg.edf"}, ["'emg.edf'", "recorded"]),
    (RECORDED_STANDING, {"task": "eyes closed"}, ["letters, digits, dots and hyphens", "'eyes closed'"]),
    (RECORDED_STANDING, {"task": "-"}, ["letters, digits, dots and hyphens", "standing/own"]),
    (RECORDED_STANDING, {"markers": "-"}, ["markers file", "standing/own"]),
]


@pytest.mark.parametrize(
    ("row", "changes", "names"), STANDING_MISTAKES, ids=[str(m[1]) for m in STANDING_MISTAKES]
)
def test_mistake_in_a_standing_persons_row_is_named_with_its_line(row, changes, names, sheet):
    first = STANDING | {"condition": "first"}
    text = refuse_sheet(sheet(first, row | changes, columns=ALL_COLUMNS))
    for name in ("line 3", "expected", "found", *names):
        assert name in text, f"{name!r} is not in: {text}"


def test_condition_that_has_the_name_of_a_task_is_refused(sheet):
    rows = [STANDING, STANDING | {"condition": "relax", "task": "stiff"}]
    text = refuse_sheet(sheet(*rows, columns=ALL_COLUMNS))
    assert "different names" in text
    assert "found 'relax' for both" in text
    assert len(read_trial_sheet(sheet(STANDING, columns=ALL_COLUMNS), ".")) == 1


def test_optional_column_that_a_standing_person_needs_is_named(sheet):
    text = refuse_sheet(sheet(STANDING, columns=[name for name in ALL_COLUMNS if name != "task"]))
    assert "no such column" in text
    assert "task" in text


def test_a_standing_person_may_have_no_electromyograms(sheet):
    without = [name for name in ALL_COLUMNS if name != "emg"]
    for path in (
        sheet(RECORDED_STANDING | {"emg": "-"}, columns=ALL_COLUMNS),
        sheet(RECORDED_STANDING, columns=without),
    ):
        (row,) = read_trial_sheet(path, ".").values()
        assert sorted(row.files) == ["calibration", "log", "markers"]


def test_models_of_a_treadmill_that_was_never_measured_are_refused_in_one_sentence(config):
    with pytest.raises(InputError) as caught:
        check_plate_models(config, "my-study")
    names = ("standing.pathways.ankle-compensated", "'best-frame'", "weight and empty", "null")
    assert_one_sentence(caught.value, "my-study", *names)
    for pathway in config["standing"]["pathways"].values():
        pathway["treadmill_model"] = None
    check_plate_models(config, "my-study")


# ---- models of the treadmill ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"belt": {"chosen": "fir-quick"}}, "expected belt.chosen to name one of"),
        ({"belt": {"models": {"family": ["loaded-frame"]}, "chosen": "loaded-frame"}}, "'loaded-frame'"),
        (
            {"weight": {"models": {"family": ["fir", "loaded-frame", "bristle-frame", "ripple-tracking"]}}},
            "'ripple-tracking'",
        ),
        ({"weight": {"models": {"family": ["fir"]}}}, "dummy.foot.pathways.foot-compensated-short"),
        (
            {"weight": {"analysis": {"other_cutoffs_hz": [10.0, 125.0]}}},
            "expected weight.analysis.other_cutoffs_hz below",
        ),
        ({"belt": {"analysis": {"zero_lag": True, "lowpass_order": 3}}}, "expected an even"),
    ],
)
def test_models_that_cannot_be_fitted_are_refused_before_the_run(changes, said, refused):
    assert said in refused(changes)


# ---- one treadmill for all that is on it --------------------------------------------------------


def test_what_the_plate_treadmill_says_is_said_to_each_of_its_experiments(config):
    config["plate_treadmill"] |= {
        "belt": "left",
        "resample_rate_hz": 200.0,
        "lowpass_cutoff_hz": 15.0,
        "lowpass_order": 2,
    }
    settings = settings_of(config)
    for name in ("dummy", "weight", "empty", "standing"):
        assert settings[name]["ingest"]["resample_rate_hz"] == 200.0
    for name in ("dummy", "weight", "standing"):
        assert settings[name]["belt"] == "left"
        assert settings[name]["analysis"]["lowpass_order"] == 2
    for name in ("dummy", "standing"):
        assert settings[name]["analysis"]["lowpass_cutoff_hz"] == 15.0
    assert settings["weight"]["analysis"]["cutoffs_hz"] == [15.0, 10.0]
    assert settings["empty"]["ingest"] == {
        "resample_rate_hz": 200.0,
        "max_gap_s": None,
        "marker_sampling_hz": None,
        "trigger_threshold_V": 2.5,
    }
    assert settings["wristalyzer"] == config["wristalyzer"]


def test_settings_are_a_copy(config):
    before = copy.deepcopy(config)
    settings_of(config)["dummy"]["analysis"]["merge_s"] = 1.0
    assert config == before


@pytest.mark.parametrize(("name", "other"), [("dummy", "standing"), ("standing", "dummy")])
def test_an_exception_holds_for_its_experiment_alone(name, other, config, root):
    own = {"belt": "left", "resample_rate_hz": 200.0, "lowpass_cutoff_hz": 15.0, "lowpass_order": 2}
    config["plate_treadmill"]["exceptions"] = {name: own}
    check_config(config, "my-study")
    settings = settings_of(config)
    assert settings[name]["belt"] == "left"
    assert settings[name]["ingest"]["resample_rate_hz"] == 200.0
    assert settings[name]["analysis"]["lowpass_cutoff_hz"] == 15.0
    assert settings[name]["analysis"]["lowpass_order"] == 2
    assert settings[other]["belt"] == "right"
    assert settings[other]["ingest"]["resample_rate_hz"] == 250.0
    assert settings[other]["analysis"]["lowpass_cutoff_hz"] == 20.0


@pytest.mark.parametrize(
    "own",
    [{"belt": "left"}, {"resample_rate_hz": 200.0}, {"lowpass_cutoff_hz": 15.0}, {"lowpass_order": 2}],
    ids=lambda own: next(iter(own)),
)
@pytest.mark.parametrize("name", ["dummy", "standing"])
def test_models_of_the_treadmill_allow_no_exception(name, own, config):
    ((key, value),) = own.items()
    config["plate_treadmill"]["exceptions"] = {name: own}
    with pytest.raises(InputError) as caught:
        check_one_treadmill(config, ["weight", "empty", name], "my-study")
    assert_one_sentence(
        caught.value, "my-study", f"plate_treadmill.{key}", f"exceptions.{name}", str(value), "weight"
    )
    check_one_treadmill(config, ["dummy", "standing"], "my-study")
    check_one_treadmill(config, ["weight", "empty"], "my-study")
    config["plate_treadmill"]["exceptions"] = {name: only(config["plate_treadmill"], key)}
    check_one_treadmill(config, ["weight", "empty", name], "my-study")


def test_parts_of_a_section_are_taken_by_their_keys():
    section = {"a": 1, "b": {"c": 2, "d": 3}, "e": 4}
    assert only(section, "e", "a") == {"a": 1, "e": 4}
    assert without(section, "a", "x") == {"b": {"c": 2, "d": 3}, "e": 4}
    assert pick(section, "a", "b.d") == {"a": 1, "b": {"d": 3}}
    assert pick(section, "b", "-b.c", "e") == {"b": {"d": 3}, "e": 4}
    muscles = {"of": {"TA": {"acts": -1, "channel": 1}, "SOL": {"acts": 1, "channel": 2}}}
    assert pick(muscles, "of.*.acts") == {"of": {"TA": {"acts": -1}, "SOL": {"acts": 1}}}
    assert pick({"of": {}}, "of.*.acts") == {"of": {}}
    for path in ("b.x", "-b.x"):
        with pytest.raises(KeyError):
            pick(section, path)
    assert section == {"a": 1, "b": {"c": 2, "d": 3}, "e": 4}


# ---- what a script reaches ---------------------------------------------------------------------


def test_modules_are_followed_through_imports_and_no_further(tmp_path):
    files = {
        "lib/__init__.py": "",
        "lib/one.py": "from lib.sub.two import f\n",
        "lib/sub/__init__.py": "",
        "lib/sub/two.py": "def f():\n    import lib.three\n",
        "lib/three.py": "import json, numpy\nfrom lib import (\n    four,  # the last\n)\n",
        "lib/four.py": "",
        "lib/unused.py": "import lib.one\n",
        "scripts/run.py": "import helper\nfrom lib.one import g\n",
        "scripts/helper.py": "import os\n",
        "scripts/other.py": "import lib.unused\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert reached_by("scripts/run.py", str(tmp_path)) == [
        "lib/__init__.py",
        "lib/four.py",
        "lib/one.py",
        "lib/sub/__init__.py",
        "lib/sub/two.py",
        "lib/three.py",
        "scripts/helper.py",
    ]


def test_ingest_reaches_its_readers_and_no_estimator(root):
    scripts = ("workflow/scripts/ingest.py", "tepsipe/experiments/dummy/ingest.py")
    reached = {path for script in scripts for path in reached_by(script, str(root))}
    for name in ("ingest/plate_treadmill", "signals/resampling", "io/formats", "io/trial", "errors"):
        assert f"tepsipe/{name}.py" in reached
    assert "workflow/scripts/job.py" in reached
    for name in ("identification/admittance_fit", "identification/window_regression", "reporting/claims"):
        assert f"tepsipe/{name}.py" not in reached
    assert not [path for path in reached if "virtual_lab" in path]


def test_fit_reaches_what_its_modules_import(root):
    scripts = ("workflow/scripts/fit.py", "tepsipe/experiments/wristalyzer/fit.py")
    reached = {path for script in scripts for path in reached_by(script, str(root))}
    for name in (
        "experiments/wristalyzer/analysis",
        "identification/admittance_fit",
        "signals/spectra",
        "mechanics/impedance_model",
        "signals/filters",
        "statistics/goodness_of_fit",
    ):
        assert f"tepsipe/{name}.py" in reached
    assert "tepsipe/ingest/plate_treadmill.py" not in reached


# ---- version -----------------------------------------------------------------------------------


def test_folder_that_is_no_checkout_has_no_version(tmp_path):
    assert code_version(str(tmp_path)) == {"commit": None, "date": None, "modified": None}
