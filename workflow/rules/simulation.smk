# The dummy in a forward simulation, as the judge of parameters: thesis sections 2-1-3 and 4-1-3, Appendix B.


rule simulate_dummy:
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        estimates="<results>/estimates/dummy/{condition}.csv",
        wristalyzer=of_trials("<results>/estimates/wristalyzer/{condition}.csv", "wristalyzer"),
        library=library_of("simulate_dummy"),
    output:
        fit="<results>/fits/simulation/{condition}.h5",
        forward="<results>/forward/{condition}.csv",
    log:
        "<logs>/simulate_dummy/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=SETTINGS["dummy"]["geometry"],
        analysis=SETTINGS["dummy"]["analysis"],
        as_printed=SETTINGS["dummy"]["as_printed"],
        recommended=SETTINGS["dummy"]["recommended"],
        step_s=SETTINGS["dummy"]["simulation"]["step_s"],
    script:
        "../scripts/simulate_dummy.py"


rule collect_forward:
    input:
        forward=of_trials("<results>/forward/{condition}.csv", "dummy"),
        library=library_of("collect_forward"),
    output:
        table=report(
            "<results>/tables/forward.csv",
            caption="../../report/captions/forward.rst",
            category="Tables",
            labels={"table": "forward simulations"},
        ),
    log:
        "<logs>/collect_forward.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/collect_forward.py"


rule plot_simulation:
    input:
        fits=of_trials("<results>/fits/simulation/{condition}.h5", "dummy"),
        forward="<results>/tables/forward.csv",
        library=library_of("plot_simulation"),
    output:
        **figure_files("simulation"),
    log:
        "<logs>/plot_simulation.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("dummy"),
        frequent=shown_condition("dummy", SETTINGS["dummy"]["simulation"]["figure_4_7_condition"]),
        rare=shown_condition("dummy", SETTINGS["dummy"]["simulation"]["figure_4_8_condition"]),
    script:
        "../scripts/plot_simulation.py"
