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
