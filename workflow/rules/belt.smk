# Belt-induced load of a treadmill, from your own recordings.


rule calibrate_belt:
    """Fit models of the belt-induced load to the recordings of a treadmill, and evaluate them."""
    input:
        trials=STUDY.of_trials("<results>/trials/belt/{condition}.h5", "belt"),
        library=library_of("calibrate_belt"),
    output:
        models="<results>/treadmill_models/belt.json",
        fit="<results>/fits/belt.h5",
        scores="<results>/treadmill_models/belt.csv",
    log:
        "<logs>/calibrate_belt.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        roles=STUDY.roles("belt"),
        section=pick(SETTINGS["belt"], "analysis", "models"),
    script:
        "../scripts/calibrate_belt.py"


rule plot_belt:
    """Draw the figures of a recorded treadmill."""
    input:
        fit="<results>/fits/belt.h5",
        scores="<results>/treadmill_models/belt.csv",
        library=library_of("plot", "tepsipe/experiments/belt/figures.py"),
    output:
        **figure_files("belt"),
    log:
        "<logs>/plot_belt.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.belt.figures:draw_belt",
        model=SETTINGS["belt"]["chosen"],
    script:
        "../scripts/plot.py"
