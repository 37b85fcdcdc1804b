"""What a study holds, shows and makes: look-ups on its trials, without Snakemake."""

import ast
import re

import pytest

from tepsipe.experiments.dummy import foot_pathways, leg_pathways
from tepsipe.experiments.noise import filtered_noise
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.experiments.standing import joint_torque
from tepsipe.experiments.standing.muscle_torque import ACTIVE
from tepsipe.identification.estimators import ESTIMATORS
from tepsipe.mechanics.engines import ENGINES
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS
from tepsipe.signals import onsets
from tepsipe.treadmill import registry
from workflow.settings.check import kind_at, names_of
from workflow.settings.complete import pick
from workflow.settings.config import Config
from workflow.settings.dummy import ABOUT_ESTIMATORS
from workflow.support import outputs, report_params
from workflow.support.captions import captions_of, read_captions
from workflow.support.lookups.thesis import table_experiment
from workflow.support.origins import Sources, function_of
from workflow.support.parts import APPENDIX, OF_APPENDIX, PARTS
from workflow.support.study import Study, any_of
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS, TrialRow, read_trial_sheet


@pytest.fixture
def shipped(config, root):
    return Study(config, read_trial_sheet(root / config["study"]["trial_sheet"], "."))


def row(experiment, condition, source="recorded", profile="-", amplitude=None, role=None, task=None):
    files = {} if source == "virtual_lab" else {"log": f"{condition}.mat"}
    return TrialRow(experiment, condition, source, profile, amplitude, 4.0, 8.0, 60.0, files, role, task, {})


@pytest.fixture
def study_of(config):
    def build(*rows):
        return Study(config, {(r.experiment, r.condition): r for r in rows})

    return build


# ---- the table of experiments --------------------------------------------------------------------


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_experiment_has_columns_and_settings_for_its_facts(name, config):
    experiment = EXPERIMENTS[name]
    assert name in config
    assert set(experiment.raw_files) <= set(COLUMNS + OPTIONAL_COLUMNS)
    assert set(experiment.optional_files) <= set(experiment.raw_files)
    assert set(experiment.named) <= set(experiment.names) <= set(OPTIONAL_COLUMNS)


def test_every_figure_is_drawn_by_the_function_of_its_experiment_or_part(shipped, root):
    sources = Sources(root)
    for name in [*EXPERIMENTS, *PARTS]:
        figures = outputs.figures_of(shipped, name)
        module, function = sources.rule_of_figure(figures[0]).drawn_by if figures else ("", "")
        text = ast.unparse(function_of(root / module, function)) if figures else ""
        drawn = set(re.findall(r"yield \('(figure_\w+)',", text))
        if name == "budgets":
            assert "yield (f'figure_budget_{name}'" in text
            drawn = {f"figure_budget_{name}" for name in outputs.budget_names(shipped)}
        assert drawn == set(figures) - set(APPENDIX), name


def test_every_caption_is_used_and_there(shipped, root):
    figures = {figure for name in [*EXPERIMENTS, *PARTS] for figure in outputs.figures_of(shipped, name)}
    used = {OF_APPENDIX if figure in APPENDIX else figure for figure in figures}
    captions = read_captions(root / "report/captions.yaml")
    assert used == {name for name in captions if name.startswith("figure_")}
    assert used.union(outputs.tables(shipped)) <= set(captions)
    for name, caption in captions.items():
        # the index shows captions as plain text with literals
        assert not re.search(r"[`*{}|]|_\b|\.\. ", re.sub(r"``[^`]+``", "", caption)), name


def test_constants_that_are_compared_are_in_the_laboratory(shipped, shipped_truth):
    paths = sorted({path for name in shipped.experiments for path in EXPERIMENTS[name].true})
    joint = {key: shipped_truth["dummy"]["subject"][key] for key in ("joint_inertia_kgm2",)}
    assert pick(shipped_truth, *paths)["dummy"] == {
        "rubber": shipped_truth["dummy"]["rubber"],
        "subject": joint,
    }


# ---- the study as shipped --------------------------------------------------------------------------


def test_shipped_study_has_all_that_the_laboratory_can_make(shipped):
    assert shipped.experiments == ["wristalyzer", "dummy", "weight", "empty", "standing"]
    of_recordings = {"participants", "operating_points", "time_varying"}
    assert all(shipped.has(name) for name in {*shipped.experiments, *PARTS} - of_recordings)
    assert not any(map(shipped.has, of_recordings))
    assert not shipped.has("belt")
    for name in shipped.experiments:
        assert shipped.simulated(name) == shipped.conditions(name)
    assert list(shipped.all_conditions(fitted=True)) == shipped.experiments


