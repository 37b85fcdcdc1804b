# The virtual laboratory writes the instruments' own files. Each rule is given those of its constants that it
# reads; only these rules, and the comparison of estimates with the truth in tables.smk, are given any. One rule
# per rig, all alike: what differs is declared in tepsipe/virtual_lab/registry.py.


def constants_of(experiment, condition):
    """Paths of the constants that a trial is made from; a row that names a mass has the heavy weight."""
    row = STUDY.trials[experiment, condition]
    weight = "weight" if row.mass_kg is None else "heavy_weight"
    return [path.format(weight=weight, task=row.task) for path in RIGS[experiment].constants]


def told_of(experiment, condition):
    """What a rig is told of a trial by its row of the sheet."""
    row, belt = STUDY.trials[experiment, condition], STUDY.treadmill.belt_of(experiment, condition)
    told = {"amplitude": row.amplitude, "duration_s": row.duration_s, "task": row.task, "belt": belt}
    return only(told | {"protocol": STUDY.protocol(experiment, condition)}, *RIGS[experiment].told)


for _name, _rig in RIGS.items():
    _raw = EXPERIMENTS[_name].raw_files.items()
    _motion = {"motion": f"<results>/truth/{_name}/{{condition}}.h5"} if _rig.motion else {}

    rule:
        """Make the raw files of a simulated trial."""
        name:
            f"make_{_name}_trial"
        input:
            library=library_of("make_trial", f"tepsipe/virtual_lab/{_rig.module}.py"),
        output:
            **{kind: f"<results>/raw/{_name}/{{condition}}/{file}" for kind, file in _raw},
            **_motion,
        log:
            f"<logs>/make_{_name}_trial/{{condition}}.log",
        wildcard_constraints:
            condition=any_of(STUDY.simulated(_name)),
        conda:
            "../envs/tepsipe.yaml"
        params:
            made_by=_rig.module,
            truth=of_trial(lambda e, c: truth_of(*constants_of(e, c)), _name),
            told=of_trial(told_of, _name),
        script:
            "../scripts/make_trial.py"


# other laws of the dummy's joint, and their trials: law and condition
OTHER_LAWS = truth_of("dummy.other_laws")["dummy"]["other_laws"] or {} if STUDY.simulated("dummy") else {}
OF_LAWS = [f"{law}/{condition}" for law in OTHER_LAWS for condition in STUDY.extremes("dummy")]


def under_law(law, *paths):
    """The laboratory's constants at some paths, with another law of the dummy's joint."""
    found = truth_of(*paths)
    rubber = found["dummy"]["rubber"] | OTHER_LAWS[law]
    return found | {"dummy": found["dummy"] | {"rubber": rubber}}
