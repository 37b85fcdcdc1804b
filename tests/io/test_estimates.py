"""Estimates survive their file, and a damaged file is refused."""

import numpy as np
import pandas as pd
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.estimates import DIVERGED_VAF, ESTIMATES, Estimate


def estimate(quantity, value, **more):
    about = {"experiment": "dummy", "condition": "sine-0.3", "pathway": "leg", "estimator": "fit"} | more
    return Estimate(quantity=quantity, unit="%", value=value, **about)


def test_estimates_come_back_from_their_file(tmp_path, rng):
    value, error = rng.standard_normal(2)
    written = [
        estimate("K", value, standard_error=error, ci_low=-np.inf, ci_high=12.5, n_perturbations=14),
        estimate("VAF_trial", 99.12345679),
        estimate("I", 1e-17, sem_as_printed=3.0e12),
    ]
    ESTIMATES.write(tmp_path / "estimates.csv", written)
    read = ESTIMATES.read(tmp_path / "estimates.csv")
    assert len(read) == 3
    assert read[0].value == pytest.approx(value, rel=1e-9)
    assert read[0].standard_error == pytest.approx(error, rel=1e-9)
    assert (read[0].ci_low, read[0].ci_high, read[0].n_perturbations) == (-np.inf, 12.5, 14)
    assert read[1] == written[1]
    assert read[2] == written[2]
    ESTIMATES.write(tmp_path / "again.csv", read)
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "estimates.csv").read_bytes()


def test_estimate_that_is_no_number_is_an_empty_cell_with_a_flag(tmp_path):
    path = tmp_path / "estimates.csv"
    written = [
        estimate("K", np.nan, standard_error=np.nan),
        estimate("B", 0.1, ci_low=np.nan, ci_high=np.inf, flags="at-bound"),
        estimate("VAF_trial", -3e59),
        estimate("VAF_trial", 0.5 * DIVERGED_VAF),
        estimate("I", -np.inf, flags="undefined"),
    ]
    ESTIMATES.write(path, written)
    assert "nan" not in path.read_text()
    read = ESTIMATES.read(path)
    flags = ["undefined;no-interval", "at-bound;no-interval", "diverged", "", "undefined"]
    assert [row.flags for row in read] == flags
    assert [np.isnan(row.value) for row in read] == [True, False, False, False, True]
    assert read[1].ci_low is None
    assert read[1].ci_high == np.inf
    frame = pd.read_csv(path)
    assert frame.value.dtype == float
    assert frame.value.isna().tolist() == [True, False, False, False, True]
    ESTIMATES.write(tmp_path / "again.csv", read)
    assert (tmp_path / "again.csv").read_bytes() == path.read_bytes()
    text = path.read_text()
    for old, new in (("undefined;no-interval", ""), ("diverged", "divergd")):
        path.write_text(text.replace(old, new))
        with pytest.raises(InputError) as caught:
            ESTIMATES.read(path)
        assert_one_sentence(caught.value, path, "damaged row")


def test_condition_that_looks_like_a_number_stays_text(tmp_path):
    ESTIMATES.write(tmp_path / "estimates.csv", [estimate("K", 10.0, condition="0.20")])
    assert ESTIMATES.read(tmp_path / "estimates.csv")[0].condition == "0.20"


@pytest.mark.parametrize("content", ["", "experiment,condition\n", "value;unit\n1;2\n"])
def test_file_without_the_columns_of_estimates_is_refused(content, tmp_path):
    path = tmp_path / "estimates.csv"
    path.write_text(content)
    with pytest.raises(InputError) as caught:
        ESTIMATES.read(path)
    assert_one_sentence(caught.value, path)


def test_table_that_ends_within_a_row_is_refused(tmp_path):
    path = tmp_path / "estimates.csv"
    ESTIMATES.write(path, [estimate("K", 10.5, n_perturbations=14), estimate("B", 0.5, n_perturbations=14)])
    content = path.read_bytes()
    for missing in range(1, len(content.splitlines()[-1]) + 1):
        path.write_bytes(content[:-missing])
        with pytest.raises(InputError) as caught:
            ESTIMATES.read(path)
        assert_one_sentence(caught.value, path)


def test_missing_table_is_refused(tmp_path):
    with pytest.raises(InputError) as caught:
        ESTIMATES.read(tmp_path / "estimates.csv")
    assert_one_sentence(caught.value, tmp_path / "estimates.csv")
