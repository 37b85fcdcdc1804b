# TEP-SIPE on simulated data with measurement noise: thesis sections 2-1-3, 3-1-3 and 4-1-3.

NOISE = SETTINGS["noise"]


rule simulate_without_noise:
    """Simulate the noise-free signals of a trial for the noise study."""
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
        geometry=DUMMY["geometry"],
        analysis=DUMMY_ANALYSIS,
        joint=NOISE["joint"],
        step_s=DUMMY["simulation"]["step_s"],
        engine=ENGINE,
    script:
        "../scripts/simulate_without_noise.py"


rule sweep_noise:
    """Estimate the parameters of one cell of the noise study."""
    input:
        fits=lambda w: [f"<results>/fits/without_noise/{c}.h5" for c in STUDY.noise.same_profile(w.condition)],
        library=library_of("sweep_noise"),
    output:
        noise="<results>/noise/{condition}.csv",
    log:
        "<logs>/sweep_noise/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=lambda w: STUDY.noise.same_profile(w.condition),
        geometry=DUMMY["geometry"],
        analysis=DUMMY_ANALYSIS,
        noise=NOISE,
        seed=SEED,
    script:
        "../scripts/sweep_noise.py"


rule collect_noise:
    """Join the cells of the noise study, and lay out Table 4-4."""
    input:
        noise=[f"<results>/noise/{c}.csv" for c in STUDY.noise.conditions()],
        library=library_of("collect_noise"),
    output:
        noise="<results>/tables/noise.csv",
        table="<results>/tables/table_4_4.csv",
    log:
        "<logs>/collect_noise.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        reported=reported_table("table_4_4"),
        table_snr_db=NOISE["table_snr_db"],
        swept_Nm_per_rad=NOISE["joint"]["stiffness_Nm_per_rad"][0],
        averaged=STUDY.noise.averaged(),
    script:
        "../scripts/collect_noise.py"


rule plot_noise:
    """Draw the figures of the noise study."""
    input:
        noise=[f"<results>/noise/{c}.csv" for c in STUDY.noise.conditions()],
        drawings=DRAWINGS,
        library=library_of("plot", "tepsipe/experiments/noise/figures.py"),
    output:
        **figure_files("noise"),
    log:
        "<logs>/plot_noise.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.noise.figures:draw_noise",
        joint=NOISE["joint"],
        protocol=pick(NOISE, "snr_db", "draws") | {"cutoff_hz": DUMMY_ANALYSIS["lowpass_cutoff_hz"]},
        table_snr_db=NOISE["table_snr_db"],
        conditions=STUDY.noise.averaged(),
    script:
        "../scripts/plot.py"
