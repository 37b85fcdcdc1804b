"""The EDF reader gives electromyograms in uV, and says in one sentence why it cannot."""

import numpy as np
import pytest
from builders import assert_one_sentence
from edfio import Edf, EdfSignal

from tepsipe.errors import InputError
from tepsipe.io.readers.edf import read_emg

SECONDS, RATE_HZ = 6, 1000
LIMIT_UV = 3276.8
CHANNELS = {"TA": "EMG TA", "SOL": "EMG SOL", "GAS": "EMG GAS"}


def channel(data, label, unit="uV", limit=LIMIT_UV, rate_hz=RATE_HZ):
    return EdfSignal(data, rate_hz, label=label, physical_dimension=unit, physical_range=(-limit, limit))


def write(path, signals, plus=True):
    Edf(signals, data_record_duration=1.0, annotations=() if plus else None).write(path)
    return path


@pytest.fixture
def muscles(rng):
    """Electromyograms (uV), shape (n, 3), and a trigger (V)."""
    trigger = np.zeros(SECONDS * RATE_HZ)
    trigger[1500:4500] = 5.0
    return 100.0 * rng.standard_normal((trigger.size, 3)), trigger


@pytest.fixture
def good(muscles, tmp_path):
    signals, trigger = muscles
    columns = [channel(x, label) for x, label in zip(signals.T, CHANNELS.values(), strict=True)]
    return write(tmp_path / "emg.edf", [*columns, channel(trigger, "Trigger", "V", 5.0)])


@pytest.fixture
def refused():
    """Refuse a file; return what was said."""

    def refuse(path, channels=CHANNELS, trigger="Trigger"):
        with pytest.raises(InputError) as caught:
            read_emg(path, channels, trigger)
        assert_one_sentence(caught.value, path)
        return str(caught.value)

    return refuse


@pytest.fixture
def changed(good):
    """Change the bytes of the good file."""

    def change(how):
        good.write_bytes(how(good.read_bytes()))
        return good

    return change


def test_recording_comes_back_as_it_was_written(good, muscles):
    signals, trigger = muscles
    read = read_emg(good, CHANNELS, "Trigger")
    assert read.rate_hz == RATE_HZ
    assert read.muscles == ("TA", "SOL", "GAS")
    assert read.missing == ()
    assert read.signals == pytest.approx(signals, abs=0.06)
    assert read.trigger == pytest.approx(trigger, abs=1e-3)
    assert read.limits == pytest.approx(np.array([[-LIMIT_UV, LIMIT_UV]] * 3))


def test_muscles_come_in_the_wanted_order_whatever_the_order_of_the_file(good, muscles):
    read = read_emg(good, {"b": "EMG GAS", "a": "EMG TA"}, "Trigger")
    assert read.muscles == ("b", "a")
    assert read.signals == pytest.approx(muscles[0][:, [2, 0]], abs=0.06)


def test_muscle_without_a_channel_is_named_and_stops_nothing(good, muscles):
    wanted = {"RF": "EMG RF", **CHANNELS, "BF": "EMG BF"}
    read = read_emg(good, wanted, "Trigger")
    assert read.missing == ("RF", "BF")
    assert read.muscles == tuple(CHANNELS)
    assert read.signals.shape == muscles[0].shape


def test_plain_edf_is_read_like_edf_plus(muscles, tmp_path):
    signals, trigger = muscles
    path = write(
        tmp_path / "plain.edf", [channel(signals[:, 0], "a"), channel(trigger, "t", "V", 5.0)], False
    )
    assert read_emg(path, {"TA": "a"}, "t").signals[:, 0] == pytest.approx(signals[:, 0], abs=0.06)


@pytest.mark.parametrize(
    ("spelling", "per_uv"),
    [
        (b"uV", 1.0),
        (b"\xb5V", 1.0),
        ("\u00b5V".encode(), 1.0),
        ("\u03bcV".encode(), 1.0),
        (b"UV", 1.0),
        (b"mV", 1e-3),
        (b"V", 1e-6),
        (b"nV", 1e3),
    ],
)
def test_every_unit_gives_the_same_electromyogram(spelling, per_uv, muscles, tmp_path):
    signals, trigger = muscles
    limit = float(f"{LIMIT_UV * per_uv:.4g}")
    path = write(
        tmp_path / "unit.edf",
        [channel(per_uv * signals[:, 0], "a", "unit", limit), channel(trigger, "t", "V", 5.0)],
    )
    path.write_bytes(path.read_bytes().replace(b"unit    ", spelling.ljust(8), 1))
    read = read_emg(path, {"TA": "a"}, "t")
    assert read.signals[:, 0] == pytest.approx(signals[:, 0], abs=0.11)
    assert read.limits[0] == pytest.approx([-LIMIT_UV, LIMIT_UV], rel=1e-3)


@pytest.mark.parametrize(
    ("unit", "per_volt"), [("V", 1.0), ("mV", 1e3), ("uV", 1e6), ("Boolean", 1.0), ("", 1.0)]
)
def test_trigger_is_in_volts_if_it_is_a_voltage(unit, per_volt, muscles, tmp_path):
    signals, trigger = muscles
    lines = [channel(signals[:, 0], "a"), channel(per_volt * trigger, "t", unit, 5.0 * per_volt)]
    read = read_emg(write(tmp_path / "trigger.edf", lines), {"TA": "a"}, "t")
    assert read.trigger == pytest.approx(trigger, abs=1e-3)


