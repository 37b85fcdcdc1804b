# SIPE in the torque-controlled manipulator: thesis sections 3-1-1 and 4-1-1.


rule sweep_averaging:
    """Fit the Wristalyzer trials with different numbers of averaged frequencies."""
    input:
        trials=STUDY.of_trials("<results>/trials/wristalyzer/{condition}.h5", "wristalyzer"),
        library=library_of("sweep_averaging"),
    output:
        table="<results>/tables/averaging.csv",
    log:
        "<logs>/sweep_averaging.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=STUDY.conditions("wristalyzer"),
        analysis=without(SETTINGS["wristalyzer"]["analysis"], "swept_bins"),
        numbers=SETTINGS["wristalyzer"]["analysis"]["swept_bins"],
    script:
        "../scripts/sweep_averaging.py"


rule cross_validate_wristalyzer:
    """Predict every Wristalyzer trial with the parameters of every trial."""
    input:
        fits=STUDY.of_trials("<results>/fits/wristalyzer/{condition}.h5", "wristalyzer"),
        library=library_of("cross_validate_wristalyzer"),
    output:
        matrix="<results>/cross_validation/wristalyzer.h5",
        estimates="<results>/cross_validation/wristalyzer.csv",
    log:
        "<logs>/cross_validate_wristalyzer.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=STUDY.conditions("wristalyzer"),
    script:
        "../scripts/cross_validate_wristalyzer.py"


rule pool_wristalyzer:
    """Fit all Wristalyzer trials together."""
    input:
        trials=STUDY.of_trials("<results>/trials/wristalyzer/{condition}.h5", "wristalyzer"),
        library=library_of("pool_wristalyzer"),
    output:
        fit="<results>/fits/wristalyzer_pooled.h5",
        estimates="<results>/estimates/wristalyzer_pooled.csv",
        uncertainty="<results>/uncertainty/wristalyzer_pooled.csv",
    log:
        "<logs>/pool_wristalyzer.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=STUDY.conditions("wristalyzer"),
        analysis=STUDY.manipulators.pooled(),
        uncertainty=SETTINGS["uncertainty"]["wristalyzer"],
    script:
        "../scripts/pool_wristalyzer.py"


rule plot_wristalyzer_pooled:
    """Draw the fit to all Wristalyzer trials together."""
    input:
        pooled="<results>/fits/wristalyzer_pooled.h5",
        estimates=STUDY.of_trials("<results>/estimates/wristalyzer/{condition}.csv", "wristalyzer"),
        recovery=outputs.recovery(STUDY),
        library=library_of("plot", "tepsipe/experiments/wristalyzer/figures.py"),
    output:
        **figure_files("wristalyzer_pooled"),
    log:
        "<logs>/plot_wristalyzer_pooled.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.wristalyzer.figures:draw_wristalyzer_pooled",
    script:
        "../scripts/plot.py"


rule plot_wristalyzer:
    """Draw the figures of the Wristalyzer."""
    input:
        fits=STUDY.of_trials("<results>/fits/wristalyzer/{condition}.h5", "wristalyzer"),
        matrix="<results>/cross_validation/wristalyzer.h5",
        averaging="<results>/tables/averaging.csv",
        library=library_of("plot", "tepsipe/experiments/wristalyzer/figures.py"),
    output:
        **figure_files("wristalyzer"),
    log:
        "<logs>/plot_wristalyzer.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.wristalyzer.figures:draw_wristalyzer",
        conditions=STUDY.conditions("wristalyzer"),
        best=STUDY.shown("wristalyzer", SETTINGS["wristalyzer"]["best_condition"]),
        fit_band_hz=SETTINGS["wristalyzer"]["analysis"]["fit_band_hz"],
        start_stiffness=SETTINGS["wristalyzer"]["analysis"]["start"]["K_Nm_per_rad"],
        printed=reported_table("table_4_1") | reported_of("values").get("values", {}),
    script:
        "../scripts/plot.py"
