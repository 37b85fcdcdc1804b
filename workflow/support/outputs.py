"""Output files of a study, as named by its rules."""

from dataclasses import dataclass

from tepsipe.experiments.registry import EXPERIMENTS
from workflow.support.captions import captions_of
from workflow.support.parts import APPENDIX, OF_APPENDIX, PARTS
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
    """Named outputs of figures (name -> SVG), with those of the numbers that they show."""
    return figures | {f"{name}_csv": f"{folder}/{name}.csv" for name in figures}


# figures of every trial of the standing person
STANDING_FIGURES = ("4_13", "4_14")


def standing_figures(study: Study) -> list[str]:
    """Figures 4-13 and 4-14 of every trial of the standing person."""
    return [path for c in study.conditions("standing") for path in figures_of_trial(study, "standing", c)]


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


def estimates_of_trial(study: Study, experiment: str, condition: str) -> list[str]:
    """Rows of estimates of one trial; those from the foot of the dummy after those from its leg."""
    folders = [experiment] if EXPERIMENTS[experiment].fitted else []
    folders += ["foot"] if experiment == "dummy" and study.has("foot") else []
    return [f"<results>/estimates/{folder}/{condition}.csv" for folder in folders]


def fits_of_table(study: Study, table: str) -> list[str]:
    """Fits of a table's conditions, with their SEMs."""
    experiment = study.thesis.tables()[table]
    return [f"<results>/fits/{experiment}/{condition}.h5" for condition in study.thesis.conditions(table)]


def estimates(study: Study) -> list[str]:
    """Rows of estimates of all trials and tasks, then of cross-validations."""
    files = [f"<results>/estimates/{e}/{c}.csv" for e, c in study.trials if EXPERIMENTS[e].fitted]
    files += study.of_foot("<results>/estimates/foot/{condition}.csv")
    files += [f"<results>/estimates/{name}.csv" for name in _of_tasks(study)]
    crossed = [e for e in study.experiments if EXPERIMENTS[e].cross_validated]
    files += pooled_wristalyzer(study)[1:]
    return files + [f"<results>/cross_validation/{e}.csv" for e in crossed]


def joined(study: Study) -> dict[str, dict[str, list[str]]]:
    """Name of a table that joins rows -> experiment -> files of these rows."""
    rows = {"estimates": estimates(study), "uncertainty": budgets(study)}
    rows["recovery"] = [f"<results>/recovery/{name}.csv" for name in compared(study)]
    found: dict[str, dict[str, list[str]]] = {}
    for table, files in rows.items():
        for file in files:
            folder = file.split("/")[2]
            experiment = next((e for e in study.experiments if folder.startswith(e)), "dummy")
            found.setdefault(table, {}).setdefault(experiment, []).append(file)
    return found


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


def rig(study: Study) -> list[str]:
    """Faults of the dummy's rig, from the checks of all of its trials."""
    return ["<results>/checks/dummy_rig.csv"] if study.has("dummy") else []


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


@dataclass(frozen=True)
class Compared:
    """Estimates that one job compares with the truth: those of a trial, or of several analysed together.

    ``constants`` is the key of the laboratory's constants among the `true_parameters`; ``conditions`` are the
    trials in whose fitted windows the true joint is not that of the constants.
    """

    experiment: str
    constants: str
    estimates: list[str]
    conditions: tuple[str, ...] = ()

    @property
    def truth(self) -> list[str]:
        """Constants of the laboratory that serve as the truth; of tasks of a person the own one."""
        own = f"standing.tasks.{self.constants.partition('/')[2]}"
        return [own if path == "standing.tasks" else path for path in EXPERIMENTS[self.experiment].true]

    @property
    def motions(self) -> list[str]:
        """Hidden motion of the joint in every trial."""
        return [f"<results>/truth/{self.experiment}/{c}.h5" for c in self.conditions]

    @property
    def fits(self) -> list[str]:
        """Results of the same trials that tell which windows were fitted."""
        folder = "epochs" if self.experiment == "standing" else "fits"
        return [f"<results>/{folder}/{self.experiment}/{c}.h5" for c in self.conditions]


def comparison_of(study: Study, experiment: str, condition: str) -> list[str]:
    """Comparison of a trial with the truth, if it is simulated and something of it is known."""
    known = study.trials[experiment, condition].source == "virtual_lab" and EXPERIMENTS[experiment].true
    return [f"<results>/recovery/{experiment}/{condition}.csv"] if known else []


