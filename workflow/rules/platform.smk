# A person on a platform that moves forwards and backwards: recordings of your own.


rule plot_platform:
    """Draw the figures of the moving platform."""
    input:
        fits=STUDY.of_trials("<results>/fits/platform/{condition}.h5", "platform"),
        estimates=STUDY.of_trials("<results>/estimates/platform/{condition}.csv", "platform"),
        library=library_of("plot", "tepsipe/experiments/platform/figures.py"),
    output:
        **figure_files("platform"),
    log:
        "<logs>/plot_platform.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.platform.figures:draw_platform",
        conditions=STUDY.conditions("platform"),
    script:
        "../scripts/plot.py"
