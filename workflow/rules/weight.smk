# Belt-induced force and models of it: thesis sections 2-1-2, 3-1-2 and 4-1-2.


rule fit_weight:
    input:
        trial="<results>/trials/{experiment}/{condition}.h5",
        library=library_of("fit_weight"),
    output:
        fit="<results>/fits/{experiment}/{condition}.h5",
        estimates="<results>/estimates/{experiment}/{condition}.csv",
    log:
        "<logs>/fit_weight/{experiment}/{condition}.log",
    wildcard_constraints:
        experiment="weight|empty",
    conda:
        "../envs/tepsipe.yaml"
    params:
        weight=lambda w: config["weight"]["weight"] if w.experiment == "weight" else None,
        belt=config["weight"]["belt"],
        analysis=config["weight"]["analysis"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_weight.py"


rule calibrate_plate:
    input:
        trials=[f"<results>/trials/{e}/{c}.h5" for e, c, _ in plate_trials()],
        library=library_of("calibrate_plate"),
    output:
        Fy="<results>/treadmill_models/plate_Fy.json",
        Mx="<results>/treadmill_models/plate_Mx.json",
        fit="<results>/fits/plate.h5",
        scores="<results>/treadmill_models/plate.csv",
    log:
        "<logs>/calibrate_plate.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        trials=plate_trials(),
        weight=config["weight"]["weight"],
        belt=config["weight"]["belt"],
        analysis=config["weight"]["analysis"],
        models=config["weight"]["models"],
    script:
        "../scripts/calibrate_plate.py"


rule plot_weight:
    input:
        weight=of_trials("<results>/fits/weight/{condition}.h5", "weight"),
        empty=of_trials("<results>/fits/empty/{condition}.h5", "empty"),
        plate="<results>/fits/plate.h5",
        scores="<results>/treadmill_models/plate.csv",
        library=library_of("plot_weight"),
    output:
        **figure_files("weight"),
    log:
        "<logs>/plot_weight.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        weight=conditions("weight"),
        empty=conditions("empty"),
        cutoffs_hz=config["weight"]["analysis"]["cutoffs_hz"],
        mass_kg=config["weight"]["weight"]["mass_kg"],
        coarse=shown_conditions("weight", config["weight"]["figure_5_1_conditions"]),
        example=shown_validating("weight", config["weight"]["example_condition"]),
    script:
        "../scripts/plot_weight.py"
