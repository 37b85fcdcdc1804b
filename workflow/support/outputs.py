"""Output files of a study, as named by its rules."""

from workflow.support.captions import captions_of
from workflow.support.experiments import APPENDIX, EXPERIMENTS, OF_APPENDIX, PARTS
from workflow.support.study import Study


def shown(study: Study) -> list[str]:
    """Experiments and parts of the study, in the order in which their figures are shown."""
    return study.experiments + [name for name in PARTS if study.has(name)]


def figures_of(study: Study, name: str) -> list[str]:
    """Figures of an experiment or part; of Figures B-1 to B-12 as many as there are trials."""
    left_out, found = _without_budget(study), []
    for caption in captions_of(name):
        figures = APPENDIX[: len(study.conditions("dummy"))] if caption == OF_APPENDIX else (caption,)
        found += [figure for figure in figures if figure not in left_out]
    return found


BUDGET = "figure_budget_"


def budget_names(study: Study) -> list[str]:
    """What of the study has a figure of its uncertainty budget: experiments, and the foot."""
    names = [figure.removeprefix(BUDGET) for figure in captions_of("budgets")]
    return [name for name in names if study.has(name)]


def _without_budget(study: Study) -> list[str]:
    """Figures of budgets of what the study does not have."""
    shown = [f"{BUDGET}{name}" for name in budget_names(study)]
    return [figure for figure in captions_of("budgets") if figure not in shown]


def figures(study: Study) -> list[str]:
    """Every figure of the study's experiments and parts."""
    return [f"<results>/figures/{figure}.svg" for name in shown(study) for figure in figures_of(study, name)]


def with_numbers(figures: dict, folder: str = "<results>/figures") -> dict:
    """Named outputs of figures (name -> SVG), with those of their PNG and of the numbers that they show."""
    kinds = ("png", "csv")
    return figures | {f"{name}_{kind}": f"{folder}/{name}.{kind}" for name in figures for kind in kinds}


def standing_figures(study: Study) -> list[str]:
    """Figures 4-13 and 4-14 of every trial of the standing person."""
    names = ("4_13", "4_14")
    return [
        f"<results>/figures/standing/{c}_{name}.png" for c in study.conditions("standing") for name in names
    ]


def trials(study: Study) -> list[str]:
    """HDF5 files of all trials."""
    return [f"<results>/trials/{e}/{c}.h5" for e, c in study.trials]


def fits(study: Study) -> list[str]:
    """Fits of all trials that have one, experiment by experiment."""
    return [f"<results>/fits/{e}/{c}.h5" for e, names in study.all_conditions(True).items() for c in names]


def estimates_of(study: Study, experiment: str) -> list[str]:
    """Rows of estimates of an experiment's trials, and of its cross-validation."""
    files = study.of_trials(f"<results>/estimates/{experiment}/{{condition}}.csv", experiment)
    crossed = files and EXPERIMENTS[experiment].cross_validated
    return files + ([f"<results>/cross_validation/{experiment}.csv"] if crossed else [])


def fits_of_table(study: Study, table: str) -> list[str]:
    """Fits of a table's conditions, with a standard error for each perturbation; of Table 4-1 none."""
    if table == "table_4_1":
        return []
    return [f"<results>/fits/dummy/{condition}.h5" for condition in study.thesis.conditions(table)]


def estimates(study: Study) -> list[str]:
    """Rows of estimates of all trials and tasks, then of cross-validations."""
    files = [f"<results>/estimates/{e}/{c}.csv" for e, c in study.trials if EXPERIMENTS[e].fitted]
    files += study.of_foot("<results>/estimates/foot/{condition}.csv")
    files += [f"<results>/estimates/{name}.csv" for name in _of_tasks(study)]
    crossed = [e for e in study.experiments if EXPERIMENTS[e].cross_validated]
    files += pooled_wristalyzer(study)[1:]
    return files + [f"<results>/cross_validation/{e}.csv" for e in crossed]


def budgets(study: Study) -> list[str]:
    """Uncertainty budgets of all trials that have one, in the order of `estimates`."""
    files = [f"<results>/uncertainty/{e}/{c}.csv" for e, c in study.trials if EXPERIMENTS[e].budgets]
    files += study.of_foot("<results>/uncertainty/foot/{condition}.csv")
    files += ["<results>/uncertainty/wristalyzer_pooled.csv"] if study.has("wristalyzer_pooled") else []
    return files + [f"<results>/uncertainty/{name}.csv" for name in _of_tasks(study)]


def _of_tasks(study: Study) -> list[str]:
    """Folder and name of what several trials of a standing person yield: tasks, then differences."""
    pairs = [f"standing_pairs/{pair}" for pair in study.tasks.pairs()]
    return [f"standing_tasks/{task}" for task in study.tasks.names()] + pairs


