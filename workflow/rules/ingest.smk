# Raw files to one self-describing HDF5 file per trial. Recorded and simulated files are
# treated alike.

# what a signal can be, for every trial on its way in
PLAUSIBLE = without(SETTINGS["plausible"], *RIG_KEYS)


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
        files=raw_files("wristalyzer"),
        duration_s=sheet("duration_s", "wristalyzer"),
        log_columns=files_setting("wristalyzer", "log_columns"),
        command_columns=files_setting("wristalyzer", "command_columns"),
        angle_unit=files_setting("wristalyzer", "angle_unit"),
        log_named_by=lambda w: STUDY.named_by("wristalyzer", w.condition, "log_columns"),
        command_named_by=lambda w: STUDY.named_by("wristalyzer", w.condition, "command_columns"),
        ingest=SETTINGS["wristalyzer"]["ingest"],
        plausible=PLAUSIBLE,
    script:
        "../scripts/ingest_wristalyzer.py"


rule ingest_plate_treadmill:
    input:
        raw=raw_inputs(),
        library=library_of("ingest_plate_treadmill"),
    output:
        trial="<results>/trials/{experiment}/{condition}.h5",
    log:
        "<logs>/ingest_plate_treadmill/{experiment}/{condition}.log",
    wildcard_constraints:
        experiment="dummy|weight|empty",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=raw_files(),
        named=lambda w: STUDY.named(w.experiment, w.condition),
        duration_s=sheet("duration_s"),
        marker_labels=lambda w: SETTINGS[w.experiment].get("files", {}).get("marker_labels"),
        ingest=lambda w: SETTINGS[w.experiment]["ingest"],
        recording=recording_of(),
        plausible=PLAUSIBLE,
        rig=lambda w: rig_of(STUDY.settings_of(w.experiment, w.condition), w.experiment),
    script:
        "../scripts/ingest_plate_treadmill.py"


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
        files=raw_files("standing"),
        named=lambda w: STUDY.named("standing", w.condition),
        duration_s=sheet("duration_s", "standing"),
        marker_labels=as_it_is(SETTINGS["standing"]["files"]["marker_labels"]),
        emg_trigger=as_it_is(SETTINGS["standing"]["files"]["emg_trigger"]),
        emg_trigger_threshold=SETTINGS["standing"]["files"]["emg_trigger_threshold"],
        emg_channels={m: choice["channel"] for m, choice in SETTINGS["standing"]["muscles"].items()},
        ingest=SETTINGS["standing"]["ingest"],
        recording=recording_of("standing"),
        plausible=PLAUSIBLE,
        rig=lambda w: rig_of(STUDY.settings_of("standing", w.condition), "standing"),
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
        files=raw_files("position_manipulator"),
        named=lambda w: STUDY.named("position_manipulator", w.condition),
        duration_s=sheet("duration_s", "position_manipulator"),
        columns=files_setting("position_manipulator", "columns"),
        delimiter=as_it_is(SETTINGS["position_manipulator"]["files"]["delimiter"]),
        angle_unit=files_setting("position_manipulator", "angle_unit"),
        torque_sign=files_setting("position_manipulator", "torque_sign"),
        named_by=lambda w: STUDY.named_by("position_manipulator", w.condition, "columns"),
        ingest=SETTINGS["position_manipulator"]["ingest"],
        plausible=PLAUSIBLE,
    script:
        "../scripts/ingest_position_manipulator.py"


rule ingest_platform:
    input:
        raw=raw_inputs("platform"),
        library=library_of("ingest_platform"),
    output:
        trial="<results>/trials/platform/{condition}.h5",
    log:
        "<logs>/ingest_platform/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        files=raw_files("platform"),
        named=lambda w: STUDY.named("platform", w.condition),
        duration_s=sheet("duration_s", "platform"),
        columns=files_setting("platform", "columns"),
        delimiter=as_it_is(SETTINGS["platform"]["files"]["delimiter"]),
        angle_unit=files_setting("platform", "angle_unit"),
        torque_sign=files_setting("platform", "torque_sign"),
        platform_unit=SETTINGS["platform"]["files"]["platform_unit"],
        named_by=lambda w: STUDY.named_by("platform", w.condition, "columns"),
        ingest=SETTINGS["platform"]["ingest"],
        plausible=PLAUSIBLE,
    script:
        "../scripts/ingest_platform.py"


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
        files=raw_files("belt"),
        duration_s=sheet("duration_s", "belt"),
        columns=files_setting("belt", "columns"),
        delimiter=as_it_is(SETTINGS["belt"]["files"]["delimiter"]),
        load_unit=SETTINGS["belt"]["files"]["load_unit"],
        ingest=SETTINGS["belt"]["ingest"],
        plausible=PLAUSIBLE,
    script:
        "../scripts/ingest_belt.py"
