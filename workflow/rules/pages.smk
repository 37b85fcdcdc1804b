# A page per trial for a web browser, and names of trials as targets: snakemake -c2 dummy/sine-0.3.

PAGE_SOURCE = [here(f"tepsipe/drawing/web/{name}") for name in ("plot.js", "page.css", "theme.js")]


def on_rig(w):
    """Faults of the rig, which all trials of the dummy show; for a page asked for by name, if they are known."""
    named = any(
        argument.endswith((f"dummy/{w.condition}", f"dummy/{w.condition}.html")) for argument in sys.argv
    )
    known = Path(outputs.rig(STUDY)[0].replace("<results>", config["pathvars"]["results"])).is_file()
    return outputs.rig(STUDY) if known or not (named or "--mode" in sys.argv) else []


def of_plate(w):
    """Responses of the models of the trial's belt, if the trial validates them."""
    belt = STUDY.treadmill.belt_of("weight", w.condition)
    models = STUDY.trials["weight", w.condition].role == "validate" and belt in STUDY.treadmill.belts()
    return [f"<results>/fits/{STUDY.treadmill.plate_of(belt)}.h5"] if models else []


# experiment -> chapter of the report, further inputs, and params of its pages; others have the chapter of their name
PAGES = {
    "dummy": (
        "dummy",
        {
            "rig": on_rig,
            "foot": lambda w: [f"<results>/fits/foot/{w.condition}.h5"] if STUDY.has("foot") else [],
        },
        {"recommended": DUMMY["recommended"]},
    ),
    "weight": ("weight", {"plate": of_plate}, {"experiment": "weight"}),
    "empty": ("weight", {"plate": []}, {"experiment": "empty"}),
    "standing": (
        "standing",
        {"epochs": "<results>/epochs/standing/{condition}.h5"},
        {},
    ),
    "belt": ("treadmill", {"fit": "<results>/fits/belt.h5"}, {"model": SETTINGS["belt"]["chosen"]}),
}

for _name, _experiment in EXPERIMENTS.items():
    if not _experiment.ingest_reads:
        continue
    _chapter, _files, _params = PAGES.get(_name, (_name.replace("_", "-"), {}, {}))
    _module = _experiment.folder
    _estimates = of_trial(partial(outputs.estimates_of_trial, STUDY), _name)
    _fitted = {"fit": f"<results>/fits/{_name}/{{condition}}.h5", "estimates": _estimates}

    rule:
        """Write the page of a trial for a web browser."""
        name:
            f"write_{_name}_pages"
        input:
            **(_fitted if _experiment.fitted else {}),
            **_files,
            trial=f"<results>/trials/{_name}/{{condition}}.h5",
            truth=of_trial(partial(outputs.comparison_of, STUDY), _name),
            source=PAGE_SOURCE,
            library=library_of("write_pages", f"tepsipe/experiments/{_module}/page.py"),
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
            composed_by=f"experiments.{_module}.page:page",
            chapter=_chapter,
            neutral=config["study"]["reported"] is None,
            title=as_it_is(config["study"]["title"]),
            trial=of_trial(partial(report_params.described, STUDY), _name),
            neighbours=of_trial(partial(report_params.neighbours, STUDY), _name),
        script:
            "../scripts/write_pages.py"


# only of these trials, because a list of rules with all of them would be too long
for _trial in NAMED:

    rule:
        """Make the estimates, figures and page of a trial."""
        name:
            "/".join(_trial)
        input:
            outputs.of_trial(STUDY, *_trial),
