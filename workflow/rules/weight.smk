# Belt-induced force and models of it: thesis sections 2-1-2, 3-1-2 and 4-1-2.

WEIGHT = SETTINGS["weight"]


rule calibrate_plate:
    """Fit models of the force plate's belt-induced load to all trials of a belt."""
    input:
        trials=lambda w: [
            f"<results>/trials/{e}/{c}.h5"
            for e, c, _ in STUDY.treadmill.plate_trials(STUDY.treadmill.plates()[w.plate])
        ],
        library=library_of("calibrate_plate"),
    output:
        Fy="<results>/treadmill_models/{plate}_Fy.json",
        Mx="<results>/treadmill_models/{plate}_Mx.json",
        fit="<results>/fits/{plate}.h5",
        held_out="<results>/treadmill_models/{plate}_held_out.h5",
        scores="<results>/treadmill_models/{plate}.csv",
    log:
        "<logs>/calibrate_{plate}.log",
    wildcard_constraints:
        plate=any_of(STUDY.treadmill.plates()),
    conda:
        "../envs/tepsipe.yaml"
    params:
        trials=lambda w: STUDY.treadmill.plate_trials(STUDY.treadmill.plates()[w.plate]),
        weights=lambda w: [
            STUDY.treadmill.weight_of(e, c)
            for e, c, _ in STUDY.treadmill.plate_trials(STUDY.treadmill.plates()[w.plate])
        ],
        usual_kg=WEIGHT["weight"]["mass_kg"],
        belt=lambda w: STUDY.treadmill.plates()[w.plate],
        analysis=WEIGHT["analysis"],
        models=WEIGHT["models"],
        seed=SEED,
    script:
        "../scripts/calibrate_plate.py"


rule plot_weight:
    """Draw the belt-induced force and its models."""
    input:
        weight=[f"<results>/fits/weight/{c}.h5" for c in STUDY.treadmill.usual_weight()],
        empty=STUDY.of_trials("<results>/fits/empty/{condition}.h5", "empty"),
        plate=f"<results>/fits/{STUDY.shown_plate()}.h5",
        scores=f"<results>/treadmill_models/{STUDY.shown_plate()}.csv",
        library=library_of("plot", "tepsipe/experiments/weight/figures.py"),
    output:
        **figure_files("weight"),
    log:
        "<logs>/plot_weight.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.weight.figures:draw_weight",
        weight=STUDY.treadmill.usual_weight(),
        empty=STUDY.conditions("empty"),
        cutoffs_hz=WEIGHT["analysis"]["cutoffs_hz"],
        mass_kg=WEIGHT["weight"]["mass_kg"],
        coarse=STUDY.shown_several("weight", WEIGHT["figure_5_1_conditions"]),
        example=STUDY.shown("weight", WEIGHT["example_condition"], role="validate"),
    script:
        "../scripts/plot.py"
