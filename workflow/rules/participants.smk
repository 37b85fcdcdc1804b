# Participants: values of every person, means over people.


rule tabulate_participants:
    """List the values of every participant, and means over participants."""
    input:
        estimates="<results>/tables/estimates.csv",
        uncertainty="<results>/tables/uncertainty.csv",
        library=library_of("tabulate_participants"),
    output:
        participants="<results>/tables/participants.csv",
        group="<results>/tables/group.csv",
    log:
        "<logs>/tabulate_participants.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        members=groups.members(STUDY),
        masses_kg=groups.masses_kg(STUDY),
        by_belt=STUDY.by_belt,
    script:
        "../scripts/tabulate_participants.py"


rule plot_participants:
    """Draw the values of every participant."""
    input:
        participants="<results>/tables/participants.csv",
        group="<results>/tables/group.csv",
        library=library_of("plot", "tepsipe/reporting/figures.py"),
    output:
        **figure_files("participants"),
    log:
        "<logs>/plot_participants.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="reporting.figures:draw_participants",
        shown=groups.shown_estimators(STUDY),
    script:
        "../scripts/plot.py"
