# TEP-SIPE on the ankle dummy: thesis sections 3-1-2 and 4-1-2.

DUMMY = SETTINGS["dummy"]
# what bootstrap does not need is not given to those that draw no samples
DUMMY_ANALYSIS = without(DUMMY["analysis"], "bootstrap_draws")
# the trial that is analysed by every combination of choices
SPECIFIED = STUDY.shown("dummy", DUMMY["specification"]["condition"])


rule check_rig:
    """Pool the checks of all trials of the dummy, which share a rig."""
    input:
        fits=STUDY.of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        library=library_of("check_rig"),
    output:
        flags="<results>/checks/dummy_rig.csv",
    log:
        "<logs>/check_rig.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=STUDY.conditions("dummy"),
    script:
        "../scripts/check_rig.py"


rule cross_validate_dummy:
    """Predict every trial of the dummy with the parameters of every trial."""
    input:
        fits=STUDY.of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        library=library_of("cross_validate_dummy"),
    output:
        matrices="<results>/cross_validation/dummy.h5",
        estimates="<results>/cross_validation/dummy.csv",
    log:
        "<logs>/cross_validate_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=STUDY.conditions("dummy"),
    script:
        "../scripts/cross_validate_dummy.py"


rule specify_dummy:
    """Analyse one trial of the dummy with every combination of choices."""
    input:
        trial=f"<results>/trials/dummy/{SPECIFIED}.h5",
        library=library_of("specify_dummy"),
    output:
        table="<results>/tables/specification.csv",
    log:
        "<logs>/specify_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        condition=SPECIFIED,
        geometry=DUMMY["geometry"],
        analysis=DUMMY_ANALYSIS,
        foot=without(DUMMY["foot"], "pathways"),
        belt=STUDY.treadmill.belt_of("dummy", SPECIFIED),
        options=without(DUMMY["specification"], "condition"),
        as_printed=DUMMY["pathways"][DUMMY["as_printed"]],
        recommended=DUMMY["pathways"][DUMMY["recommended"]],
    script:
        "../scripts/specify_dummy.py"


rule plot_dummy:
    """Draw the figures of the dummy."""
    input:
        fits=STUDY.of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        specification="<results>/tables/specification.csv",
        matrices="<results>/cross_validation/dummy.h5",
        recovery=outputs.recovery(STUDY),
        library=library_of("plot", "tepsipe/experiments/dummy/figures.py"),
    output:
        **figure_files("dummy"),
    log:
        "<logs>/plot_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.dummy.figures:draw_dummy",
        conditions=STUDY.conditions("dummy"),
        example=STUDY.shown("dummy", DUMMY["example_condition"]),
        as_printed=DUMMY["as_printed"],
        recommended=DUMMY["recommended"],
        quoted=DUMMY["quoted"],
    script:
        "../scripts/plot.py"


rule fit_foot:
    """Fit a trial of the dummy with the torque from the foot and the force plate."""
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        models=lambda w: outputs.plate_models(STUDY, "dummy", w.condition),
        calibrations=lambda w: outputs.held_out(STUDY, "dummy", w.condition),
        library=library_of("fit", "tepsipe/experiments/dummy/fit_foot.py"),
    output:
        fit="<results>/fits/foot/{condition}.h5",
        estimates="<results>/estimates/foot/{condition}.csv",
        uncertainty="<results>/uncertainty/foot/{condition}.csv",
    log:
        "<logs>/fit_foot/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        module="tepsipe.experiments.dummy.fit_foot",
        section=section_of("dummy", "geometry", "analysis", "foot", "belt"),
        given=as_it_is({"seed": SEED, "uncertainty": SETTINGS["uncertainty"]["dummy"]}),
    script:
        "../scripts/fit.py"


rule plot_foot:
    """Draw the comparison of the torques from leg and foot."""
    input:
        leg=STUDY.of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        foot=STUDY.of_trials("<results>/fits/foot/{condition}.h5", "dummy"),
        recovery=outputs.recovery(STUDY),
        library=library_of("plot", "tepsipe/experiments/dummy/figures.py"),
    output:
        **figure_files("foot"),
    log:
        "<logs>/plot_foot.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.dummy.figures:draw_foot",
        conditions=STUDY.conditions("dummy"),
        recommended=DUMMY["recommended"],
        usable=[name for name, own in DUMMY["foot"]["pathways"].items() if own["treadmill_model"]],
    script:
        "../scripts/plot.py"


