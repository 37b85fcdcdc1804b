# From raw files to one self-describing HDF5 file per trial, and from there to its estimates. Recorded and simulated
# files are treated alike. Each kind of rule is one per experiment, all alike: what differs is declared by the
# experiment, in tepsipe/experiments/<name>/__init__.py.

# what a signal can be, for every trial on its way in
PLAUSIBLE = without(SETTINGS["plausible"], *RIG_KEYS)

for _experiment in EXPERIMENTS.values():
    if not _experiment.ingest_reads:
        continue
    _name = _experiment.name

    rule:
        """Bring the raw files of a trial to one clock and to SI units, in one HDF5 file."""
        name:
            f"ingest_{_name}"
        input:
            raw=raw_inputs(_name),
            library=library_of("ingest", *files_of(_experiment.module("ingest")), *readers_of(_experiment)),
        output:
            trial=f"<results>/trials/{_name}/{{condition}}.h5",
        log:
            f"<logs>/ingest_{_name}/{{condition}}.log",
        conda:
            "../envs/tepsipe.yaml"
        params:
            experiment=_name,
            module=_experiment.module("ingest"),
            files=raw_files(_name),
            contents=contents_of(_name),
            section=of_trial(STUDY.for_ingest, _name),
            duration_s=sheet("duration_s", _name),
            named=of_trial(STUDY.named, _name),
            named_by=of_trial(STUDY.named_by, _name),
            plausible=PLAUSIBLE,
            rig=of_trial(lambda e, c: rig_of(STUDY.settings_of(e, c), e, STUDY.trials[e, c].amplitude), _name),
        script:
            "../scripts/ingest.py"


# further results of a fit -> their folder
FURTHER = {"responses": "epochs"}

for _experiment in EXPERIMENTS.values():
    if not _experiment.fitted:
        continue
    _name, _takes = _experiment.name, _experiment.fit_takes
    _given = {"seed": SEED, "uncertainty": SETTINGS["uncertainty"].get(_experiment.folder)}
    _models = {
        "models": of_trial(partial(outputs.plate_models, STUDY), _name),
        "calibrations": of_trial(partial(outputs.held_out, STUDY), _name),
    }
    _tables = ["estimates", "uncertainty"] if "uncertainty" in _takes else ["estimates"]

    rule:
        """Fit one trial: its estimates and, where Type B is evaluated, their uncertainty."""
        name:
            f"fit_{_name}"
        input:
            **{key: files for key, files in _models.items() if key in _takes},
            trial=f"<results>/trials/{_name}/{{condition}}.h5",
            library=library_of("fit", *files_of(_experiment.module("fit"))),
        output:
            **{key: f"<results>/{FURTHER[key]}/{_name}/{{condition}}.h5" for key in _experiment.further},
            **{table: f"<results>/{table}/{_name}/{{condition}}.csv" for table in _tables},
            fit=f"<results>/fits/{_name}/{{condition}}.h5",
        log:
            f"<logs>/fit_{_name}/{{condition}}.log",
        conda:
            "../envs/tepsipe.yaml"
        params:
            module=_experiment.module("fit"),
            section=section_of(_name, *_experiment.fit_reads),
            given=as_it_is({key: value for key, value in _given.items() if key in _takes}),
        script:
            "../scripts/fit.py"


for _experiment in EXPERIMENTS.values():
    if not _experiment.drawn_of:
        continue
    _name = _experiment.name
    _results = {
        "fits": STUDY.of_trials(f"<results>/fits/{_name}/{{condition}}.h5", _name),
        "estimates": STUDY.of_trials(f"<results>/estimates/{_name}/{{condition}}.csv", _name),
    }

    rule:
        """Draw the figures of an experiment from the results of all its trials."""
        name:
            f"plot_{_name}"
        input:
            **pick(_results, *_experiment.drawn_of),
            library=library_of("plot", *files_of(_experiment.module("figures"))),
        output:
            **figure_files(_name),
        log:
            f"<logs>/plot_{_name}.log",
        conda:
            "../envs/tepsipe.yaml"
        params:
            drawn_by=f"experiments.{_name}.figures:draw_{_name}",
            conditions=STUDY.conditions(_name),
        script:
            "../scripts/plot.py"
