# A human joint in a position-controlled manipulator: recordings of your own.


rule fit_ankle:
    input:
        trial="<results>/trials/ankle/{condition}.h5",
        library=library_of("fit_ankle"),
    output:
        fit="<results>/fits/ankle/{condition}.h5",
        estimates="<results>/estimates/ankle/{condition}.csv",
    log:
        "<logs>/fit_ankle/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        analysis=config["ankle"]["analysis"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_ankle.py"


rule plot_ankle:
    input:
        fits=of_trials("<results>/fits/ankle/{condition}.h5", "ankle"),
        library=library_of("plot_ankle"),
    output:
        **figure_files("ankle"),
    log:
        "<logs>/plot_ankle.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("ankle"),
    script:
        "../scripts/plot_ankle.py"