def test_inverted_polarity_keeps_its_sign_and_its_limits_rise(muscles, tmp_path):
    signals, trigger = muscles
    path = write(tmp_path / "inverted.edf", [channel(signals[:, 0], "a"), channel(trigger, "t", "V", 5.0)])
    content = path.read_bytes()
    low, high = b"-3276.8 ", b"3276.8  "
    assert content.count(low) == 1
    path.write_bytes(content.replace(low, b"@" * 8).replace(high, low).replace(b"@" * 8, high))
    read = read_emg(path, {"TA": "a"}, "t")
    assert read.signals[:, 0] == pytest.approx(-signals[:, 0], abs=0.16)
    assert read.limits[0].tolist() == [-LIMIT_UV, LIMIT_UV]


# ---- what is refused ---------------------------------------------------------------------------


def test_missing_file_and_folder_are_refused(refused, tmp_path):
    assert "no file" in refused(tmp_path / "emg.edf")
    assert "no file" in refused(tmp_path)


@pytest.mark.parametrize(
    "content", [b"", bytes(5000), b"this is a letter, not a recording\n" * 100, b"0       " + bytes(5000)]
)
def test_something_else_than_edf_is_refused(content, refused, changed):
    refused(changed(lambda _: content))


def test_binary_rubbish_is_refused(refused, changed):
    refused(changed(lambda _: np.random.default_rng(5).integers(0, 256, 20000).astype(np.uint8).tobytes()))


@pytest.mark.parametrize("part", [0.001, 0.01, 0.02, 0.3, 0.9, 0.9999])
def test_truncated_file_is_refused_wherever_it_ends(part, refused, changed):
    refused(changed(lambda content: content[: int(part * len(content))]))


def test_file_of_fewer_records_than_promised_is_truncated(refused, changed):
    message = refused(changed(lambda content: content[: -(len(content) - 256 * 6) // SECONDS]))
    assert f"expected {SECONDS} records" in message
    assert "truncated" in message


def test_bytes_after_the_last_record_are_refused(refused, changed):
    assert "damaged" in refused(changed(lambda content: content + bytes(2 * 4 * RATE_HZ)))


def test_recording_that_was_not_closed_is_refused(refused, changed):
    assert "did not close" in refused(changed(lambda content: content[:236] + b"-1      " + content[244:]))


def test_header_that_is_no_number_is_refused(refused, changed):
    refused(changed(lambda content: content[:244] + b"a second" + content[252:]))


def test_missing_trigger_is_named_beside_the_channels_that_are_there(refused, good):
    message = refused(good, trigger="TRIG")
    assert "'TRIG'" in message
    assert "'EMG TA'" in message


def test_file_without_any_wanted_channel_is_refused(refused, good):
    message = refused(good, channels={"BF": "EMG BF", "RF": "EMG RF"})
    assert "'EMG BF', 'EMG RF'" in message
    assert "'EMG TA'" in message


def test_label_that_stands_twice_is_refused(refused, muscles, tmp_path):
    signals, trigger = muscles
    twice = [channel(signals[:, 0], "EMG TA"), channel(signals[:, 1], "EMG TA")]
    path = write(tmp_path / "twice.edf", [*twice, channel(trigger, "Trigger", "V", 5.0)])
    assert "found 2" in refused(path)


def test_channels_of_different_rates_are_refused(refused, muscles, tmp_path):
    signals, trigger = muscles
    slow = channel(trigger[::4], "Trigger", "V", 5.0, RATE_HZ // 4)
    message = refused(write(tmp_path / "rates.edf", [channel(signals[:, 0], "EMG TA"), slow]))
    assert "'EMG TA' at 1000 Hz" in message
    assert "'Trigger' at 250 Hz" in message


def test_rate_of_a_channel_that_is_not_wanted_does_not_matter(muscles, tmp_path):
    signals, trigger = muscles
    slow = channel(trigger[::4], "Pedal", "V", 5.0, RATE_HZ // 4)
    lines = [slow, channel(signals[:, 0], "EMG TA"), channel(trigger, "Trigger", "V", 5.0)]
    read = read_emg(write(tmp_path / "rates.edf", lines), CHANNELS, "Trigger")
    assert read.muscles == ("TA",)


@pytest.mark.parametrize("unit", ["", "degC", "MV", "% MVC"])
def test_unknown_unit_is_refused(unit, refused, muscles, tmp_path):
    signals, trigger = muscles
    lines = [channel(signals[:, 0], "EMG TA", unit), channel(trigger, "Trigger", "V", 5.0)]
    message = refused(write(tmp_path / "unit.edf", lines))
    assert repr(unit) in message
    assert "'EMG TA'" in message


def test_channel_without_a_physical_range_is_refused(refused, changed):
    assert "range" in refused(changed(lambda content: content.replace(b"-3276.8 ", b"3276.8  ", 1)))


def test_gap_between_records_is_refused_and_edf_d_without_one_is_not(good, refused, changed):
    changed(lambda content: content.replace(b"EDF+C", b"EDF+D"))
    assert read_emg(good, CHANNELS, "Trigger").signals.shape[0] == SECONDS * RATE_HZ
    assert "gaps" in refused(changed(lambda content: content.replace(b"+5\x14\x14", b"+8\x14\x14")))


def test_damaged_time_keeping_is_refused(refused, changed):
    assert "damaged" in refused(changed(lambda content: content.replace(b"+5\x14\x14", b"\xff\xfe\xfd\xfc")))