def test_outputs_of_the_shipped_study(shipped):
    everything = outputs.everything(shipped)
    assert len(everything) == len(set(everything))
    figures = outputs.figures(shipped)
    names = {name for own in outputs.shown(shipped) for name in captions_of(own)} - {OF_APPENDIX}
    assert sorted(figures) == sorted(f"<results>/figures/{name}.svg" for name in names.union(APPENDIX))
    assert outputs.budget_names(shipped) == ["wristalyzer", "dummy", "foot", "weight", "standing"]
    assert shipped.estimators.budgeted_foot() == "foot-compensated"
    # trials of the manipulator and all of them together, of the dummy, its foot, the weight, and the
    # person, her tasks and their difference
    assert len(outputs.budgets(shipped)) == 5 + 1 + 12 + 12 + 13 + 16 + 2 + 1
    assert "<results>/figures/figure_b_12.svg" in figures
    assert len(outputs.standing_figures(shipped)) == 32
    assert len(outputs.pages(shipped)) == 56
    assert "<results>/report/trials/dummy/sine-0.3.html" in outputs.pages(shipped)
    shown = [name for own in outputs.shown(shipped) for name in outputs.figures_of(shipped, own)]
    assert sorted(f"<results>/figures/{name}.svg" for name in shown) == sorted(figures)
    tables = [name.removesuffix(".csv").rpartition("/")[2] for name in everything if name.endswith(".csv")]
    assert set(outputs.tables(shipped)) == set(tables)
    assert len(outputs.fits(shipped)) == len(outputs.trials(shipped)) == 56
    # every trial, the foot's side, two tasks and their difference, the manipulator's trials together, two
    # cross-validations
    assert len(outputs.estimates(shipped)) == 56 + 12 + 3 + 1 + 2
    assert outputs.thesis_tables(shipped) == [f"<results>/tables/table_4_{n}.csv" for n in (1, 2, 3)]
    assert outputs.model_scores(shipped) == ["<results>/treadmill_models/plate.csv"]
    assert outputs.model_files(shipped, "belt") == []


def test_a_table_is_laid_out_from_its_own_experiment(shipped):
    assert [table_experiment(f"table_4_{n}") for n in (1, 2, 3)] == ["wristalyzer", "dummy", "dummy"]
    assert shipped.thesis.conditions("table_4_1") == ["0.08", "0.12", "0.16", "0.20", "0.24"]
    assert {name.partition("-")[0] for name in shipped.thesis.conditions("table_4_3")} == {"minjerk"}
    files = outputs.estimates_of(shipped, "wristalyzer")
    assert files[-1] == "<results>/cross_validation/wristalyzer.csv"
    assert all("/wristalyzer" in path for path in files)
    assert len(files) == 6
    assert len(outputs.estimates_of(shipped, "standing")) == 16
    assert outputs.estimates_of(shipped, "belt") == []


def test_pairs_of_tasks_are_those_of_one_person_whatever_their_names(study_of, shipped):
    assert shipped.tasks.pairs() == {"stiff-relax": ("stiff", "relax")}
    own = [row("standing", name, task=name) for name in ("push", "calm", "relax")]
    assert set(study_of(*own).tasks.pairs()) == {"push-calm", "push-relax", "calm-relax"}
    assert study_of(own[0]).tasks.pairs() == {}


def test_tasks_of_the_shipped_person(shipped):
    assert shipped.tasks.names() == ["relax", "stiff"]
    assert list(shipped.tasks.groups()) == [
        "relax, sine",
        "relax, negative-sine",
        "stiff, sine",
        "stiff, negative-sine",
    ]
    compared = outputs.compared(shipped)
    constants = [compared[f"standing{name}"].constants for name in ("/relax-pos-0.4", "_tasks/relax")]
    assert constants == ["standing/relax", "standing/relax"]
    assert len(compared["standing_tasks/stiff"].motions) == len(compared["standing_tasks/stiff"].fits) == 8
    assert len(shipped.tasks.of_trials("<results>/{condition}.h5", "stiff")) == 8


def test_noise_study_has_one_trial_of_every_profile_and_amplitude(shipped):
    names = shipped.noise.conditions()
    assert len(names) == 10
    assert "sine-0.5-8s" not in names
    assert shipped.noise.averaged() == [name for name in names if name.startswith("sine")]
    assert shipped.noise.same_profile("minjerk-0.3") == [name for name in names if name.startswith("minjerk")]


