# A human joint in a position-controlled manipulator: recordings of your own.


rule fit_position_manipulator:
    input:
        trial="<results>/trials/position_manipulator/{condition}.h5",
        library=library_of("fit_position_manipulator"),
    output:
        fit="<results>/fits/position_manipulator/{condition}.h5",
        estimates="<results>/estimates/position_manipulator/{condition}.csv",
    log:
        "<logs>/fit_position_manipulator/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        section=section_of("position_manipulator", "analysis"),
        seed=SEED,
    script:
        "../scripts/fit_position_manipulator.py"


rule plot_position_manipulator:
    input:
        fits=STUDY.of_trials("<results>/fits/position_manipulator/{condition}.h5", "position_manipulator"),
        library=library_of("plot", "tepsipe/experiments/position_manipulator/figures.py"),
    output:
        **figure_files("position_manipulator"),
    log:
        "<logs>/plot_position_manipulator.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.position_manipulator.figures:draw_position_manipulator",
        conditions=STUDY.conditions("position_manipulator"),
    script:
        "../scripts/plot.py"
