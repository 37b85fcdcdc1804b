# Tables across trials, and the comparison of estimates with the truth.

COMPARED = outputs.compared(STUDY)


rule collect_estimates:
    """Join the estimates, the answers and the uncertainty budgets of all trials in three tables."""
    input:
        estimates=outputs.estimates(STUDY),
        budgets=outputs.budgets(STUDY),
        rig=outputs.rig(STUDY),
        library=library_of("collect_estimates"),
    output:
        table="<results>/tables/estimates.csv",
        answers="<results>/tables/answers.csv",
        uncertainty="<results>/tables/uncertainty.csv",
    log:
        "<logs>/collect_estimates.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        labels=groups.labels(STUDY),
        asked=groups.asked(STUDY),
    script:
        "../scripts/collect_estimates.py"


rule plot_budgets:
    """Draw the uncertainty budgets."""
    input:
        estimates="<results>/tables/estimates.csv",
        uncertainty="<results>/tables/uncertainty.csv",
        library=library_of("plot", "tepsipe/reporting/figures.py"),
    output:
        **figure_files("budgets"),
    log:
        "<logs>/plot_budgets.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="reporting.figures:draw_budgets",
        foot_pathway=as_it_is(STUDY.estimators.budgeted_foot()),
        names=outputs.budget_names(STUDY),
    script:
        "../scripts/plot.py"


rule collect_treadmill_models:
    """Join the scores of all treadmill models in one table."""
    input:
        scores=outputs.model_scores(STUDY),
        library=library_of("collect_treadmill_models"),
    output:
        table="<results>/tables/treadmill_models.csv",
    log:
        "<logs>/collect_treadmill_models.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        belts=outputs.belts_of_scores(STUDY),
    script:
        "../scripts/collect_treadmill_models.py"


rule lay_out_table:
    """Lay out a table of the thesis beside the printed values."""
    input:
        estimates=lambda w: outputs.estimates_of(STUDY, table_experiment(w.table)),
        fits=lambda w: outputs.fits_of_table(STUDY, w.table),
        library=library_of("lay_out_table"),
    output:
        table="<results>/tables/{table}.csv",
    log:
        "<logs>/lay_out_table/{table}.log",
    wildcard_constraints:
        table="table_4_[123]",
    conda:
        "../envs/tepsipe.yaml"
    params:
        reported=lambda w: reported_table(w.table),
        conditions=lambda w: STUDY.thesis.conditions(w.table),
        pathways=lambda w: STUDY.thesis.pathways(w.table),
    script:
        "../scripts/lay_out_table.py"


rule compare_with_truth:
    """Compare the estimates of a simulated trial, or of several together, with the truth."""
    input:
        estimates=lambda w: COMPARED[w.compared].estimates,
        motions=lambda w: COMPARED[w.compared].motions,
        fits=lambda w: COMPARED[w.compared].fits,
        library=library_of("compare_with_truth"),
    output:
        rows="<results>/recovery/{compared}.csv",
    log:
        "<logs>/compare_with_truth/{compared}.log",
    wildcard_constraints:
        compared=any_of(COMPARED),
    conda:
        "../envs/tepsipe.yaml"
    params:
        experiment=lambda w: COMPARED[w.compared].experiment,
        constants=lambda w: COMPARED[w.compared].constants,
        truth=lambda w: truth_of(*COMPARED[w.compared].truth),
        windows=lambda w: STUDY.estimators.true_windows(COMPARED[w.compared].experiment),
    script:
        "../scripts/compare_with_truth.py"


use rule compare_with_truth as compare_law_with_truth with:
    input:
        estimates=["<results>/estimates/other_laws/{law}/{condition}.csv"],
        motions=["<results>/truth/other_laws/{law}/{condition}.h5"],
        fits=["<results>/fits/other_laws/{law}/{condition}.h5"],
        library=library_of("compare_with_truth"),
    output:
        rows="<results>/recovery/other_laws/{law}/{condition}.csv",
    log:
        "<logs>/compare_law_with_truth/{law}/{condition}.log",
    wildcard_constraints:
        law=any_of(OTHER_LAWS),
    params:
        experiment="dummy",
        constants="dummy",
        truth=lambda w: under_law(w.law, *EXPERIMENTS["dummy"].true),
        windows={"lengths_s": STUDY.estimators.quoted_dummy(), "foot": []},


rule collect_other_laws:
    """Join the comparisons with the truth under other laws of the dummy's joint."""
    input:
        rows=[f"<results>/recovery/other_laws/{name}.csv" for name in OF_LAWS],
        library=library_of("collect_other_laws"),
    output:
        table="<results>/tables/other_laws.csv",
    log:
        "<logs>/collect_other_laws.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        laws=[name.partition("/")[0] for name in OF_LAWS],
    script:
        "../scripts/collect_other_laws.py"


rule collect_recovery:
    """Join the comparisons with the truth in one table."""
    input:
        estimates="<results>/tables/estimates.csv",
        rows=[f"<results>/recovery/{name}.csv" for name in COMPARED],
        library=library_of("collect_recovery"),
    output:
        table="<results>/tables/recovery.csv",
    log:
        "<logs>/collect_recovery.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/collect_recovery.py"


rule tabulate_laboratory:
    """List the mechanisms and constants of the virtual laboratory, and what it shares with the analysis."""
    input:
        library=library_of("tabulate_laboratory"),
    output:
        table="<results>/tables/laboratory.csv",
        shared="<results>/tables/shared.csv",
    log:
        "<logs>/tabulate_laboratory.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        truth=truth_of(*report_params.mechanisms(STUDY)),
        experiments=[experiment for experiment, names in STUDY.all_simulated().items() if names],
        sections=report_params.sections(STUDY),
        other_laws=len(OTHER_LAWS),
    script:
        "../scripts/tabulate_laboratory.py"


rule judge_cells:
    """Compare every printed cell of the thesis's tables with the run."""
    input:
        tables=outputs.thesis_tables(STUDY),
        noise=outputs.noise(STUDY),
        library=library_of("judge_cells"),
    output:
        table="<results>/tables/cells.csv",
    log:
        "<logs>/judge_cells.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        tables=list(STUDY.thesis.tables()),
        recorded=STUDY.recorded("wristalyzer") + STUDY.recorded("dummy"),
        reported=reported_of("tables").get("tables", {}),
        tolerances=reported_of("cells").get("cells", []),
        bases=as_it_is(reported_of("bases").get("bases", {})),
        slips=reported_of("slips").get("slips", []),
    script:
        "../scripts/judge_cells.py"


rule check_claims:
    """Compare the claims of the thesis with the numbers of the run."""
    input:
        estimates="<results>/tables/estimates.csv",
        fits=outputs.fits(STUDY),
        scores=outputs.models(STUDY),
        forward=outputs.forward(STUDY),
        noise=outputs.noise(STUDY),
        planned=outputs.planned(STUDY),
        library=library_of("check_claims"),
    output:
        table="<results>/tables/claims.csv",
    log:
        "<logs>/check_claims.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        claims=reported_of("claims").get("claims", []),
        bases=as_it_is(reported_of("bases").get("bases", {})),
        assertions=reported_of("assertions").get("assertions", []),
        reported=reported_of("tables").get("tables", {}),
        tolerances=reported_of("cells").get("cells", []),
        slips=reported_of("slips").get("slips", []),
        experiments=STUDY.all_conditions(fitted=True),
        recorded=not (STUDY.simulated("wristalyzer") or STUDY.simulated("dummy")),
        as_printed=as_it_is(SETTINGS["dummy"]["as_printed"]),
    script:
        "../scripts/check_claims.py"
