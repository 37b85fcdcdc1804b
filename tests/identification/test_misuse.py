"""Misuse of the public functions is answered in one sentence: a refusal, or a note beside right numbers."""

import inspect

import numpy as np
import pytest
from builders import assert_one_sentence
from misuse import copied, good
from misuse_table import FILES, NOTED, REFUSED, SAME

import tepsipe
from tepsipe import InputError


def spoiled(name, changes):
    """Arguments of a good call with some of them changed."""
    call = {} if "path" in changes else good(name)
    original = dict(call)
    for key, change in changes.items():
        if not inspect.isfunction(change):
            call[key] = change
        elif len(inspect.signature(change).parameters) == 1:
            call[key] = change(original.get(key))
        else:  # it needs another argument
            call[key] = change(original.get(key), call if change is copied else original)
    return call


def called(name, changes):
    """Result of a spoiled call."""
    return getattr(tepsipe, name)(**spoiled(name, changes))


def named(rows):
    """Names of the rows for pytest."""
    return [f"{row[0]}-{'-'.join(row[1])}-{number}" for number, row in enumerate(rows)]


def test_the_table_has_its_rows():
    assert len(REFUSED) + len(NOTED) + len(FILES) >= 120
    used = {row[0] for row in REFUSED}
    assert used >= set(tepsipe.__all__) - {"InputError", "Trial", "ImpedanceFit", "load_example"}


@pytest.mark.parametrize(("name", "changes", "words"), REFUSED, ids=named(REFUSED))
def test_misuse_is_refused_in_one_sentence(name, changes, words):
    with pytest.raises(InputError) as caught:
        called(name, changes)
    assert_one_sentence(caught.value, words)


@pytest.mark.parametrize(("name", "changes", "words"), NOTED, ids=named(NOTED))
def test_probable_misuse_has_a_note(name, changes, words):
    fit = called(name, changes)
    assert any(words in note for note in fit.notes), fit.notes
    assert all(f"Note: {note}" in fit.summary() for note in fit.notes)
    assert np.isfinite(fit.parameters).all()


@pytest.mark.parametrize(("name", "changes"), SAME, ids=named(SAME))
def test_harmless_variety_changes_nothing(name, changes):
    fit, plain = called(name, changes), called(name, {})
    assert fit.parameters == pytest.approx(plain.parameters, rel=1e-3)
    assert not plain.notes
    assert all("converted" in note for note in fit.notes)