def test_printed_settings_are_those_of_experiments_and_parts_in_the_study(shipped, study_of):
    printed = report_params.printed(shipped)
    assert list(printed) == [*shipped.experiments, "noise"]
    assert printed["weight"] == {
        "weight": {"mass_kg": 20.0},
        "further_weights": [{"mass_kg": 60.0, "com_height_m": 0.15, "com_forward_of_markers_m": 0.0}],
        "analysis": {"cutoffs_hz": [20.0, 10.0], "segment_s": 0.3},
    }
    assert printed["empty"] == {}
    assert list(report_params.printed(study_of(row("belt", "a", role="calibrate")))) == ["belt"]


def test_protocols_have_durations_intervals_and_amplitudes_of_the_trial_sheet(shipped):
    timing = shipped.timing()
    assert timing["dummy"] == {
        "durations_s": [70.0],
        "intervals_s": [[4.0, 4.0], [8.0, 8.0]],
        "amplitudes": [0.1, 0.2, 0.3, 0.4, 0.5],
    }
    assert timing["standing"]["intervals_s"] == [[4.0, 8.0]]
    assert timing["wristalyzer"]["intervals_s"] == []


def test_other_laws_are_simulated_for_the_smallest_and_the_largest_pulses(shipped, study_of):
    assert shipped.extremes("dummy") == ["sine-0.1", "sine-0.5"]
    assert outputs.other_laws(shipped) == ["<results>/tables/other_laws.csv"]
    assert "<results>/tables/other_laws.csv" in outputs.everything(shipped)
    made = [row("dummy", name, "virtual_lab", "sine", size) for name, size in (("b", 0.2), ("a", 0.2))]
    assert study_of(*made, row("dummy", "c", amplitude=0.1)).extremes("dummy") == ["b"]
    recorded = study_of(row("dummy", "c", amplitude=0.1))
    assert recorded.extremes("dummy") == outputs.other_laws(recorded) == []


# ---- other studies ---------------------------------------------------------------------------------


def test_study_without_weight_and_wristalyzer_has_neither_foot_nor_simulation(study_of):
    study = study_of(row("dummy", "a"), row("dummy", "b"), row("dummy", "sine-1"))
    assert [name for name in PARTS if study.has(name)] == ["rigs", "budgets"]
    assert outputs.budget_names(study) == ["dummy"] and study.estimators.budgeted_foot() is None
    names = [outputs.forward, outputs.noise, outputs.model_scores, outputs.task_fits]
    assert [files(study) for files in names] == [[]] * 4
    assert outputs.plate_models(study, "dummy", "a") == []
    assert outputs.specification(study) == ["<results>/tables/specification.csv"]
    assert study.thesis.tables() == {"table_4_2": "dummy"}
    assert [name for name in outputs.figures_of(study, "simulation") if name in APPENDIX] == list(
        APPENDIX[:3]
    )
    assert not [path for path in outputs.figures(study) if "figure_b_" in path]


def test_appendix_has_no_more_than_twelve_figures_of_trials(study_of):
    study = study_of(row("wristalyzer", "1"), *[row("dummy", f"d{k}") for k in range(14)])
    figures = outputs.figures_of(study, "simulation")
    assert [name for name in figures if name in APPENDIX] == list(APPENDIX)
    assert "figure_b_13" in figures


def test_study_of_a_treadmill_has_models_and_no_fits(study_of):
    study = study_of(row("belt", "a", role="calibrate"), row("belt", "b", role="validate"))
    assert outputs.fits(study) == outputs.estimates(study) == []
    assert outputs.model_files(study, "belt") == [
        "<results>/fits/belt.h5",
        "<results>/treadmill_models/belt.csv",
    ]
    assert outputs.models(study) == ["<results>/tables/treadmill_models.csv"]
    assert study.roles("belt") == {"a": "calibrate", "b": "validate"}


def test_fits_are_in_the_order_in_which_they_are_read_where_a_sheet_mixes_experiments(study_of):
    study = study_of(row("dummy", "a"), row("wristalyzer", "1"), row("dummy", "b"))
    paths = iter(outputs.fits(study))
    for experiment, conditions in study.all_conditions(fitted=True).items():
        for condition in conditions:
            assert next(paths) == f"<results>/fits/{experiment}/{condition}.h5"
    assert next(paths, None) is None


