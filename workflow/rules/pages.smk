# A page per trial for a web browser, and names of trials as targets: snakemake -c2 dummy/sine-0.3.

PAGE_SOURCE = [here(f"tepsipe/reporting/pages/{name}") for name in ("plot.js", "page.css", "theme.js")]


def of_foot(pattern):
    """Input function: the trial's file of the torque from the foot, if there is one."""
    return lambda w: [pattern.format(condition=w.condition)] if STUDY.has("foot") else []


def on_rig(w):
    """Faults of the rig, which all trials of the dummy show; for a page asked for by name, if they are known."""
    named = any(argument.removesuffix(".html").endswith(f"dummy/{w.condition}") for argument in sys.argv)
    known = Path(outputs.rig(STUDY)[0].replace("<results>", config["pathvars"]["results"])).is_file()
    return outputs.rig(STUDY) if known or not (named or "--mode" in sys.argv) else []


def of_plate(w):
    """Responses of the models of the trial's belt, if the trial validates them."""
    belt = STUDY.treadmill.belt_of("weight", w.condition)
    models = STUDY.trials["weight", w.condition].role == "validate" and belt in STUDY.treadmill.belts()
    return [f"<results>/fits/{STUDY.treadmill.plate_of(belt)}.h5"] if models else []


def of_page(function, experiment):
    """Param function: what a function of a study, an experiment and a condition says of the page's trial."""
    return lambda w: function(STUDY, experiment, w.condition)


# experiment -> chapter of the report, further inputs, and params of its pages
PAGES = {
    "wristalyzer": ("wristalyzer", {}, {}),
    "dummy": (
        "dummy",
        {
            "rig": on_rig,
            "foot": of_foot("<results>/fits/foot/{condition}.h5"),
            "foot_estimates": of_foot("<results>/estimates/foot/{condition}.csv"),
        },
        {"recommended": DUMMY["recommended"]},
    ),
    "weight": ("weight", {"plate": of_plate}, {"experiment": "weight"}),
    "empty": ("weight", {"plate": []}, {"experiment": "empty"}),
    "standing": (
        "standing",
        {"epochs": "<results>/epochs/standing/{condition}.h5"},
        {"recommended": STANDING["recommended"]},
    ),
    "position_manipulator": ("position-manipulator", {}, {}),
    "platform": ("platform", {}, {}),
    "belt": ("treadmill", {"fit": "<results>/fits/belt.h5"}, {"model": SETTINGS["belt"]["chosen"]}),
}

for _name, (_chapter, _files, _params) in PAGES.items():
    _module = "weight" if _name == "empty" else _name
    _fitted = {"fit": f"<results>/fits/{_name}/{{condition}}.h5"}
    _fitted["estimates"] = f"<results>/estimates/{_name}/{{condition}}.csv"

    rule:
        """Write the page of a trial for a web browser."""
        name:
            f"write_{_name}_pages"
        input:
            **(_fitted if EXPERIMENTS[_name].fitted else {}),
            **_files,
            trial=f"<results>/trials/{_name}/{{condition}}.h5",
            truth=of_page(outputs.comparison_of, _name),
            source=PAGE_SOURCE,
            library=library_of("write_pages", f"tepsipe/reporting/pages/{_module}.py"),
        output:
            page=f"<results>/report/trials/{_name}/{{condition}}.html",
            picture=f"<results>/report/trials/{_name}/{{condition}}.svg",
        log:
            f"<logs>/write_{_name}_pages/{{condition}}.log",
        wildcard_constraints:
            condition=any_of(STUDY.conditions(_name)),
        conda:
            "../envs/tepsipe.yaml"
        params:
            **_params,
            composed_by=_module,
            chapter=_chapter,
            title=as_it_is(config["study"]["title"]),
            trial=of_page(report_params.described, _name),
            neighbours=of_page(report_params.neighbours, _name),
        script:
            "../scripts/write_pages.py"


# only of trials that the command line names: as many rules as trials would be too many to list
for _experiment, _condition in STUDY.trials:
    if f"{_experiment}/{_condition}" in sys.argv:

        rule:
            """Make the estimates, figures and page of a trial."""
            name:
                f"{_experiment}/{_condition}"
            input:
                outputs.of_trial(STUDY, _experiment, _condition),
