"""What cannot be done says why, and what to do."""

import numpy as np
import pytest

import zerorate


def test_a_file_that_is_not_there():
    with pytest.raises(FileNotFoundError):
        zerorate.fit("missing.csv")


def test_a_log_that_is_no_good_is_rejected_with_the_reasons(columns):
    with pytest.raises(zerorate.RejectedLog, match="`allow_narrow`") as rejected:
        zerorate.fit({name: column[:400] for name, column in columns.items()}, time_unit="s")
    assert any("record a wider range" in reason for reason in rejected.value.reasons)
    assert isinstance(rejected.value, zerorate.Error) and isinstance(rejected.value, ValueError)


def test_columns_that_are_unclear_are_asked_for_by_pythons_name(columns):
    renamed = {name.replace("gyro", "channel"): column for name, column in columns.items()}
    with pytest.raises(zerorate.Error, match="`rates`"):
        zerorate.fit(renamed)


def test_a_column_that_is_not_there(columns):
    with pytest.raises(zerorate.Error, match="no column 'warmth'; the columns are time, temperature"):
        zerorate.fit(columns, temperature="warmth")


def test_columns_of_different_lengths(ramp):
    time, temperature, rates = ramp
    with pytest.raises(zerorate.Error, match="one length"):
        zerorate.fit(time=time[1:], temperature=temperature, rates=rates)


def test_rates_of_a_shape_that_nobody_knows(ramp):
    time, temperature, _ = ramp
    with pytest.raises(zerorate.Error, match=r"\(n, 3\)"):
        zerorate.fit(time=time, temperature=temperature, rates=np.zeros((len(time), 4)))


def test_words_for_numbers(columns):
    with pytest.raises(zerorate.Error, match="column 'gyro_x': no numbers"):
        zerorate.fit(columns | {"gyro_x": ["fast"] * len(columns["time"])})


def test_a_damaged_file():
    with pytest.raises(zerorate.Error, match="bytes: the Parquet file cannot be read"):
        zerorate.fit(b"PAR1" + b"\xff" * 400)


@pytest.mark.parametrize("keyword", [{"model": "poly:9"}, {"rate_unit": "rpm"}, {"group_seconds": 1e6}, {"sensor": "eye"}])
def test_keywords_that_make_no_sense(columns, keyword):
    with pytest.raises(zerorate.Error):
        zerorate.fit(columns, **keyword)


def test_nothing_at_all():
    with pytest.raises(zerorate.Error, match="give a log"):
        zerorate.fit()
    with pytest.raises(zerorate.Error, match="this is a int"):
        zerorate.fit(7)
