# A person standing on the treadmill: thesis sections 2-2, 3-2 and 4-2, and their continuation.

STANDING = SETTINGS["standing"]


rule fit_standing_task:
    """Fit all trials of one task of a standing person together."""
    input:
        responses=lambda w: STUDY.tasks.of_trials("<results>/epochs/standing/{condition}.h5", w.task),
        others=lambda w: STUDY.tasks.of_other_tasks("<results>/epochs/standing/{condition}.h5", w.task),
        library=library_of("fit_standing_task"),
    output:
        fit="<results>/fits/standing_tasks/{task}.h5",
        estimates="<results>/estimates/standing_tasks/{task}.csv",
        uncertainty="<results>/uncertainty/standing_tasks/{task}.csv",
    log:
        "<logs>/fit_standing_task/{task}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        section=lambda w: pick(
            STANDING | {"person": STUDY.person(STUDY.tasks.pools()[w.task].participant)},
            *("person", "analysis.bootstrap_draws", "analysis.tried_windows_s", "pathways", "recommended"),
            *("estimators", "active", "muscles.*.ankle_action", "free_reflex"),
            *("muscles.*.lengthened_by", "latency"),
        ),
        uncertainty=SETTINGS["uncertainty"]["standing"],
        seed=SEED,
    script:
        "../scripts/fit_standing_task.py"


rule compare_standing_tasks:
    """Estimate the difference in impedance between two tasks of a person."""
    input:
        more=lambda w: f"<results>/fits/standing_tasks/{STUDY.tasks.pairs()[w.pair][0]}.h5",
        less=lambda w: f"<results>/fits/standing_tasks/{STUDY.tasks.pairs()[w.pair][1]}.h5",
        library=library_of("compare_standing_tasks"),
    output:
        estimates="<results>/estimates/standing_pairs/{pair}.csv",
        uncertainty="<results>/uncertainty/standing_pairs/{pair}.csv",
    log:
        "<logs>/compare_standing_tasks/{pair}.log",
    wildcard_constraints:
        pair=any_of(STUDY.tasks.pairs()),
    conda:
        "../envs/tepsipe.yaml"
    params:
        recommended=STANDING["recommended"],
    script:
        "../scripts/compare_standing_tasks.py"


rule plot_standing_trials:
    """Draw Figures 4-13 and 4-14 of one trial of the standing person."""
    input:
        responses="<results>/epochs/standing/{condition}.h5",
        library=library_of("plot", "tepsipe/experiments/standing/figures.py"),
    output:
        **{f"{n}_png": f"<results>/figures/standing/{{condition}}_{n}.png" for n in outputs.STANDING_FIGURES},
    log:
        "<logs>/plot_standing_trials/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.standing.figures:draw_standing_trials",
    script:
        "../scripts/plot.py"


rule plot_standing:
    """Draw the figures of the standing person."""
    input:
        example=f"<results>/epochs/standing/{STUDY.shown('standing', STANDING['example_condition'])}.h5",
        trials=[f"<results>/fits/standing/{c}.h5" for c in STUDY.tasks.shown_trials()],
        tasks=[f"<results>/fits/standing_tasks/{task}.h5" for task in STUDY.tasks.shown()],
        library=library_of("plot", "tepsipe/experiments/standing/figures.py"),
    output:
        **figure_files("standing"),
    log:
        "<logs>/plot_standing.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.standing.figures:draw_standing",
        conditions=list(STUDY.tasks.shown_trials()),
        tasks=list(STUDY.tasks.shown()),
        task_of=STUDY.tasks.shown_trials(),
        detector=STANDING["latency"]["detector"],
        recommended=STANDING["recommended"],
        active=STUDY.estimators.active(),
        groups=STUDY.tasks.groups(),
        window_s=STANDING["estimators"][STANDING["recommended"]["estimator"]]["window_s"],
        muscles=list(STANDING["muscles"]),
    script:
        "../scripts/plot.py"


# the same of any participant, on demand
use rule plot_standing as plot_standing_of_participant with:
    input:
        example=lambda w: f"<results>/epochs/standing/{next(iter(STUDY.tasks.shown_trials(w.participant)))}.h5",
        trials=lambda w: [f"<results>/fits/standing/{c}.h5" for c in STUDY.tasks.shown_trials(w.participant)],
        tasks=lambda w: [f"<results>/fits/standing_tasks/{t}.h5" for t in STUDY.tasks.shown(w.participant)],
        library=library_of("plot", "tepsipe/experiments/standing/figures.py"),
    output:
        **figure_files("standing", "standing/{participant}"),
    log:
        "<logs>/plot_standing/{participant}.log",
    wildcard_constraints:
        participant=any_of(STUDY.participants("standing")),
    params:
        drawn_by="experiments.standing.figures:draw_standing",
        conditions=lambda w: list(STUDY.tasks.shown_trials(w.participant)),
        tasks=lambda w: list(STUDY.tasks.shown(w.participant)),
        task_of=lambda w: STUDY.tasks.shown_trials(w.participant),
        detector=STANDING["latency"]["detector"],
        recommended=STANDING["recommended"],
        active=STUDY.estimators.active(),
        groups=lambda w: STUDY.tasks.groups(w.participant),
        window_s=STANDING["estimators"][STANDING["recommended"]["estimator"]]["window_s"],
        muscles=list(STANDING["muscles"]),
