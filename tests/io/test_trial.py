"""The file of a trial: what does not belong together, or is no trial, is refused by name."""

import h5py
import numpy as np
import pytest
from builders import assert_one_sentence, trial_of
from misuse_table import FILES

from tepsipe.cli import main
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


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    """A trial of the study that can be read."""
    path = tmp_path_factory.mktemp("trials") / "good.h5"
    rng = np.random.default_rng(1)
    trial = trial_of(250.0, angle=(rng.normal(size=500), "rad"), torque=(rng.normal(size=500), "Nm"))
    write_trial(path, trial, "dummy", "sine", {}, {})
    assert read_trial(path).values("angle").size == 500
    return path


@pytest.mark.parametrize(("change", "words"), FILES, ids=range(len(FILES)))
def test_spoiled_trial_is_refused_when_it_is_read(trial_file, tmp_path, change, words, capsys):
    path = tmp_path / "trial.h5"
    path.write_bytes(trial_file.read_bytes())
    with h5py.File(path, "a") as file:
        change(file)
    assert main(["info", str(path)]) == 2  # reads it by read_trial
    assert_one_sentence(capsys.readouterr().err.strip(), words, path)