def test_truth_is_wanted_of_what_was_made_alone(study_of):
    study = study_of(row("dummy", "own"), row("weight", "w", "virtual_lab"))
    assert study.all_simulated() == {"dummy": [], "weight": ["w"]}
    assert outputs.comparison_of(study, "dummy", "own") == []
    assert outputs.comparison_of(study, "weight", "w") == ["<results>/recovery/weight/w.csv"]
    assert outputs.compared(study) == {
        "weight/w": outputs.Compared("weight", "weight", ["<results>/estimates/weight/w.csv"])
    }


def test_task_counts_as_made_only_if_all_of_its_trials_are(study_of):
    study = study_of(
        row("standing", "a", "virtual_lab", "sine", task="relax"),
        row("standing", "b", task="relax"),
        row("standing", "c", "virtual_lab", "sine", task="stiff"),
    )
    assert {name: own.constants for name, own in outputs.compared(study).items()} == {
        "standing/a": "standing/relax",
        "standing/c": "standing/stiff",
        "standing_tasks/stiff": "standing/stiff",
    }
    assert list(study.tasks.groups()) == ["relax, sine", "relax", "stiff, sine"]


def test_condition_that_is_not_there_gives_way_to_the_last_of_the_sheet(study_of):
    study = study_of(
        row("weight", "a", role="calibrate"),
        row("weight", "b", role="validate"),
        row("weight", "c", role="calibrate"),
    )
    assert study.shown("weight", "a") == "a"
    assert study.shown("weight", "x") == "c"
    assert study.shown("weight", "a", role="validate") == "b"
    assert study.shown("dummy", "x") == "x"
    assert study.shown_several("weight", ["c", "a", "x"]) == ["a", "c"]
    assert study.shown_several("weight", ["x"]) == ["a", "b", "c"]


def test_raw_files_of_made_trials_are_below_the_results_and_recordings_are_no_inputs(study_of, tmp_path):
    study = study_of(row("empty", "m", "virtual_lab"), row("dummy", "own"))
    made = {"log": "out/raw/empty/m/log.mat", "calibration": "out/raw/empty/m/calibration.csv"}
    assert study.raw_files("empty", "m", "out") == made
    assert study.raw_inputs("empty", "m", "out") == list(made.values())
    assert study.raw_files("dummy", "own", "out") == {"log": "own.mat"}
    assert study.raw_inputs("dummy", "own", "out") == []


def test_protocol_has_one_interval_or_a_range(study_of):
    study = study_of(
        row("dummy", "d", "virtual_lab", "sine", 0.3),
        row("standing", "s", "virtual_lab", "negative-sine", 0.2, task="relax"),
    )
    assert study.protocol("dummy", "d") == {
        "profile": "sine",
        "amplitude_m_per_s": 0.3,
        "interval_s": 4.0,
        "duration_s": 60.0,
    }
    assert study.protocol("standing", "s")["interval_s"] == (4.0, 8.0)


def test_expression_for_names_finds_these_and_no_others():
    pattern = re.compile(any_of(["0.1", "0.12", "a-b"]))
    assert all(pattern.fullmatch(name) for name in ("0.1", "0.12", "a-b"))
    assert not any(pattern.fullmatch(name) for name in ("0x1", "0.1.2", "a", ""))
    assert not re.compile(any_of([])).fullmatch("")


# ---- the library's names in the model of the configuration ------------------------------------------


@pytest.mark.parametrize(
    ("path", "names"),
    [
        ("dummy.pathways.*.torque", TORQUE_PATHWAYS),
        ("dummy.pathways.*.marker_instants", leg_pathways.MARKER_SIGNALS),
        ("dummy.foot.pathways.*.torque", foot_pathways.FOOT_TORQUES),
        ("standing.pathways.*.torque", joint_torque.TORQUES),
        ("standing.estimators.*.active", ACTIVE),
        ("standing.latency.detector", onsets.DETECTORS),
        ("noise.estimators.*", filtered_noise.PROCESSINGS),
        ("weight.models.family.*", registry.FAMILY),
        ("dummy.simulation.engine", [*ENGINES, "auto"]),
    ],
)
def test_model_knows_the_names_that_the_library_knows(path, names):
    assert set(names_of(kind_at(Config, tuple(path.split("."))))) == set(names)


def test_every_estimator_is_documented(root):
    text = (root / "config/README.md").read_text(encoding="utf-8")
    for name, estimator in ESTIMATORS.items():
        assert f"| {name} | | {estimator.meaning}" in text, name
    assert set(ABOUT_ESTIMATORS) <= set(ESTIMATORS)
