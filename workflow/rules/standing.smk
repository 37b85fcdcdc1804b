# A person standing on the treadmill: thesis sections 2-2, 3-2 and 4-2, and the step after them.


rule fit_standing:
    input:
        trial="<results>/trials/standing/{condition}.h5",
        models=plate_models(),
        library=library_of("fit_standing"),
    output:
        responses="<results>/epochs/standing/{condition}.h5",
        fit="<results>/fits/standing/{condition}.h5",
        estimates="<results>/estimates/standing/{condition}.csv",
    log:
        "<logs>/fit_standing/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        person=SETTINGS["standing"]["person"],
        belt=SETTINGS["standing"]["belt"],
        muscles=SETTINGS["standing"]["muscles"],
        max_gap_s=SETTINGS["standing"]["ingest"]["max_gap_s"],
        emg=SETTINGS["standing"]["emg"],
        analysis=SETTINGS["standing"]["analysis"],
        stance=SETTINGS["standing"]["stance"],
        pathways=SETTINGS["standing"]["pathways"],
        estimators=SETTINGS["standing"]["estimators"],
        active=SETTINGS["standing"]["active"],
        as_printed=SETTINGS["standing"]["as_printed"],
        recommended=SETTINGS["standing"]["recommended"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_standing.py"


rule fit_standing_task:
    input:
        responses=of_task("<results>/epochs/standing/{condition}.h5"),
        library=library_of("fit_standing_task"),
    output:
        fit="<results>/fits/standing_tasks/{task}.h5",
        estimates="<results>/estimates/standing_tasks/{task}.csv",
    log:
        "<logs>/fit_standing_task/{task}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        person=SETTINGS["standing"]["person"],
        muscles=SETTINGS["standing"]["muscles"],
        analysis=SETTINGS["standing"]["analysis"],
        pathways=SETTINGS["standing"]["pathways"],
        estimators=SETTINGS["standing"]["estimators"],
        active=SETTINGS["standing"]["active"],
        latency=SETTINGS["standing"]["latency"],
        recommended=SETTINGS["standing"]["recommended"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_standing_task.py"


rule plot_standing_trials:
    input:
        responses=of_trials("<results>/epochs/standing/{condition}.h5", "standing"),
        library=library_of("plot_standing_trials"),
    output:
        figures_4_13=of_trials("<results>/figures/standing/{condition}_4_13.png", "standing"),
        figures_4_14=of_trials("<results>/figures/standing/{condition}_4_14.png", "standing"),
    log:
        "<logs>/plot_standing_trials.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/plot_standing_trials.py"


rule plot_standing:
    input:
        example=f"<results>/epochs/standing/{shown_condition('standing', SETTINGS['standing']['example_condition'])}.h5",
        trials=of_trials("<results>/fits/standing/{condition}.h5", "standing"),
        tasks=task_fits(),
        library=library_of("plot_standing"),
    output:
        **figure_files("standing"),
    log:
        "<logs>/plot_standing.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("standing"),
        tasks=tasks(),
        task_of={c: TRIALS["standing", c].task for c in conditions("standing")},
        detector=SETTINGS["standing"]["latency"]["detector"],
        recommended=SETTINGS["standing"]["recommended"],
        active=active_estimators(),
        groups=task_groups(),
        window_s=SETTINGS["standing"]["estimators"][SETTINGS["standing"]["recommended"]["estimator"]]["window_s"],
        muscles=list(SETTINGS["standing"]["muscles"]),
    script:
        "../scripts/plot_standing.py"
