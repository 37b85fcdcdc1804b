# The PDF: one source, a chapter for every experiment of the study. And Snakemake's own HTML report.


rule record_provenance:
    input:
        trials=all_trials(),
        trial_sheet=config["study"]["trial_sheet"],
        virtual_lab=config["study"]["virtual_lab"] or [],
        reported=config["study"]["reported"] or [],
        requirements=here("requirements.txt"),
        library=library_of("record_provenance"),
    output:
        provenance="<results>/provenance.json",
        config="<results>/config.yaml",
    log:
        "<logs>/record_provenance.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        config=config,
        code=code_version(workflow.basedir),
    script:
        "../scripts/record_provenance.py"


rule write_report:
    input:
        source=report_sources(),
        figures=study_figures(),
        fits=all_fits(),
        forward=study_forward(),
        noise=study_noise(),
        specification=study_specification(),
        tasks=task_fits(),
        plate=model_files("plate", PLATE),
        belt=model_files("belt", "belt" in EXPERIMENTS),
        estimates="<results>/tables/estimates.csv",
        tables=study_tables(),
        recovery=study_recovery(),
        claims=study_claims(),
        reported=config["study"]["reported"] or [],
        provenance="<results>/provenance.json",
        library=library_of("write_report"),
    output:
        pdf=report(
            f"<results>/report/{config['study']['name']}.pdf",
            caption="../../report/captions/report.rst",
            category="Report",
            labels={"document": config["study"]["title"]},
        ),
        data="<results>/report/report.json",
    log:
        "<logs>/write_report.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        title=config["study"]["title"],
        recordings_source=config["study"]["recordings_source"],
        experiments=experiment_conditions(),
        fitted=fitted_conditions(),
        step_s=SETTINGS["dummy"]["simulation"]["step_s"],
        amplitudes={c: TRIALS["dummy", c].amplitude for c in conditions("dummy")},
        roles=roles("belt"),
        tasks=tasks(),
        choices={name: SETTINGS[name] for name in (*EXPERIMENTS, "noise")},
        made={name: made_conditions(name) for name in EXPERIMENTS},
        best=shown_condition("wristalyzer", SETTINGS["wristalyzer"]["best_condition"]),
        start_stiffness=SETTINGS["wristalyzer"]["analysis"]["start"]["K_Nm_per_rad"],
        source_folder=lambda w: here("report"),
    script:
        "../scripts/write_report.py"


rule write_html_report:
    input:
        outputs=study_outputs(),
        config="<results>/config.yaml",
        library=library_of("write_html_report"),
    output:
        html="<results>/report/report.html",
    log:
        "<logs>/write_html_report.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/write_html_report.py"
