"""BDF files (24 bits) give the same electromyograms as EDF, and their Status channel is a trigger."""

import gzip

import numpy as np
import pytest
from builders import assert_one_sentence
from edfio import Bdf, BdfSignal, Edf, EdfSignal

from tepsipe.errors import InputError
from tepsipe.io.formats import contents_of
from tepsipe.io.readers.edf import read_emg

RATE_HZ, SECONDS, LIMIT_UV = 1000, 4, 3276.8
CHANNELS = {"TA": "EMG TA", "SOL": "EMG SOL"}


@pytest.fixture
def muscles(rng):
    return 100.0 * rng.standard_normal((SECONDS * RATE_HZ, 2))


@pytest.fixture
def trigger():
    line = np.zeros(SECONDS * RATE_HZ)
    line[500:3500] = 5.0
    return line


def write(kind, signal, path, muscles, last):
    columns = [
        signal(x, RATE_HZ, label=label, physical_dimension="uV", physical_range=(-LIMIT_UV, LIMIT_UV))
        for x, label in zip(muscles.T, CHANNELS.values(), strict=True)
    ]
    kind([*columns, last], data_record_duration=1.0).write(path)
    return path


def line_of(signal, trigger):
    return signal(trigger, RATE_HZ, label="Trigger", physical_dimension="V", physical_range=(-5.0, 5.0))


@pytest.fixture
def bdf(tmp_path, muscles, trigger):
    return write(Bdf, BdfSignal, tmp_path / "emg.bdf", muscles, line_of(BdfSignal, trigger))


def test_bdf_equals_edf_within_their_resolution(bdf, tmp_path, muscles, trigger):
    edf = write(Edf, EdfSignal, tmp_path / "emg.edf", muscles, line_of(EdfSignal, trigger))
    coarse, fine = (read_emg(path, CHANNELS, "Trigger") for path in (edf, bdf))
    assert (coarse.rate_hz, coarse.muscles) == (fine.rate_hz, fine.muscles)
    assert fine.signals == pytest.approx(muscles, abs=LIMIT_UV / 2**23)
    assert fine.signals == pytest.approx(coarse.signals, abs=LIMIT_UV / 2**15)
    assert fine.trigger == pytest.approx(coarse.trigger, abs=1e-3)
    assert np.array_equal(fine.limits, coarse.limits)
    started = read_emg(bdf, CHANNELS, None)
    assert started.trigger is None
    assert np.array_equal(started.signals, fine.signals)


def test_status_channel_gives_the_number_of_its_trigger_lines(tmp_path, muscles, trigger):
    digital = (np.where(trigger > 1.0, 4, 0) | 0x1F0000) - 0x400000  # the state of the amplifier above
    status = BdfSignal.from_digital(
        digital.astype(np.int32), RATE_HZ, label="Status", physical_range=(-8388608, 8388607)
    )
    path = write(Bdf, BdfSignal, tmp_path / "emg.bdf", muscles, status)
    found = read_emg(path, CHANNELS, "Status")
    assert np.array_equal(found.trigger, np.where(trigger > 1.0, 4.0, 0.0))


def test_kind_is_known_by_content_and_compression_is_undone(bdf, tmp_path):
    renamed, packed = tmp_path / "emg.edf", tmp_path / "emg.bdf.gz"
    renamed.write_bytes(bdf.read_bytes())
    packed.write_bytes(gzip.compress(bdf.read_bytes()))
    expected = read_emg(bdf, CHANNELS, "Trigger").signals
    for path in (renamed, packed):
        assert np.array_equal(read_emg(path, CHANNELS, "Trigger").signals, expected)
        shown = contents_of(path)
        assert shown.kind == "BDF"
        assert [c.name for c in shown.channels] == [*CHANNELS.values(), "Trigger"]


@pytest.mark.parametrize("packed", [False, True])
def test_truncated_bdf_is_refused(bdf, packed):
    content = bdf.read_bytes()[:-1000]
    bdf.write_bytes(gzip.compress(content) if packed else content)
    with pytest.raises(InputError, match="truncated") as caught:
        read_emg(bdf, CHANNELS, "Trigger")
    assert_one_sentence(caught.value, bdf)
