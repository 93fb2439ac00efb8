"""Reading, verifying, noise."""

import json

import numpy as np
import pandas
import polars
import pytest

from conftest import by_parameters

import zerorate


def test_a_log_is_read_as_frames_that_can_be_fitted(csv, columns):
    log = zerorate.read_log(csv, time_unit="s")
    assert isinstance(log["gyro"], polars.DataFrame)
    assert log["gyro"].columns == ["time_s", "temperature_c", "gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"]
    assert np.array_equal(log["gyro"]["gyro_y_rad_s"].to_numpy(), columns["gyro_y"])
    assert isinstance(zerorate.read_log(csv, frames="pandas")["gyro"], pandas.DataFrame)
    arrays = zerorate.read_log(csv, frames="numpy")["gyro"]
    assert np.array_equal(arrays["time_s"], columns["time"])
    assert zerorate.fit(log["gyro"], model="poly:3").axes == log["gyro"].columns[2:]


@pytest.mark.parametrize("unit, per_dps", [("mdps", 1000.0), ("deg_h", 3600.0), ("rad_s", np.pi / 180.0)])
def test_a_frame_says_the_unit_that_its_rates_are_in(columns, unit, per_dps):
    """A log in another unit, read and fitted: the same drift in the same unit as fitted at once."""
    log = {"time_s": columns["time"], "temperature_c": columns["temperature"], f"x_{unit}": per_dps * columns["gyro_x"]}
    text = "\n".join([",".join(log), *(",".join(map(repr, row)) for row in zip(*(v.tolist() for v in log.values())))])
    [frame] = zerorate.read_log(text.encode(), frames="numpy").values()
    at_once, read = (zerorate.fit(of, model="poly:3") for of in (text.encode(), frame))
    assert list(at_once.rate_units.values()) == list(read.rate_units.values())
    at = np.array([0.0, 40.0])
    assert np.array_equal(*(fit.curve(fit.axes[0], at) for fit in (at_once, read)))


@pytest.fixture(scope="module")
def second(columns):
    random = np.random.default_rng(8)
    moved = {name: column + 1e-3 * random.standard_normal(len(column)) for name, column in columns.items() if "_" in name}
    return columns | moved


def test_a_second_run_is_verified_as_the_command_does(columns, second, command, tmp_path):
    calibration = zerorate.fit(columns)
    verified = zerorate.verify(second, calibration, max_rms="1mrad/s", in_sample=True)
    assert verified["passed"] is True and [axis["name"] for axis in verified["axes"]] == calibration.axes
    calibration.save(tmp_path / "calibration.json")
    path = tmp_path / "second.csv"
    rows = zip(*(column.tolist() for column in second.values()), strict=True)
    path.write_text("\n".join([",".join(second), *(",".join(map(repr, row)) for row in rows)]) + "\n")
    options = ["--with", tmp_path / "calibration.json", "--max-rms", "1mrad/s", "--in-sample", "--json"]
    commanded = json.loads(by_parameters(command("verify", path, *options).stdout))
    assert {key: commanded[key] for key in verified if key != "log"} == {
        key: value for key, value in verified.items() if key != "log"
    }


def test_the_log_that_was_fitted_is_no_test(columns):
    with pytest.raises(zerorate.Error, match="`in_sample`"):
        zerorate.verify(columns, zerorate.fit(columns))


def test_a_limit_is_missed(columns, second):
    verified = zerorate.verify(second, zerorate.fit(columns), max_rms="0.001mrad/s", in_sample=True)
    assert verified["passed"] is False and verified["verdict"] == "rejected"


def test_the_allan_deviation_of_white_noise_falls_with_the_root_of_time():
    noise = np.random.default_rng(9).standard_normal(20_000)
    allan = zerorate.allan_deviation(noise, 0.01)
    # Overlapping estimate at 4 samples (IEEE 952-1997, C.1), from means of neighbours.
    means = np.convolve(noise, np.full(4, 0.25), "valid")
    expected = np.sqrt(0.5 * np.mean((means[4:] - means[:-4]) ** 2))
    place = int(np.argmin(np.abs(allan["tau_s"] - 0.04)))
    assert allan["deviation"][place] == pytest.approx(expected, rel=1e-9)
    assert (allan["low"] < allan["deviation"]).all() and (allan["deviation"] < allan["high"]).all()
    assert allan["coefficients"]["angle_random_walk"]["value"] == pytest.approx(0.1, rel=0.1)
    with pytest.raises(zerorate.Error, match="record for longer"):
        zerorate.allan_deviation(noise[:5], 0.01)
