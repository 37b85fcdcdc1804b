"""Chapter on a human joint, of data that show the opposite of the usual."""

import pandas as pd
import pytest
from joint_builders import content_of, fit_of, rows_of, run_of
from typst_builders import typeset_words


def manipulator(usual):
    """Two trials; a clear reflex that raises the VAF, or none that could be seen."""
    vafs = [(80.0, 93.0), (90.0, 95.0)] if usual else [(-40.0, -60.0), (20.0, 30.0)]
    made = (
        {"delays_s": (0.04, 0.05), "lasting_s": 0.5, "short_range": True}
        if usual
        else {"delays_s": (0.04, 0.04), "lasting_s": 0.1, "assumed": False, "relaxing": True}
    )
    made |= {} if usual else {"p": 0.001, "white": 0.5, "memory_s": 4.0, "slow": 10.0, "coherent": 0.5}
    gain = (8.0, 12.0) if usual else (-2.0, 12.0)
    frames = [
        rows_of(condition, alone=alone, cascade=cascade, gain=gain, flags="" if usual else "at-bound")
        for condition, (alone, cascade) in zip("ab", vafs, strict=True)
    ]
    joint = {"name": "ankle", "positive": "dorsiflexion", "negative": "plantarflexion"} if usual else None
    return content_of(run_of({"a": fit_of(**made), "b": fit_of(**made)}, pd.concat(frames), joint))


@pytest.fixture(scope="module", params=[True, False], ids=["usual", "contrary"])
def told(request):
    """Whether the data are usual, and words of the chapter, typeset without figures."""
    data, tables = manipulator(request.param)
    data |= {"names": {}}
    source = (
        '#set heading(numbering: "1.1")\n'
        '#include "chapters/position_manipulator.typ"\n'
        '#include "chapters/position_manipulator_methods.typ"\n'
        '#bibliography("references.bib", style: "ieee")\n'
    )
    return request.param, typeset_words(source, data, tables)


USUAL = (
    "A human ankle in a",
    "responds to dorsiflexion",
    "predicts every held-out part better than inertia",
    "delays of 40 to 50 ms predict the fitted part as well",
    "in both trials). K is the stiffness beyond the yield angle",
    "is not the gain of the short-latency stretch reflex alone",
    "The residual is not white",
    "The memory of the residual is shorter than a block",
    "does not differ between the thirds of any record",
    "lies below 1 Hz. It is due to slow changes",
)
CONTRARY = (
    "A joint in a",
    "responds to increasing angles",
    "do not predict the torque of the held-out part of every trial",
    "does not predict every held-out part better",
    "The interval contains 0",
    "delays other than 40 ms predict the fitted part worse",
    "Its response ends",
    "The residual is white up to",
    "so the intervals there are too narrow",
    "differs between the thirds of a and b",
    "voluntary torque drifted",
    "An asterisk marks an estimate that failed a check",
)


def test_chapters_tell_what_their_data_show_and_nothing_else(told):
    usual, words = told
    for sentence in USUAL:
        assert (sentence in words) is usual, sentence
    for sentence in CONTRARY:
        assert (sentence in words) is not usual, sentence
