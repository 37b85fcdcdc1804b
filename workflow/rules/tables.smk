# Tables across trials, and the one place where truth meets estimate.


rule collect_estimates:
    input:
        estimates=all_estimates(),
        library=library_of("collect_estimates"),
    output:
        table=report(
            "<results>/tables/estimates.csv",
            caption="../../report/captions/estimates.rst",
            category="Tables",
            labels={"table": "all estimates"},
        ),
    log:
        "<logs>/collect_estimates.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/collect_estimates.py"


rule collect_treadmill_models:
    input:
        scores=model_scores(),
        library=library_of("collect_treadmill_models"),
    output:
        table=report(
            "<results>/tables/treadmill_models.csv",
            caption="../../report/captions/treadmill_models.rst",
            category="Tables",
            labels={"table": "models of the treadmill"},
        ),
    log:
        "<logs>/collect_treadmill_models.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/collect_treadmill_models.py"


rule lay_out_table:
    input:
        estimates="<results>/tables/estimates.csv",
        reported=config["study"]["reported"] or [],
        library=library_of("lay_out_table"),
    output:
        table=report(
            "<results>/tables/{table}.csv",
            caption="../../report/captions/thesis_table.rst",
            category="Tables",
            labels={"table": "{table}"},
        ),
    log:
        "<logs>/lay_out_table/{table}.log",
    wildcard_constraints:
        table="table_4_[123]",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=lambda w: table_conditions(w.table),
        as_printed=lambda w: table_pathways(w.table)[0],
        recommended=lambda w: table_pathways(w.table)[1],
    script:
        "../scripts/lay_out_table.py"


rule compare_with_truth:
    input:
        estimates="<results>/tables/estimates.csv",
        truth=config["study"]["virtual_lab"] or [],
        library=library_of("compare_with_truth"),
    output:
        table=report(
            "<results>/tables/recovery.csv",
            caption="../../report/captions/recovery.rst",
            category="Tables",
            labels={"table": "recovery of the truth"},
        ),
    log:
        "<logs>/compare_with_truth.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        made={name: made_conditions(name) for name in EXPERIMENTS},
        tasks=made_tasks(),
    script:
        "../scripts/compare_with_truth.py"


rule check_claims:
    input:
        estimates="<results>/tables/estimates.csv",
        fits=all_fits(),
        scores=study_models(),
        forward=study_forward(),
        noise=study_noise(),
        reported=config["study"]["reported"] or [],
        library=library_of("check_claims"),
    output:
        table=report(
            "<results>/tables/claims.csv",
            caption="../../report/captions/claims.rst",
            category="Tables",
            labels={"table": "the thesis's claims"},
        ),
    log:
        "<logs>/check_claims.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        experiments=fitted_conditions(),
        as_printed=SETTINGS["dummy"]["as_printed"],
    script:
        "../scripts/check_claims.py"
