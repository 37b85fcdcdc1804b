# A human joint in a position-controlled manipulator: recordings of your own.


rule plot_position_manipulator:
    """Draw the figures of the position-controlled manipulator."""
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
