# TEP-SIPE on simulated data with measurement noise: thesis sections 2-1-3, 3-1-3 and 4-1-3.


rule simulate_without_noise:
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        library=library_of("simulate_without_noise"),
    output:
        fit="<results>/fits/without_noise/{condition}.h5",
    log:
        "<logs>/simulate_without_noise/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=SETTINGS["dummy"]["geometry"],
        analysis=SETTINGS["dummy"]["analysis"],
        joint=SETTINGS["noise"]["joint"],
        step_s=SETTINGS["dummy"]["simulation"]["step_s"],
    script:
        "../scripts/simulate_without_noise.py"


rule sweep_noise:
    input:
        fits=lambda w: [f"<results>/fits/without_noise/{c}.h5" for c in same_profile(w)],
        library=library_of("sweep_noise"),
    output:
        noise="<results>/noise/{condition}.csv",
    log:
        "<logs>/sweep_noise/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=same_profile,
        geometry=SETTINGS["dummy"]["geometry"],
        analysis=SETTINGS["dummy"]["analysis"],
        noise=SETTINGS["noise"],
        seed=config["study"]["seed"],
    script:
        "../scripts/sweep_noise.py"


rule collect_noise:
    input:
        noise=[f"<results>/noise/{c}.csv" for c in noise_conditions()],
        reported=config["study"]["reported"] or [],
        library=library_of("collect_noise"),
    output:
        noise=report(
            "<results>/tables/noise.csv",
            caption="../../report/captions/noise.rst",
            category="Tables",
            labels={"table": "noise study"},
        ),
        table=report(
            "<results>/tables/table_4_4.csv",
            caption="../../report/captions/table_4_4.rst",
            category="Tables",
            labels={"table": "table_4_4"},
        ),
    log:
        "<logs>/collect_noise.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        noise=SETTINGS["noise"],
        averaged=[c for c in noise_conditions() if c.startswith("sine")] or noise_conditions(),
    script:
        "../scripts/collect_noise.py"


rule plot_noise:
    input:
        noise=[f"<results>/noise/{c}.csv" for c in noise_conditions()],
        library=library_of("plot_noise"),
    output:
        **figure_files("noise"),
    log:
        "<logs>/plot_noise.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        noise=SETTINGS["noise"],
        conditions=[c for c in noise_conditions() if c.startswith("sine")] or noise_conditions(),
    script:
        "../scripts/plot_noise.py"
