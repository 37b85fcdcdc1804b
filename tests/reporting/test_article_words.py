"""Sentences of the article that compare are assertions (`says`), or stand in the list of exceptions below."""

import re

import pytest
from typst_builders import REPORT

CHAPTERS = (
    *(
        "introduction",
        "methods",
        "rigs",
        "wristalyzer",
        "wristalyzer_further",
        "dummy",
        "simulation",
        "noise",
    ),
    *("weight", "standing", "discussion", "thesis_dummy", "flow", "planning"),
)
SOURCES = {name: f"chapters/{name}.typ" for name in CHAPTERS}
SOURCES |= {name: f"{name}.typ" for name in ("findings", "abstract")}
COMPARING = (
    r"falls?|rises?|increases?|decreases?|exceeds?|larger|smaller|higher|lower|better|worse|worst|"
    r"more than|less than|agrees?|highest|lowest"
)
WORD = re.compile(rf"(?<![\w.-])(?:{COMPARING})(?![\w(-]|[.:]\w| ?=>)")
# what no number of a run decides: literature, definitions, general mechanisms, statements and numbers of the
# thesis, conditions, and words that introduce a printed number
EXCEPTIONS = {
    "introduction": ["Stiffness increases with muscle torque", "random error and rise time"],
    "rigs": ["[lower bound]"],
    "wristalyzer": [
        "The lowest coherence within the fitted band is #num",
        "Cross-validated VAFs fall if",
        "(the lowest VAF in Table 4-1)",
        "percentage points lower#if",
    ],
    "wristalyzer_further": [
        "The lowest coherence at scale factor #best is closest",
        "neighbouring frequencies decreases with noise",
        "whole periods decreases with noise",
        "a torque that increases with the cube",
    ],
    "dummy": [
        "At smaller amplitudes the largest errors are #largest-error",
        "The thesis states that a higher velocity lowers the standard deviation",
        "Our claims compare the lowest with the highest velocity",
        "From one velocity to the next higher one",
        "%; the lowest has #fixed",
    ],
    "noise": [
        "The thesis states that onsets are easier to detect at higher",
        "[lowest SNR",
        "lowest SNR at and",
    ],
    "weight": [
        "Where masses and shapes agree with the thesis, they do so by construction",
        "of the laboratories with randomly drawn clock offsets have a belt-induced force that rises",
        "The lowest $R^2$ of the pitch moment over the loads is #moment",
        "whichever has the smaller error",
        "if this error may exceed a tenth",
    ],
    "simulation": ["Our claim on this torque refers to the lowest VAF"],
    "standing": ["spreads activity over more than 60 ms"],
    "thesis_dummy": [
        "The stiffness of the joint falls and its damping rises as it is bent",
        "cannot reproduce the fall of the printed",
        "$E$ increases by $l$ times",
        "A lag of the centre of mass has a smaller effect",
        "The VAF of this angle falls below #short",
        "and the fall of $K$ with amplitude. They also show that $B$ rises",
        "while $K$ falls on the treadmill",
    ],
    "findings": ["#owner(rows.last().parameter_set) worst"],
    "planning": [
        "a better filter",
        "Where tolerances exceed the noise, better scales",
        "lower bound of Type A",
        "may not exceed their peaks",
        "all stiffness matrices that agree",
    ],
}


def blank(found):
    """As many blanks, with the ends of lines."""
    return re.sub(r"[^\n]", " ", found if isinstance(found, str) else found[0])


def prose(text):
    """A source with blanks in place of comments, assertions, mathematics, quotations and code."""
    text = re.sub(r"(?m)//.*$", blank, text)
    while found := re.search(r'says\("[\w.]+"\)\[', text):
        stop, depth = found.end(), 1
        while depth:
            depth += (text[stop] == "[") - (text[stop] == "]")
            stop += 1
        text = text[: found.start()] + blank(text[found.start() : stop]) + text[stop:]
    for code in (r"\$[^$]*\$", r'"[^"\n]*"|“[^”]*”', r"#?let .*", *[r"[\w.-]+\([^()]*\)"] * 2):
        text = re.sub(code, blank, text)
    return text


def comparing(source):
    """Comparing words of a source outside assertions: place, and the text around each."""
    text = (REPORT / source).read_text(encoding="utf-8")
    for found in WORD.finditer(prose(text)):
        around = text[max(0, found.start() - 110) : found.end() + 90]
        yield f"{source}:{text.count(chr(10), 0, found.start()) + 1}", " ".join(around.split())


@pytest.mark.parametrize("name", SOURCES)
def test_a_sentence_that_compares_is_an_assertion(name):
    excepted = EXCEPTIONS.get(name, ())
    assert [one for one in comparing(SOURCES[name]) if not any(words in one[1] for words in excepted)] == []


@pytest.mark.parametrize("name", EXCEPTIONS)
def test_no_exception_is_left_over(name):
    around = " ".join(words for _, words in comparing(SOURCES[name]))
    assert [words for words in EXCEPTIONS[name] if words not in around] == []


def test_comparing_words_are_found_outside_assertions_alone():
    text = 'K falls. #says("a.b")[K [1] falls.] // falls\n“it falls” #falls(1) $falls$ is higher'
    assert WORD.findall(prose(text)) == ["falls", "higher"]
