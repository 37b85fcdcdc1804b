# Validation of parameters by forward simulation of the dummy: thesis sections 2-1-3 and 4-1-3, Appendix B.

# number of a figure of Appendix B -> its trial
NUMBERED = {f.rpartition("_")[2]: c for f, c in zip(APPENDIX, STUDY.conditions("dummy"))}


rule simulate_dummy:
    """Simulate a trial of the dummy with every parameter set."""
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        estimates="<results>/estimates/dummy/{condition}.csv",
        fit="<results>/fits/dummy/{condition}.h5",
        wristalyzer=STUDY.of_trials("<results>/estimates/wristalyzer/{condition}.csv", "wristalyzer"),
        library=library_of("simulate_dummy"),
    output:
        fit="<results>/fits/simulation/{condition}.h5",
        forward="<results>/forward/{condition}.csv",
    log:
        "<logs>/simulate_dummy/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=DUMMY["geometry"],
        analysis=DUMMY_ANALYSIS,
        belt=lambda w: STUDY.treadmill.belt_of("dummy", w.condition),
        belt_fixed_labels=as_it_is(DUMMY["foot"]["belt_fixed_labels"]),
        as_printed=DUMMY["as_printed"],
        recommended=DUMMY["recommended"],
        quoted=DUMMY["quoted"],
        printed=printed_joints,
        step_s=DUMMY["simulation"]["step_s"],
        engine=ENGINE,
        # one trial is simulated by both engines
        compared=lambda w: w.condition == STUDY.shown("dummy", DUMMY["simulation"]["figure_4_7_condition"]),
    script:
        "../scripts/simulate_dummy.py"


rule collect_forward:
    """Join the scores of the forward simulations in one table."""
    input:
        forward=STUDY.of_trials("<results>/forward/{condition}.csv", "dummy"),
        library=library_of("collect_forward"),
    output:
        table="<results>/tables/forward.csv",
    log:
        "<logs>/collect_forward.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/collect_forward.py"


rule plot_simulation:
    """Draw the comparison of the parameter sets in forward simulations."""
    input:
        fits=STUDY.of_trials("<results>/fits/simulation/{condition}.h5", "dummy"),
        forward="<results>/tables/forward.csv",
        drawings=DRAWINGS,
        library=library_of("plot", "tepsipe/experiments/forward/figures.py"),
    output:
        **figure_files("simulation"),
    log:
        "<logs>/plot_simulation.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.forward.figures:draw_simulation",
        conditions=STUDY.conditions("dummy"),
        frequent=STUDY.shown("dummy", DUMMY["simulation"]["figure_4_7_condition"]),
        geometry=DUMMY["geometry"],
        rare=STUDY.shown("dummy", DUMMY["simulation"]["figure_4_8_condition"]),
    script:
        "../scripts/plot.py"


rule plot_simulation_trial:
    """Draw the simulations of one trial of the dummy, a figure of Appendix B."""
    input:
        fit=lambda w: f"<results>/fits/simulation/{NUMBERED[w.number]}.h5",
        library=library_of("plot", "tepsipe/experiments/forward/figures.py"),
    output:
        **{
            "figure_b_trial": "<results>/figures/figure_b_{number}.svg",
            "figure_b_trial_csv": "<results>/figures/figure_b_{number}.csv",
        },
    log:
        "<logs>/plot_simulation_trial/{number}.log",
    wildcard_constraints:
        number=any_of(NUMBERED),
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.forward.figures:draw_simulation_trial",
    script:
        "../scripts/plot.py"