def pooled_wristalyzer(study: Study) -> list[str]:
    """The fit to all trials of the manipulator together, and its rows of estimates, if there is one."""
    if not study.has("wristalyzer_pooled"):
        return []
    return ["<results>/fits/wristalyzer_pooled.h5", "<results>/estimates/wristalyzer_pooled.csv"]


def task_fits(study: Study) -> list[str]:
    """Joint result of the trials of each task."""
    return [f"<results>/fits/standing_tasks/{task}.h5" for task in study.tasks.names()]


def plate_models(study: Study, experiment: str, condition: str) -> list[str]:
    """Models of the belt-induced force and moment of a trial's belts, if any: of Fy, then of Mx of each."""
    loads = ("Fy", "Mx") if study.has("weight") else ()
    plates = study.treadmill.plates_of(experiment, condition)
    return [f"<results>/treadmill_models/{plate}_{load}.json" for plate in plates for load in loads]


def held_out(study: Study, experiment: str, condition: str) -> list[str]:
    """Residuals on the belts of a trial that their treadmill models have not seen, if there are models."""
    plates = study.treadmill.plates_of(experiment, condition) if study.has("weight") else []
    return [f"<results>/treadmill_models/{plate}_held_out.h5" for plate in plates]


def plate_fits(study: Study) -> list[str]:
    """Responses of every calibration of the force plate, one per belt."""
    return [f"<results>/fits/{name}.h5" for name in study.treadmill.plates()] if study.has("weight") else []


def model_files(study: Study, experiment: str) -> list[str]:
    """Responses and scores of a calibration of treadmill models, for the report."""
    if not study.has(experiment):
        return []
    name = study.shown_plate() if experiment == "weight" else EXPERIMENTS[experiment].models
    return [f"<results>/fits/{name}.h5", f"<results>/treadmill_models/{name}.csv"]


def model_scores(study: Study) -> list[str]:
    """Scores of the force plate's models and of those of a recorded treadmill."""
    plates = study.treadmill.plates() if study.has("weight") else {}
    return [f"<results>/treadmill_models/{name}.csv" for name in plates] + model_files(study, "belt")[1:]


def belts_of_scores(study: Study) -> list[str]:
    """Belt of each file of `model_scores`, empty for a recorded treadmill; none if no belts are named."""
    if not study.by_belt:
        return []
    belts = list(study.treadmill.plates().values()) if study.has("weight") else []
    return belts + [""] * (len(model_scores(study)) - len(belts))


def models(study: Study) -> list[str]:
    """The table of the treadmill models, if any."""
    return ["<results>/tables/treadmill_models.csv"] if model_scores(study) else []


def thesis_tables(study: Study) -> list[str]:
    """The tables of the thesis, if the study has trials to compare."""
    return [f"<results>/tables/{name}.csv" for name in study.thesis.tables()]


def participants(study: Study) -> list[str]:
    """Tables of the participants and of the means over them, if the sheet names any."""
    names = ("participants", "group") if study.by_participant else ()
    return [f"<results>/tables/{name}.csv" for name in names]


def operating_points(study: Study) -> list[str]:
    """Tables of operating points and of lines through them, if there are several trials."""
    names = ("operating_points", "operating_relations") if study.has("operating_points") else ()
    return [f"<results>/tables/{name}.csv" for name in names]


def time_varying(study: Study) -> list[str]:
    """The table of impedance that changes within trials, if the configuration wants it."""
    return ["<results>/tables/time_varying.csv"] if study.has("time_varying") else []


def forward(study: Study) -> list[str]:
    """The comparison of simulations with recordings."""
    return ["<results>/tables/forward.csv"] if study.has("simulation") else []


def noise(study: Study) -> list[str]:
    """The noise study's tables."""
    names = ("noise", "table_4_4") if study.has("noise") else ()
    return [f"<results>/tables/{name}.csv" for name in names]


def specification(study: Study) -> list[str]:
    """Specification curve: one trial of the dummy, analysed with every combination of choices."""
    return ["<results>/tables/specification.csv"] if study.has("dummy") else []


def averaging(study: Study) -> list[str]:
    """The Wristalyzer's fit against the number of averaged frequencies."""
    return ["<results>/tables/averaging.csv"] if study.has("wristalyzer") else []


def thesis_dummy(study: Study) -> list[str]:
    """The fit of the dummy that the printed tables describe, and its table."""
    if not study.has("thesis_dummy"):
        return []
    return ["<results>/fits/thesis_dummy.h5", "<results>/tables/thesis_dummy.csv"]


def planned(study: Study) -> list[str]:
    """What the planning says about the thesis's experiments on the dummy."""
    return ["<results>/tables/planned.csv"] if study.has("thesis_dummy") else []


