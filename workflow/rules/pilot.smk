# A person standing on the treadmill: thesis sections 2-2, 3-2 and 4-2, and the step after them.


rule fit_pilot:
    input:
        trial="<results>/trials/pilot/{condition}.h5",
        models=plate_models(),
        library=library_of("fit_pilot"),
    output:
        responses="<results>/responses/pilot/{condition}.h5",
        fit="<results>/fits/pilot/{condition}.h5",
        estimates="<results>/estimates/pilot/{condition}.csv",
    log:
        "<logs>/fit_pilot/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        person=config["pilot"]["person"],
        belt=config["pilot"]["belt"],
        muscles=config["pilot"]["muscles"],
        max_gap_s=config["pilot"]["ingest"]["max_gap_s"],
        emg=config["pilot"]["emg"],
        analysis=config["pilot"]["analysis"],
        stance=config["pilot"]["stance"],
        pathways=config["pilot"]["pathways"],
        estimators=config["pilot"]["estimators"],
        active=config["pilot"]["active"],
        as_printed=config["pilot"]["as_printed"],
        recommended=config["pilot"]["recommended"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_pilot.py"


rule fit_pilot_task:
    input:
        responses=of_task("<results>/responses/pilot/{condition}.h5"),
        library=library_of("fit_pilot_task"),
    output:
        fit="<results>/fits/pilot_tasks/{task}.h5",
        estimates="<results>/estimates/pilot_tasks/{task}.csv",
    log:
        "<logs>/fit_pilot_task/{task}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        person=config["pilot"]["person"],
        muscles=config["pilot"]["muscles"],
        analysis=config["pilot"]["analysis"],
        pathways=config["pilot"]["pathways"],
        estimators=config["pilot"]["estimators"],
        active=config["pilot"]["active"],
        latency=config["pilot"]["latency"],
        recommended=config["pilot"]["recommended"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_pilot_task.py"


rule plot_pilot_trials:
    input:
        responses=of_trials("<results>/responses/pilot/{condition}.h5", "pilot"),
        library=library_of("plot_pilot_trials"),
    output:
        figures_4_13=of_trials("<results>/figures/pilot/{condition}_4_13.png", "pilot"),
        figures_4_14=of_trials("<results>/figures/pilot/{condition}_4_14.png", "pilot"),
    log:
        "<logs>/plot_pilot_trials.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/plot_pilot_trials.py"


rule plot_pilot:
    input:
        example=f"<results>/responses/pilot/{shown_condition('pilot', config['pilot']['example_condition'])}.h5",
        trials=of_trials("<results>/fits/pilot/{condition}.h5", "pilot"),
        tasks=task_fits(),
        library=library_of("plot_pilot"),
    output:
        **figure_files("pilot"),
    log:
        "<logs>/plot_pilot.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("pilot"),
        tasks=tasks(),
        task_of={c: TRIALS["pilot", c].task for c in conditions("pilot")},
        detector=config["pilot"]["latency"]["detector"],
        recommended=config["pilot"]["recommended"],
        active=active_estimators(),
        groups=task_groups(),
        window_s=config["pilot"]["estimators"][config["pilot"]["recommended"]["estimator"]]["window_s"],
        muscles=list(config["pilot"]["muscles"]),
    script:
        "../scripts/plot_pilot.py"
