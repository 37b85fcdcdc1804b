# The ankle in the stance phase of walking: belt pulses at random strides.

WALKING = config["walking"]
WALKS = STUDY.conditions("walking")
SIMULATED_WALKS = STUDY.simulated("walking")
TABLES = ["estimates", "uncertainty", "walking", "needed", *(["recovery"] if SIMULATED_WALKS else [])]
OUTPUTS = [*(f"<results>/tables/{name}.csv" for name in TABLES), "<results>/report/walking.pdf"]
FIGURES = ["<results>/figures/figure_walking.svg"]


rule fit_walking:
    """Fit one trial of walking."""
    input:
        raw=raw_inputs("walking"),
        library=library_of("fit_walking", *readers_of(EXPERIMENTS["walking"])),
    output:
        estimates="<results>/estimates/walking/{condition}.csv",
        budgets="<results>/uncertainty/walking/{condition}.csv",
        rows="<results>/estimates/walking/{condition}_phases.csv",
        needed="<results>/estimates/walking/{condition}_needed.csv",
        about="<results>/estimates/walking/{condition}.json",
    log:
        "<logs>/fit_walking/{condition}.log",
    wildcard_constraints:
        condition=any_of(WALKS),
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=raw_files("walking"),
        contents=contents_of("walking"),
        duration_s=sheet("duration_s", "walking"),
        made=lambda w: w.condition in SIMULATED_WALKS,
        section=without(WALKING, "simulated"),
        seed=SEED,
    script:
        "../scripts/fit_walking.py"


rule collect_walking:
    """Join the estimates of all trials of walking."""
    input:
        estimates=STUDY.of_trials("<results>/estimates/walking/{condition}.csv", "walking"),
        budgets=STUDY.of_trials("<results>/uncertainty/walking/{condition}.csv", "walking"),
        rows=STUDY.of_trials("<results>/estimates/walking/{condition}_phases.csv", "walking"),
        needed=STUDY.of_trials("<results>/estimates/walking/{condition}_needed.csv", "walking"),
        library=library_of("collect_walking"),
    output:
        table="<results>/tables/estimates.csv",
        uncertainty="<results>/tables/uncertainty.csv",
        rows="<results>/tables/walking.csv",
        needed="<results>/tables/needed.csv",
    log:
        "<logs>/collect_walking.log",
    conda:
        "../envs/tepsipe.yaml"
    script:
        "../scripts/collect_walking.py"


rule compare_walking_with_truth:
    """Compare the estimates of walking with the truth."""
    input:
        estimates="<results>/tables/estimates.csv",
        truth=[f"<results>/truth/walking/{condition}.csv" for condition in SIMULATED_WALKS],
        library=library_of("compare_walking_with_truth"),
    output:
        table="<results>/tables/recovery.csv",
    log:
        "<logs>/compare_walking_with_truth.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=SIMULATED_WALKS,
    script:
        "../scripts/compare_walking_with_truth.py"


rule plot_walking:
    """Draw the figures of walking."""
    input:
        rows="<results>/tables/walking.csv",
        needed="<results>/tables/needed.csv",
        recovery="<results>/tables/recovery.csv" if SIMULATED_WALKS else [],
        library=library_of("plot", "tepsipe/experiments/walking/figures.py"),
    output:
        **figure_pairs("figure_walking"),
    log:
        "<logs>/plot_walking.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.walking.figures:draw_walking",
        simulated=SIMULATED_WALKS,
    script:
        "../scripts/plot.py"


rule write_walking:
    """Write the numbers of the report on walking."""
    input:
        fits=STUDY.of_trials("<results>/estimates/walking/{condition}.json", "walking"),
        tables=[
            f"<results>/tables/{name}.csv"
            for name in ("walking", "needed", *(["recovery"] if SIMULATED_WALKS else []))
        ],
        provenance=[],
        library=library_of("write_report", *chapter_modules(outputs.OWN_REPORTS["walking"])),
    output:
        data="<results>/report/walking.json",
    log:
        "<logs>/write_walking.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        chapters=outputs.OWN_REPORTS["walking"],
        settings={"walking": {"planned": WALKING["planned"]}},
        study=as_it_is(ABOUT_STUDY | {"code": code_version(CHECKOUT)}),
    script:
        "../scripts/write_report.py"


rule make_walking_trial:
    """Make the raw files of a simulated walk."""
    input:
        library=library_of("make_walking_trial", *readers_of(EXPERIMENTS["walking"])),
    output:
        c3d="<results>/raw/walking/{condition}/log.c3d",
        text="<results>/raw/walking/{condition}/log.txt",
        events="<results>/raw/walking/{condition}/events.csv",
        truth="<results>/truth/walking/{condition}.csv",
    log:
        "<logs>/make_walking_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(SIMULATED_WALKS),
    conda:
        "../envs/tepsipe.yaml"
    params:
        truth=truth_of("seed", "walking"),
        base=lambda w: STUDY.raw_files("walking", WALKING["simulated"]["of"], config["pathvars"]["results"]),
        contents=contents_of("walking", (WALKING["simulated"] or {}).get("of")),
        settings=without(WALKING, "simulated", "analysis", "planned", "uncertainty"),
        protocol=of_trial(STUDY.protocol, "walking"),
        chosen=lambda w: STUDY.simulated_walk(w.condition),
    script:
        "../scripts/make_walking_trial.py"