def true_motions(study: Study) -> list[str]:
    """Hidden motion of the joint in every simulated trial: manipulator, dummy, standing person."""
    of = ("wristalyzer", "dummy", "standing")
    return [f"<results>/truth/{e}/{c}.h5" for e in of for c in study.made(e)]


def fits_of_made(study: Study) -> list[str]:
    """Results of the same trials that tell what was fitted: fits, and the epochs of a standing person."""
    fits = [f"<results>/fits/{e}/{c}.h5" for e in ("wristalyzer", "dummy") for c in study.made(e)]
    return fits + [f"<results>/epochs/standing/{c}.h5" for c in study.made("standing")]


def recovery(study: Study) -> list[str]:
    """The comparison with the truth, if there is one, and what the laboratory is like."""
    if study.config["study"]["virtual_lab"] is None:
        return []
    return ["<results>/tables/recovery.csv", "<results>/tables/laboratory.csv"]


def claims(study: Study) -> list[str]:
    """The check of the claims of the thesis, if the study has trials to compare."""
    return [] if study.config["study"]["reported"] is None else ["<results>/tables/claims.csv"]


def cells(study: Study) -> list[str]:
    """The verdict of every printed cell, if the study has trials to compare."""
    return [] if study.config["study"]["reported"] is None else ["<results>/tables/cells.csv"]


def tables(study: Study) -> dict[str, str]:
    """Name of a table of the run -> its caption."""
    others = (models, averaging, forward, noise, specification, participants, operating_points, time_varying)
    others += (planned, recovery, claims, cells)
    found = dict.fromkeys(map(_stem, thesis_tables(study)), "thesis_table")
    found |= {name: name for name in ("estimates", "uncertainty")}
    found |= {name: name for files in others for name in map(_stem, files(study))}
    return found | {name: name for name in map(_stem, thesis_dummy(study)[1:])}


def _stem(path: str) -> str:
    return path.rpartition("/")[2].removesuffix(".csv")


def report_fits(study: Study) -> list[str]:
    """Fits of which the report has facts or numbers."""
    own = [path for name in ("weight", "belt") for path in model_files(study, name)[:1]]
    if study.has("simulation"):
        own += study.of_trials("<results>/fits/simulation/{condition}.h5", "dummy")
    return fits(study) + pooled_wristalyzer(study)[:1] + task_fits(study) + thesis_dummy(study)[:1] + own


def report_tables(study: Study) -> list[str]:
    """Tables that the report reads; of the treadmill models the ones that it shows."""
    models = [path for name in ("weight", "belt") for path in model_files(study, name)[1:]]
    names = [name for name in tables(study) if name != "treadmill_models"]
    return [f"<results>/tables/{name}.csv" for name in names] + models


def model_names(study: Study) -> dict[str, str]:
    """Experiment -> name of its calibration of treadmill models, among the report's fits and tables."""
    return {name: _stem(file) for name in ("weight", "belt") for file in model_files(study, name)[1:]}


# experiments and parts with a module of numbers and predicates, tepsipe/reporting/chapters/<name>.py
CHAPTERS = (
    "study",
    "wristalyzer",
    "dummy",
    "thesis_dummy",
    "planning",
    "simulation",
    "noise",
    "weight",
    "standing",
    "belt",
    "participants",
    "budgets",
    "position_manipulator",
    "platform",
)
# reports of studies of their own, and their modules
OWN_REPORTS = {
    "coverage": ("coverage",),
    "plan": ("plan", "several_joints"),
    "walking": ("walking",),
}


def chapters(study: Study) -> list[str]:
    """Chapters of the report that have numbers of their own."""
    present = {"study": True, "planning": bool(planned(study))}
    return [name for name in CHAPTERS if present.get(name) or (name not in present and study.has(name))]


def pages(study: Study) -> list[str]:
    """A page per trial for a web browser."""
    return [f"<results>/report/trials/{e}/{c}.html" for e, c in study.trials]


def plan_of_design(plan: dict, name: str) -> dict:
    """What of the section ``plan`` one design depends on."""
    used = {key: plan[key] for key in ("seed", "draws", "window_draws", "joint", "rig", "protocol")}
    return used | {"designs": {name: plan["designs"][name]}}


def everything(study: Study) -> list[str]:
    """Inputs of the rule `all` other than pages for a browser."""
    return [
        f"<results>/report/{study.config['study']['name']}.pdf",
        "<results>/provenance.json",
        "<results>/tables/estimates.csv",
        "<results>/tables/uncertainty.csv",
        *thesis_tables(study),
        *models(study),
        *forward(study),
        *noise(study),
        *averaging(study),
        *specification(study),
        *thesis_dummy(study)[1:],
        *planned(study),
        *participants(study),
        *operating_points(study),
        *time_varying(study),
        *recovery(study),
        *claims(study),
        *cells(study),
        *figures(study),
        *standing_figures(study),
    ]
