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
        log_columns=SETTINGS["wristalyzer"]["files"]["log_columns"],
        command_columns=SETTINGS["wristalyzer"]["files"]["command_columns"],
        angle_unit=SETTINGS["wristalyzer"]["files"]["angle_unit"],
        ingest=SETTINGS["wristalyzer"]["ingest"],
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
        marker_labels=SETTINGS["dummy"]["files"]["marker_labels"],
        ingest=SETTINGS["dummy"]["ingest"],
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
        marker_labels=SETTINGS["weight"]["files"]["marker_labels"],
        ingest=SETTINGS["weight"]["ingest"],
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
        ingest=SETTINGS["empty"]["ingest"],
    script:
        "../scripts/ingest_empty.py"


rule ingest_standing:
    input:
        raw=raw_inputs("standing"),
        library=library_of("ingest_standing"),
    output:
        trial="<results>/trials/standing/{condition}.h5",
    log:
        "<logs>/ingest_standing/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "standing"),
        duration_s=lambda w: trial(w, "standing").duration_s,
        marker_labels=SETTINGS["standing"]["files"]["marker_labels"],
        emg_trigger=SETTINGS["standing"]["files"]["emg_trigger"],
        emg_trigger_threshold=SETTINGS["standing"]["files"]["emg_trigger_threshold"],
        emg_channels={m: choice["channel"] for m, choice in SETTINGS["standing"]["muscles"].items()},
        ingest=SETTINGS["standing"]["ingest"],
    script:
        "../scripts/ingest_standing.py"


rule ingest_position_manipulator:
    input:
        raw=raw_inputs("position_manipulator"),
        library=library_of("ingest_position_manipulator"),
    output:
        trial="<results>/trials/position_manipulator/{condition}.h5",
    log:
        "<logs>/ingest_position_manipulator/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "position_manipulator"),
        duration_s=lambda w: trial(w, "position_manipulator").duration_s,
        columns=SETTINGS["position_manipulator"]["files"]["columns"],
        delimiter=SETTINGS["position_manipulator"]["files"]["delimiter"],
        angle_unit=SETTINGS["position_manipulator"]["files"]["angle_unit"],
        torque_sign=SETTINGS["position_manipulator"]["files"]["torque_sign"],
        ingest=SETTINGS["position_manipulator"]["ingest"],
    script:
        "../scripts/ingest_position_manipulator.py"


rule ingest_belt:
    input:
        raw=raw_inputs("belt"),
        library=library_of("ingest_belt"),
    output:
        trial="<results>/trials/belt/{condition}.h5",
    log:
        "<logs>/ingest_belt/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=lambda w: raw_files(w, "belt"),
        duration_s=lambda w: trial(w, "belt").duration_s,
        columns=lambda w: trial(w, "belt").columns,
        delimiter=SETTINGS["belt"]["files"]["delimiter"],
        load_unit=SETTINGS["belt"]["files"]["load_unit"],
        ingest=SETTINGS["belt"]["ingest"],
    script:
        "../scripts/ingest_belt.py"
