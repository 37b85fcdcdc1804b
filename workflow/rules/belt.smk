# Belt-induced load of a treadmill, from your own recordings.


rule calibrate_belt:
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
    input:
        fit="<results>/fits/belt.h5",
        scores="<results>/treadmill_models/belt.csv",
        library=library_of("plot", "tepsipe/reporting/figures/belt.py"),
    output:
        **figure_files("belt"),
    log:
        "<logs>/plot_belt.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="belt",
        model=SETTINGS["belt"]["chosen"],
    script:
        "../scripts/plot.py"
