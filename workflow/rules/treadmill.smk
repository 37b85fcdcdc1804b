# What a treadmill adds to a measured load: recordings of your own.


rule calibrate_treadmill:
    input:
        trials=of_trials("<results>/trials/treadmill/{condition}.h5", "treadmill"),
        library=library_of("calibrate_treadmill"),
    output:
        models="<results>/treadmill_models/treadmill.json",
        fit="<results>/fits/treadmill.h5",
        scores="<results>/treadmill_models/treadmill.csv",
    log:
        "<logs>/calibrate_treadmill.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        roles=roles("treadmill"),
        analysis=config["treadmill"]["analysis"],
        models=config["treadmill"]["models"],
    script:
        "../scripts/calibrate_treadmill.py"


rule plot_treadmill:
    input:
        fit="<results>/fits/treadmill.h5",
        scores="<results>/treadmill_models/treadmill.csv",
        library=library_of("plot_treadmill"),
    output:
        **figure_files("treadmill"),
    log:
        "<logs>/plot_treadmill.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        chosen=config["treadmill"]["chosen"],
    script:
        "../scripts/plot_treadmill.py"
