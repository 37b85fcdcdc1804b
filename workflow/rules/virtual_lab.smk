# The virtual laboratory writes the instruments' own files. Only these rules, and the comparison of
# estimates with the truth in tables.smk, read the laboratory's constants.


rule make_wristalyzer_trial:
    input:
        truth=config["study"]["virtual_lab"] or [],
        library=library_of("make_wristalyzer_trial"),
    output:
        log="<results>/raw/wristalyzer/{condition}/log.txt",
        command="<results>/raw/wristalyzer/{condition}/command.txt",
    log:
        "<logs>/make_wristalyzer_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(made_conditions("wristalyzer")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        factor=lambda w: trial(w, "wristalyzer").amplitude,
        duration_s=lambda w: trial(w, "wristalyzer").duration_s,
    script:
        "../scripts/make_wristalyzer_trial.py"


rule make_dummy_trial:
    input:
        truth=config["study"]["virtual_lab"] or [],
        library=library_of("make_dummy_trial"),
    output:
        log="<results>/raw/dummy/{condition}/log.mat",
        calibration="<results>/raw/dummy/{condition}/calibration.csv",
        markers="<results>/raw/dummy/{condition}/markers.c3d",
    log:
        "<logs>/make_dummy_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(made_conditions("dummy")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        profile=lambda w: trial(w, "dummy").profile,
        amplitude_m_per_s=lambda w: trial(w, "dummy").amplitude,
        interval_s=lambda w: trial(w, "dummy").interval_s,
        duration_s=lambda w: trial(w, "dummy").duration_s,
    script:
        "../scripts/make_dummy_trial.py"


rule make_weight_trial:
    input:
        truth=config["study"]["virtual_lab"] or [],
        library=library_of("make_weight_trial"),
    output:
        log="<results>/raw/weight/{condition}/log.mat",
        calibration="<results>/raw/weight/{condition}/calibration.csv",
        markers="<results>/raw/weight/{condition}/markers.c3d",
    log:
        "<logs>/make_weight_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(made_conditions("weight")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        profile=lambda w: trial(w, "weight").profile,
        amplitude_m_per_s=lambda w: trial(w, "weight").amplitude,
        interval_s=lambda w: trial(w, "weight").interval_s,
        duration_s=lambda w: trial(w, "weight").duration_s,
    script:
        "../scripts/make_weight_trial.py"


rule make_empty_trial:
    input:
        truth=config["study"]["virtual_lab"] or [],
        library=library_of("make_empty_trial"),
    output:
        log="<results>/raw/empty/{condition}/log.mat",
        calibration="<results>/raw/empty/{condition}/calibration.csv",
    log:
        "<logs>/make_empty_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(made_conditions("empty")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        profile=lambda w: trial(w, "empty").profile,
        amplitude_m_per_s=lambda w: trial(w, "empty").amplitude,
        interval_s=lambda w: trial(w, "empty").interval_s,
        duration_s=lambda w: trial(w, "empty").duration_s,
    script:
        "../scripts/make_empty_trial.py"


rule make_standing_trial:
    input:
        truth=config["study"]["virtual_lab"] or [],
        library=library_of("make_standing_trial"),
    output:
        log="<results>/raw/standing/{condition}/log.mat",
        calibration="<results>/raw/standing/{condition}/calibration.csv",
        markers="<results>/raw/standing/{condition}/markers.c3d",
        emg="<results>/raw/standing/{condition}/emg.edf",
    log:
        "<logs>/make_standing_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(made_conditions("standing")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        task=lambda w: trial(w, "standing").task,
        profile=lambda w: trial(w, "standing").profile,
        amplitude_m_per_s=lambda w: trial(w, "standing").amplitude,
        interval_s=lambda w: trial(w, "standing").interval_s,
        longest_interval_s=lambda w: trial(w, "standing").longest_interval_s,
        duration_s=lambda w: trial(w, "standing").duration_s,
    script:
        "../scripts/make_standing_trial.py"
