"""Sentences of the article that compare are assertions (`says`), or stand in the list of exceptions below."""

import re

import pytest
from typst_builders import REPORT

# all sources of article and supplement that have prose
NO_PROSE = ("position_manipulator", "position_manipulator_methods", "operating_points", "time_varying")
NO_PROSE += ("belt", "platform", "participants")
SOURCES = {
    path.stem: f"chapters/{path.name}"
    for path in sorted((REPORT / "chapters").glob("*.typ"))
    if path.stem not in NO_PROSE
}
SOURCES["findings"] = "findings.typ"
COMPARING = (
    r"falls?|rises?|increases?|decreases?|exceeds?|larger|smaller|higher|lower|better|worse|worst|"
    r"more than|less than|agrees?|highest|lowest"
)
WORD = re.compile(rf"(?<![\w.-])(?:{COMPARING})(?![\w(-]|[.:]\w| ?=>)")
# what no number of a run decides: literature, definitions, general mechanisms, statements and numbers of the
# thesis, conditions, and words that introduce a printed number
EXCEPTIONS = {
    "introduction": [
        "Stiffness increases with muscle torque",
        "it increases with ankle torque @sakanaka",
        "random error and rise time",
        "In forward simulations, the reference parameters predict the measured angle better",
        "predict the torque better. With the latter",
    ],
    "rigs_further": ["[lower bound]"],
    "wristalyzer_further": [
        "Within the fitted band, the lowest coherence is #num",
        "(the lowest VAF of a full dataset in Table 4-1)",
        "percentage points lower than its VAF in its own trial#if",
        "if this mean is more than #short(lost.reported) percentage points lower",
        "percentage points lower, compared with up to",
        "The lowest coherence at scale factor #best is closest",
        "neighbouring frequencies decreases with noise",
        "whole periods decreases with noise",
        "a torque that increases with the cube",
    ],
    "dummy": ["At smaller amplitudes the largest errors are #largest-error"],
    "dummy_further": [
        "The thesis states that a higher velocity lowers the standard deviation",
        "we compare the highest with the lowest velocity",
        "The standard deviation at the highest velocity is",
        "from one velocity to the next higher one",
        "%; the lowest is #fixed",
        "the lowest VAF is #fixed",
    ],
    "noise_further": [
        "The thesis states that onsets are easier to detect at higher",
        "[lowest SNR",
    ],
    "methods": ["whichever has the smaller error"],
    "weight": [
        "Where masses and shapes agree with the thesis, they do so by construction",
        "whose bias may exceed a tenth",
    ],
    "weight_further": ["whichever has the smaller error"],
    "standing_further": ["spreads activity over more than 60 ms"],
    "recovery": ["count as little more than one draw"],
    "thesis_dummy": [
        "The stiffness of the joint falls and its damping rises as it is bent",
        "cannot reproduce the fall of the printed",
        "$E$ increases by $l$ times",
        "A lag of the centre of mass has a smaller effect",
        "and the fall of $K$ with amplitude. They also show that $B$ rises",
        "while $K$ falls on the treadmill",
    ],
    "findings": ["#owner(rows.last().parameter_set) worst"],
    "planning": [
        "a better filter",
        "Where tolerances exceed the noise, better scales",
        "lower bound of Type A",
        "may not exceed their peaks",
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


# numbers with a unit that are typed: settings, definitions, thresholds, literature, and numbers of the thesis
TYPED = re.compile(r"(?<![\w.,±@-])±?\d[\d.]*[ \u00a0](?=%|N·|N\b|kg|ms\b|s\b|Hz|m/s|m?rad|dB)")
TYPED_BY_PLACE = {
    "budgets": ["others are below 100 % for this reason"],
    "dummy": ["of all combinations are within 5 % of it", "mean VAF above 99 %", "deviate by more than 5 %"],
    "dummy_further": [
        "amplitude in 0.1 m/s",
        "marks perturbations every 8 s",
        "within 5 % of the recommended",
    ],
    "findings": ["K is within 5 % of the recommended", "Power below 1 Hz makes up"],
    "introduction": ["The errors were below 3 % for stiffness", "about 13 to 16 % for inertia"],
    "planning": [
        "14 perturbations of 100 ms",
        "one every 4 s",
        "a filter of 20 Hz",
        "the sine at 0.3 m/s",
        "the belt within 100 ms",
        "by less than 0.5 % (@filters-table)",
        "Filter of 20 Hz",
        "sine at 0.3 m/s, no noise",
        "_n for ±10 %_",
        "bias included, is within ±10 %",
    ],
    "reproduction": ["0.1 to 0.3 m/s", "at 0.5 m/s, relative to 0.1 m/s"],
    "rigs": ["the peak velocity in 0.1 m/s", "it is 0.5 m/s", "with a pulse every 8 s"],
    "standing": [
        "within 0.3 s of the onset",
        "up to 20 ms shorter",
        "up to 200 ms",
        "from 40 ms after",
    ],
    "standing_further": ["The 6 Hz envelope of the thesis", "more than 60 ms in both directions"],
    "title": ["peak velocity in 0.1 m/s", "a pulse every 8 s"],
    "weight_further": ["The thesis reports", "from 0.1 to 0.5 m/s, mean of both", "It reaches 71 % of this"],
    "wristalyzer": ["printed $K$ changes by less than 1 %"],
    "wristalyzer_further": [
        "“transition line” above 9 Hz",
        "from 9 to 20 Hz is",
        "the misfit below 9 Hz",
        "a VAF of at least 87 %",
    ],
}


def typed(source):
    """Numbers with a unit that a source types in its prose (but 95 %), with the text around each."""
    text = (REPORT / source).read_text(encoding="utf-8")
    bare = re.sub(r"(?m)//.*$", blank, text)
    for code in (r"\$[^$]*\$", r'"[^"\n]*"|“[^”]*”|`[^`\n]*`', r"#?let .*", r"[\w.-]+\([^()]*\)"):
        bare = re.sub(code, blank, bare)
    for found in TYPED.finditer(bare):
        if found[0].strip() != "95":
            around = text[max(0, found.start() - 160) : found.end() + 60]
            yield f"{source}:{text.count(chr(10), 0, found.start()) + 1}", " ".join(around.split())


@pytest.mark.parametrize("name", SOURCES)
def test_no_digit_of_a_result_is_typed(name):
    excepted = TYPED_BY_PLACE.get(name, ())
    assert [one for one in typed(SOURCES[name]) if not any(words in one[1] for words in excepted)] == []


@pytest.mark.parametrize("name", TYPED_BY_PLACE)
def test_no_place_of_a_typed_number_is_left_over(name):
    around = " ".join(words for _, words in typed(SOURCES[name]))
    assert [words for words in TYPED_BY_PLACE[name] if words not in around] == []


def test_typed_numbers_are_found_in_prose_alone():
    text = 'K is 9.5 N·m/rad, #num(9.5) N·m/rad, "8 %", 2pt and 95 %.'
    assert [found[0] for found in TYPED.finditer(text)] == ["9.5 ", "8 ", "95 "]
