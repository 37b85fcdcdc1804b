"""Chapter on the participants: conditions of its sentences; its numbers are those of the tables."""

from tepsipe.reporting.run import Run


def numbers(run: Run) -> dict:
    """No numbers: the tables of participants and of means over them have all, with their units."""
    return {}


def mean_stiffness(run: Run) -> bool:
    """There is a mean of K over participants by a pathway and an estimator that the report shows."""
    return any(
        len(run.rows("group", experiment=experiment, pathway=pathway, estimator=estimator, quantity="K"))
        for experiment, (pathway, estimator) in run.study["shown_of_participants"].items()
    )


PREDICATES = (mean_stiffness,)
