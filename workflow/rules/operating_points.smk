# A joint at several operating points, and one that changes within a trial: position-controlled manipulator.


rule tabulate_operating_points:
    """List the operating points, and fit lines through them."""
    input:
        estimates=[
            f"<results>/estimates/position_manipulator/{c}.csv"
            for c in STUDY.manipulators.operating_points()
        ],
        fits=[f"<results>/fits/position_manipulator/{c}.h5" for c in STUDY.manipulators.operating_points()],
        library=library_of("tabulate_operating_points"),
    output:
        points="<results>/tables/operating_points.csv",
        relations="<results>/tables/operating_relations.csv",
    log:
        "<logs>/tabulate_operating_points.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        nominal=STUDY.manipulators.operating_points(),
    script:
        "../scripts/tabulate_operating_points.py"


rule plot_operating_points:
    """Draw stiffness and damping against the operating point."""
    input:
        points="<results>/tables/operating_points.csv",
        relations="<results>/tables/operating_relations.csv",
        library=library_of("plot", "tepsipe/experiments/position_manipulator/figures.py"),
    output:
        **figure_files("operating_points"),
    log:
        "<logs>/plot_operating_points.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.position_manipulator.figures:draw_operating_points",
    script:
        "../scripts/plot.py"


rule vary_position_manipulator:
    """Estimate the impedance that changes within a trial."""
    input:
        trial="<results>/trials/position_manipulator/{condition}.h5",
        fit="<results>/fits/position_manipulator/{condition}.h5",
        library=library_of("vary_position_manipulator"),
    output:
        rows="<results>/time_varying/position_manipulator/{condition}.csv",
    log:
        "<logs>/vary_position_manipulator/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        options=without(SETTINGS["position_manipulator"]["time_varying"], "enabled"),
        seed=SEED,
    script:
        "../scripts/vary_position_manipulator.py"


rule tabulate_time_varying:
    """List the impedance that changes within trials."""
    input:
        rows=STUDY.of_trials(
            "<results>/time_varying/position_manipulator/{condition}.csv", "position_manipulator"
        ),
        library=library_of("tabulate_time_varying"),
    output:
        table="<results>/tables/time_varying.csv",
    log:
        "<logs>/tabulate_time_varying.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/tabulate_time_varying.py"


rule plot_time_varying:
    """Draw the impedance that changes within trials."""
    input:
        table="<results>/tables/time_varying.csv",
        library=library_of("plot", "tepsipe/experiments/position_manipulator/figures.py"),
    output:
        **figure_files("time_varying"),
    log:
        "<logs>/plot_time_varying.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.position_manipulator.figures:draw_time_varying",
    script:
        "../scripts/plot.py"
