# Schematics of the rigs and time lines of the trials: thesis sections 2-1 and 3-1-2.


rule plot_rigs:
    """Draw the rigs, flow charts and time lines."""
    input:
        trials=[f"<results>/trials/{e}/{c}.h5" for e, c in STUDY.examples()],
        fits=[f"<results>/fits/{e}/{c}.h5" for e in ("dummy", "weight", "empty") for c in STUDY.conditions(e)],
        epochs=STUDY.of_trials("<results>/epochs/standing/{condition}.h5", "standing"),
        drawings=DRAWINGS,
        library=library_of("plot", "tepsipe/reporting/figures.py"),
    output:
        **figure_files("rigs"),
    log:
        "<logs>/plot_rigs.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="reporting.figures:draw_rigs",
        trials=[name for name, _ in STUDY.examples()],
        fitted=[[e, c] for e in ("dummy", "weight", "empty") for c in STUDY.conditions(e)],
        standing=STUDY.conditions("standing"),
        time_lines=STUDY.time_lines(),
        methods=[*STUDY.experiments, *(["simulation"] if STUDY.has("simulation") else [])],
        geometry=DUMMY["geometry"],
        person=SETTINGS["standing"]["person"],
        mass_kg=SETTINGS["weight"]["weight"]["mass_kg"],
        rate_hz=SETTINGS["dummy"]["ingest"]["resample_rate_hz"],
        sampling_hz=SETTINGS["dummy"]["ingest"]["marker_sampling_hz"],
        cutoff_hz=DUMMY_ANALYSIS["lowpass_cutoff_hz"],
    script:
        "../scripts/plot.py"
