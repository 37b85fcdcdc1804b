"""Ten lines for the reader in a hurry: what the thesis found, why, what to do instead, how sure."""

from tepsipe.reporting.numbers.abstract import Paragraph, pieces


def summary_of(data: dict) -> list[Paragraph]:
    """End of the summary of a reproduction of the thesis (units in it); empty for other studies.

    Parameters
    ----------
    data : dict
        Data of the report: ``reported``, ``standing``, texts.

    Returns
    -------
    list of paragraphs
        Pieces of text, see `tepsipe.reporting.numbers.abstract`.
    """
    if data["reported"] is None or "dummy" not in data["experiments"]:
        return []
    return _person(data)


def _person(data: dict) -> list[Paragraph]:
    p = data.get("standing")
    if p is None or p.get("participants") is not None:
        return []
    wanted = p["recommended"]["estimator"]
    rows = [row for row in p["estimators"] if row["name"] == wanted]
    if not rows:
        return []
    values = ", ".join(f"{row['stiffness']} N·m/rad ({row['task']})" for row in rows)
    return [
        pieces(
            "*On a person* the method needs the force plate and a model of the treadmill; the intrinsic "
            "stiffness of both ankles is then {values} ([@standing]).",
            values=values,
        )
    ]
