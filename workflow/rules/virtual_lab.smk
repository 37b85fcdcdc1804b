# The virtual laboratory writes the instruments' own files. Each rule is given those of its constants that it
# reads; only these rules, and the comparison of estimates with the truth in tables.smk, are given any.

# the person's constants, but for those of a task
PERSON = [f"standing.{part}" for part in ("person", "muscles", "nerves", "markers", "skin", "emg")]


rule make_wristalyzer_trial:
    input:
        library=library_of("make_wristalyzer_trial"),
    output:
        log="<results>/raw/wristalyzer/{condition}/log.txt",
        command="<results>/raw/wristalyzer/{condition}/command.txt",
        motion="<results>/truth/wristalyzer/{condition}.h5",
    log:
        "<logs>/make_wristalyzer_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(STUDY.made("wristalyzer")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        truth=truth_of("seed", "wristalyzer", "dummy.rubber"),
        factor=sheet("amplitude", "wristalyzer"),
        duration_s=sheet("duration_s", "wristalyzer"),
    script:
        "../scripts/make_wristalyzer_trial.py"


rule make_dummy_trial:
    input:
        library=library_of("make_dummy_trial"),
    output:
        log="<results>/raw/dummy/{condition}/log.mat",
        calibration="<results>/raw/dummy/{condition}/calibration.csv",
        markers="<results>/raw/dummy/{condition}/markers.c3d",
        motion="<results>/truth/dummy/{condition}.h5",
    log:
        "<logs>/make_dummy_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(STUDY.made("dummy")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        truth=truth_of("seed", "treadmill", "dummy"),
        protocol=of_trial(STUDY.protocol, "dummy"),
    script:
        "../scripts/make_dummy_trial.py"


rule make_weight_trial:
    input:
        library=library_of("make_weight_trial"),
    output:
        log="<results>/raw/weight/{condition}/log.mat",
        calibration="<results>/raw/weight/{condition}/calibration.csv",
        markers="<results>/raw/weight/{condition}/markers.c3d",
    log:
        "<logs>/make_weight_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(STUDY.made("weight")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        truth=lambda w: truth_of("seed", "treadmill", weight_section(w)),
        protocol=of_trial(STUDY.protocol, "weight"),
        belt=lambda w: STUDY.treadmill.belt_of("weight", w.condition),
    script:
        "../scripts/make_weight_trial.py"


# the same with nothing on the belt
use rule make_weight_trial as make_empty_trial with:
    output:
        log="<results>/raw/empty/{condition}/log.mat",
        calibration="<results>/raw/empty/{condition}/calibration.csv",
    log:
        "<logs>/make_empty_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(STUDY.made("empty")),
    params:
        truth=truth_of("seed", "treadmill"),
        protocol=of_trial(STUDY.protocol, "empty"),
        belt=lambda w: STUDY.treadmill.belt_of("empty", w.condition),


rule make_standing_trial:
    input:
        library=library_of("make_standing_trial"),
    output:
        log="<results>/raw/standing/{condition}/log.mat",
        calibration="<results>/raw/standing/{condition}/calibration.csv",
        markers="<results>/raw/standing/{condition}/markers.c3d",
        emg="<results>/raw/standing/{condition}/emg.edf",
        motion="<results>/truth/standing/{condition}.h5",
    log:
        "<logs>/make_standing_trial/{condition}.log",
    wildcard_constraints:
        condition=any_of(STUDY.made("standing")),
    conda:
        "../envs/tepsipe.yaml"
    params:
        truth=lambda w: truth_of(
            "seed", "treadmill", *PERSON, f"standing.tasks.{sheet('task', 'standing')(w)}"
        ),
        task=sheet("task", "standing"),
        protocol=of_trial(STUDY.protocol, "standing"),
        belt=lambda w: STUDY.treadmill.belt_of("standing", w.condition),
    script:
        "../scripts/make_standing_trial.py"