def compared(study: Study) -> dict[str, Compared]:
    """Name -> what is compared with the truth: simulated trials, and those analysed together if all are."""
    found, usual, made = {}, study.treadmill.usual_weight(), set(study.simulated("standing"))
    for (experiment, condition), row in study.trials.items():
        constants, moved = experiment, (condition,)
        if experiment == "standing":
            constants = f"standing/{row.task}"
        elif experiment == "weight":
            constants, moved = "weight" if condition in usual else "weight/heavy", ()
        if comparison_of(study, experiment, condition):
            own = estimates_of_trial(study, experiment, condition)
            found[f"{experiment}/{condition}"] = Compared(experiment, constants, own, moved)
    for pool in study.tasks.pools().values():
        if made >= set(pool.conditions):
            name, task = f"standing_tasks/{pool.name}", f"standing/{pool.task}"
            own = [f"<results>/estimates/{name}.csv"]
            found[name] = Compared("standing", task, own, tuple(pool.conditions))
    if study.has("wristalyzer_pooled") and not study.recorded("wristalyzer"):
        own = pooled_wristalyzer(study)[1:]
        found["wristalyzer_pooled"] = Compared("wristalyzer", "wristalyzer/pooled", own)
    return found


def recovery(study: Study) -> list[str]:
    """The comparison with the truth, if there is one, what the laboratory is like and what it shares."""
    if study.config["study"]["virtual_lab"] is None:
        return []
    return [f"<results>/tables/{name}.csv" for name in ("recovery", "laboratory", "shared")]


def other_laws(study: Study) -> list[str]:
    """Comparison with the truth under other laws of the dummy's joint, if the dummy is simulated."""
    return ["<results>/tables/other_laws.csv"] if study.simulated("dummy") else []


def claims(study: Study) -> list[str]:
    """The check of the claims of the thesis, if the study has trials to compare."""
    return [] if study.config["study"]["reported"] is None else ["<results>/tables/claims.csv"]


def cells(study: Study) -> list[str]:
    """The verdict of every printed cell, if the study has trials to compare."""
    return [] if study.config["study"]["reported"] is None else ["<results>/tables/cells.csv"]


def tables(study: Study) -> list[str]:
    """Names of the tables of the run, which are those of their captions."""
    others = (models, averaging, forward, noise, specification, participants, operating_points, time_varying)
    others += (planned, recovery, other_laws, claims, cells)
    files = [*thesis_tables(study), "answers", "estimates", "uncertainty"]
    files += [path for own in others for path in own(study)] + thesis_dummy(study)[1:]
    return [_stem(path) for path in files]


def _stem(path: str) -> str:
    return path.rpartition("/")[2].removesuffix(".csv")


def report_fits(study: Study) -> list[str]:
    """Fits of which the report has facts or numbers."""
    own = [path for name in ("weight", "belt") for path in model_files(study, name)[:1]]
    if study.has("simulation"):
        for kind in ("simulation", "foot") if study.has("foot") else ("simulation",):
            own += study.of_trials(f"<results>/fits/{kind}/{{condition}}.h5", "dummy")
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
    "budgets",
    "position_manipulator",
    "platform",
)
# reports of studies of their own, and their modules
OWN_REPORTS = {"coverage": ("coverage",), "plan": ("plan", "several_joints"), "walking": ("walking",)}


def chapters(study: Study) -> list[str]:
    """Chapters of the report that have numbers of their own."""
    present = {"study": True, "planning": bool(planned(study))}
    return [name for name in CHAPTERS if present.get(name) or (name not in present and study.has(name))]


def supplement(study: Study) -> list[str]:
    """What the article on the thesis leaves to a PDF of its own."""
    return ["<results>/report/supplement.pdf"] if study.repeats_thesis else []


def page(experiment: str, condition: str) -> str:
    """Page of a trial for a web browser."""
    return f"<results>/report/trials/{experiment}/{condition}.html"


def pages(study: Study) -> list[str]:
    """A page per trial for a web browser."""
    return [page(*trial) for trial in study.trials]


def figures_of_trial(study: Study, experiment: str, condition: str) -> list[str]:
    """Figures of one trial alone: of a standing person, and of the dummy if it is simulated."""
    if experiment == "standing":
        return [f"<results>/figures/standing/{condition}_{name}.png" for name in STANDING_FIGURES]
    numbered = dict(zip(study.conditions("dummy"), APPENDIX, strict=False)) if study.has("simulation") else {}
    own = numbered.get(condition) if experiment == "dummy" else None
    return [f"<results>/figures/{own}.svg"] if own else []


def of_trial(study: Study, experiment: str, condition: str) -> list[str]:
    """Estimates, figures and page of one trial."""
    figures = figures_of_trial(study, experiment, condition)
    return [*estimates_of_trial(study, experiment, condition), *figures, page(experiment, condition)]


def plan_of_design(plan: dict, name: str) -> dict:
    """What of the section ``plan`` one design depends on."""
    used = {key: plan[key] for key in ("seed", "draws", "window_draws", "joint", "rig", "protocol")}
    return used | {"designs": {name: plan["designs"][name]}}


def everything(study: Study) -> list[str]:
    """Inputs of the rule `all` other than pages for a browser."""
    return [
        f"<results>/report/{study.config['study']['name']}.pdf",
        *supplement(study),
        "<results>/provenance.json",
        "<results>/tables/answers.csv",
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
        *other_laws(study),
        *claims(study),
        *cells(study),
        *figures(study),
        *standing_figures(study),
    ]
