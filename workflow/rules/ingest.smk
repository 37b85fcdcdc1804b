# Raw files to one self-describing HDF5 file per trial. Nothing here knows whether a file was
# recorded or made.


rule ingest_wristalyzer:
    input:
        raw=raw_inputs("wristalyzer"),
        library=library_of("ingest_wristalyzer"),
    output:
        trial="<results>/trials/wristalyzer/{condition}.h5",
    log:
        "<logs>/ingest_wristalyzer/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "wristalyzer"),
        duration_s=lambda w: trial(w, "wristalyzer").duration_s,
        log_columns=config["wristalyzer"]["files"]["log_columns"],
        command_columns=config["wristalyzer"]["files"]["command_columns"],
        angle_unit=config["wristalyzer"]["files"]["angle_unit"],
        ingest=config["wristalyzer"]["ingest"],
    script:
        "../scripts/ingest_wristalyzer.py"


rule ingest_dummy:
    input:
        raw=raw_inputs("dummy"),
        library=library_of("ingest_dummy"),
    output:
        trial="<results>/trials/dummy/{condition}.h5",
    log:
        "<logs>/ingest_dummy/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "dummy"),
        duration_s=lambda w: trial(w, "dummy").duration_s,
        marker_labels=config["dummy"]["files"]["marker_labels"],
        ingest=config["dummy"]["ingest"],
    script:
        "../scripts/ingest_dummy.py"


rule ingest_weight:
    input:
        raw=raw_inputs("weight"),
        library=library_of("ingest_weight"),
    output:
        trial="<results>/trials/weight/{condition}.h5",
    log:
        "<logs>/ingest_weight/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "weight"),
        duration_s=lambda w: trial(w, "weight").duration_s,
        marker_labels=config["weight"]["files"]["marker_labels"],
        ingest=config["weight"]["ingest"],
    script:
        "../scripts/ingest_weight.py"


rule ingest_empty:
    input:
        raw=raw_inputs("empty"),
        library=library_of("ingest_empty"),
    output:
        trial="<results>/trials/empty/{condition}.h5",
    log:
        "<logs>/ingest_empty/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "empty"),
        duration_s=lambda w: trial(w, "empty").duration_s,
        ingest=config["empty"]["ingest"],
    script:
        "../scripts/ingest_empty.py"


rule ingest_pilot:
    input:
        raw=raw_inputs("pilot"),
        library=library_of("ingest_pilot"),
    output:
        trial="<results>/trials/pilot/{condition}.h5",
    log:
        "<logs>/ingest_pilot/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "pilot"),
        duration_s=lambda w: trial(w, "pilot").duration_s,
        marker_labels=config["pilot"]["files"]["marker_labels"],
        emg_trigger=config["pilot"]["files"]["emg_trigger"],
        emg_trigger_threshold=config["pilot"]["files"]["emg_trigger_threshold"],
        emg_channels={m: choice["channel"] for m, choice in config["pilot"]["muscles"].items()},
        ingest=config["pilot"]["ingest"],
    script:
        "../scripts/ingest_pilot.py"


rule ingest_ankle:
    input:
        raw=raw_inputs("ankle"),
        library=library_of("ingest_ankle"),
    output:
        trial="<results>/trials/ankle/{condition}.h5",
    log:
        "<logs>/ingest_ankle/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "ankle"),
        duration_s=lambda w: trial(w, "ankle").duration_s,
        columns=config["ankle"]["files"]["columns"],
        delimiter=config["ankle"]["files"]["delimiter"],
        angle_unit=config["ankle"]["files"]["angle_unit"],
        torque_sign=config["ankle"]["files"]["torque_sign"],
        ingest=config["ankle"]["ingest"],
    script:
        "../scripts/ingest_ankle.py"


rule ingest_treadmill:
    input:
        raw=raw_inputs("treadmill"),
        library=library_of("ingest_treadmill"),
    output:
        trial="<results>/trials/treadmill/{condition}.h5",
    log:
        "<logs>/ingest_treadmill/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "treadmill"),
        duration_s=lambda w: trial(w, "treadmill").duration_s,
        columns=lambda w: trial(w, "treadmill").columns,
        delimiter=config["treadmill"]["files"]["delimiter"],
        load_unit=config["treadmill"]["files"]["load_unit"],
        ingest=config["treadmill"]["ingest"],
    script:
        "../scripts/ingest_treadmill.py"
