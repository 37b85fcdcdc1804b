"""The file of a trial: what does not belong together, or is no trial, is refused by name."""

import h5py
import numpy as np
import pytest
from builders import assert_one_sentence, trial_of

from tepsipe.errors import InputError
from tepsipe.io.trial import Signal, Trial, read_sources, read_trial, write_trial


def test_signal_that_a_trial_does_not_have_is_refused_by_name():
    trial = trial_of(100.0, angle=(np.zeros(5), "rad"))
    with pytest.raises(InputError) as caught:
        trial.values("torque")
    assert_one_sentence(caught.value, "'torque'", "angle")


def test_missing_or_foreign_trial_file_is_refused(tmp_path):
    with pytest.raises(InputError) as caught:
        read_trial(tmp_path / "none.h5")
    assert_one_sentence(caught.value, tmp_path / "none.h5")
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = np.zeros(3)
    for read in (read_trial, read_sources):
        with pytest.raises(InputError) as caught:
            read(tmp_path / "foreign.h5")
        assert_one_sentence(caught.value, tmp_path / "foreign.h5")


def test_trial_whose_samples_do_not_fit_its_axes_is_not_read(tmp_path):
    axes = {"time": np.arange(100) / 100.0}
    trial = Trial(100.0, axes, {"angle": Signal(np.zeros(99), "rad", ("time",), "angle")})
    write_trial(tmp_path / "trial.h5", trial, "dummy", "x", {}, {})
    with pytest.raises(InputError) as caught:
        read_trial(tmp_path / "trial.h5")
    assert_one_sentence(caught.value, "trial.h5", "'angle' has the shape (99,)")
