# Raw files to one self-describing HDF5 file per trial. Recorded and simulated files are treated alike. One rule
# per experiment, all alike: what differs is declared by the experiment, in tepsipe/experiments/<name>/__init__.py.

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
            library=library_of("ingest", *modules_of(_experiment, "ingest")),
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
            section=of_trial(STUDY.for_ingest, _name),
            duration_s=sheet("duration_s", _name),
            named=of_trial(STUDY.named, _name),
            named_by=of_trial(STUDY.named_by, _name),
            plausible=PLAUSIBLE,
            rig=of_trial(lambda e, c: rig_of(STUDY.settings_of(e, c), e), _name),
        script:
            "../scripts/ingest.py"