rule fit_thesis_dummy:
    """Find the dummy that the printed tables describe."""
    input:
        trials=STUDY.of_trials("<results>/trials/dummy/{condition}.h5", "dummy"),
        library=library_of("fit_thesis_dummy"),
    output:
        fit="<results>/fits/thesis_dummy.h5",
        table="<results>/tables/thesis_dummy.csv",
    log:
        "<logs>/fit_thesis_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=STUDY.conditions("dummy"),
        tables=[STUDY.thesis.conditions(table) for table in ("table_4_2", "table_4_3")],
        printed=meant_in("table_4_2", "table_4_3"),
        followed=reported_of("simulations").get("simulations", {}).get("every_condition"),
        section=pick(
            DUMMY,
            *("geometry", "-geometry.foot_mass_kg", "-geometry.foot_height_m"),
            *("analysis", "-analysis.bootstrap_draws"),
            *("files.marker_labels", "ingest.marker_sampling_hz", "thesis_dummy"),
        ),
        seed=SEED,
    script:
        "../scripts/fit_thesis_dummy.py"


rule plan_dummy:
    """Predict the uncertainty of the thesis's experiments on the dummy."""
    input:
        library=library_of("plan_dummy"),
    output:
        table="<results>/tables/planned.csv",
    log:
        "<logs>/plan_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=DUMMY["geometry"],
        joint=SETTINGS["noise"]["joint"],
        uncertainty=SETTINGS["uncertainty"]["dummy"],
    script:
        "../scripts/plan_dummy.py"


rule plot_thesis_dummy:
    """Draw the dummy that the printed tables describe."""
    input:
        table="<results>/tables/thesis_dummy.csv",
        fit="<results>/fits/thesis_dummy.h5",
        library=library_of("plot", "tepsipe/experiments/thesis_dummy/figures.py"),
    output:
        **figure_files("thesis_dummy"),
    log:
        "<logs>/plot_thesis_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.thesis_dummy.figures:draw_thesis_dummy",
    script:
        "../scripts/plot.py"


# trials under other laws of the joint, by the same scripts; only the pathways that are quoted are needed
READ_UNDER_LAWS = [
    *(path for path in EXPERIMENTS["dummy"].fit_reads if path != "pathways"),
    *(f"pathways.{name}" for name in STUDY.estimators.quoted_dummy()),
]


use rule make_dummy_trial as make_trial_of_law with:
    output:
        log="<results>/raw/other_laws/{law}/{condition}/log.mat",
        calibration="<results>/raw/other_laws/{law}/{condition}/calibration.csv",
        markers="<results>/raw/other_laws/{law}/{condition}/markers.c3d",
        motion="<results>/truth/other_laws/{law}/{condition}.h5",
    log:
        "<logs>/make_trial_of_law/{law}/{condition}.log",
    wildcard_constraints:
        law=any_of(OTHER_LAWS),
    params:
        made_by="dummy_trial",
        truth=lambda w: under_law(w.law, *RIGS["dummy"].constants),
        told=of_trial(told_of, "dummy"),


use rule ingest_dummy as ingest_trial_of_law with:
    input:
        raw=[
            f"<results>/raw/other_laws/{{law}}/{{condition}}/{file}"
            for file in EXPERIMENTS["dummy"].raw_files.values()
        ],
        library=library_of("ingest", "tepsipe/experiments/dummy/ingest.py", *readers_of(EXPERIMENTS["dummy"])),
    output:
        trial="<results>/trials/other_laws/{law}/{condition}.h5",
    log:
        "<logs>/ingest_trial_of_law/{law}/{condition}.log",
    wildcard_constraints:
        law=any_of(OTHER_LAWS),
    params:
        experiment="dummy",
        module="tepsipe.experiments.dummy.ingest",
        files=lambda w, input: dict(zip(EXPERIMENTS["dummy"].raw_files, input.raw)),
        section=of_trial(STUDY.for_ingest, "dummy"),
        duration_s=sheet("duration_s", "dummy"),
        named=of_trial(STUDY.named, "dummy"),
        named_by=of_trial(STUDY.named_by, "dummy"),
        plausible=PLAUSIBLE,
        rig=of_trial(lambda e, c: rig_of(STUDY.settings_of(e, c), e), "dummy"),


use rule fit_dummy as fit_trial_of_law with:
    input:
        trial="<results>/trials/other_laws/{law}/{condition}.h5",
        library=library_of("fit", "tepsipe/experiments/dummy/fit.py"),
    output:
        estimates="<results>/estimates/other_laws/{law}/{condition}.csv",
        uncertainty="<results>/uncertainty/other_laws/{law}/{condition}.csv",
        fit="<results>/fits/other_laws/{law}/{condition}.h5",
    log:
        "<logs>/fit_trial_of_law/{law}/{condition}.log",
    wildcard_constraints:
        law=any_of(OTHER_LAWS),
    params:
        module="tepsipe.experiments.dummy.fit",
        section=section_of("dummy", *READ_UNDER_LAWS),
        given=as_it_is({"seed": SEED, "uncertainty": SETTINGS["uncertainty"]["dummy"]}),
