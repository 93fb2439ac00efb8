"""What a calibration gives."""

import json

import numpy as np
import pytest

import zerorate


@pytest.fixture(scope="module")
def calibration(columns):
    return zerorate.fit(columns, serial="G-7", labels={"operator": "A. N."})


@pytest.fixture(scope="module")
def cubic(columns):
    return zerorate.fit(columns, model="poly:3", plain=True)


def test_a_cubic_predicts_what_numpys_does(cubic, columns):
    temperature = np.linspace(0.0, 50.0, 101)
    for axis in cubic.axes:
        expected = np.polyval(np.polyfit(columns["temperature"], columns[axis], 3), temperature)
        assert np.allclose(cubic.predict(temperature)[axis], expected, rtol=1e-9, atol=0.0)
        assert np.array_equal(cubic.curve(axis, temperature), cubic.predict(temperature)[axis])


def test_integers_and_lists_are_temperatures_too(cubic):
    assert np.array_equal(cubic.predict([10, 20])["gyro_x"], cubic.predict(np.array([10.0, 20.0]))["gyro_x"])
    assert np.isnan(cubic.predict([np.nan])["gyro_x"]).all()


def test_as_many_times_as_temperatures_are_asked_for(cubic):
    with pytest.raises(zerorate.Error, match="2 times for 1 temperatures"):
        cubic.predict([20.0], time=[0.0, 1.0])


def test_dates_are_times_of_a_prediction_too(calibration, columns):
    time, temperature = columns["time"][:400], columns["temperature"][:400]
    of_seconds = calibration.predict(temperature, time=time)["gyro_x"]
    lasted = (time * 1_000_000).astype(np.int64).view("timedelta64[us]")
    for times in (lasted, lasted + np.datetime64("2026-01-01")):
        assert np.allclose(calibration.predict(temperature, time=times)["gyro_x"], of_seconds, rtol=1e-9, atol=1e-15)


def test_what_is_masked_is_not_predicted(cubic):
    masked = np.ma.masked_array([20.0, 30.0], mask=[False, True])
    for of in (cubic.curve("gyro_x", masked), cubic.predict(masked)["gyro_x"]):
        assert np.isfinite(of[0]) and not np.isfinite(of[1])


@pytest.mark.parametrize("what, why", [(20.0, r"shape \(\): give one of shape \(n,\)"), (["warm"], "no numbers"),
                                       (np.zeros(2, "datetime64[s]"), "dates where numbers should be")])
def test_temperatures_that_are_none_are_refused(cubic, what, why):
    with pytest.raises(zerorate.Error, match=why):
        cubic.predict(what)


def test_it_is_the_same_once_written_and_read(calibration, tmp_path):
    path = tmp_path / "calibration.json"
    calibration.save(path)
    again = zerorate.Calibration.read(path)
    assert again.to_json() == calibration.to_json() == zerorate.Calibration.from_json(path.read_text()).to_json()
    assert calibration.to_dict() == json.loads(path.read_text())
    assert (again.axes, again.temperature_unit) == (["gyro_x", "gyro_y", "gyro_z"], "C")
    assert again.rate_units == dict.fromkeys(again.axes, "rad/s")
    assert calibration.to_dict()["unit_serial"] == "G-7"
    assert calibration.to_dict()["labels"] == {"operator": "A. N."}
    with pytest.raises(zerorate.Error, match="fit its log again"):
        again.report_html()


def test_it_is_exported_as_the_command_exports_it(calibration, command, tmp_path):
    path = tmp_path / "calibration.json"
    calibration.save(path)
    exported = command("export", path, "--format", "px4", "--device-id", "123").stdout
    assert calibration.export("px4", device_id=123) == exported
    with pytest.raises(zerorate.Error, match="`device_id`"):
        calibration.export("px4")
    with pytest.raises(zerorate.Error, match="'px5' is no format"):
        calibration.export("px5")


def test_the_report_is_one_page(calibration):
    page = calibration.report_html()
    assert page.startswith("<!DOCTYPE html>") and page.rstrip().endswith("</html>")
    assert "G-7" in page and "A. N." in page
    assert "mdps" in calibration.report_html(units="mdps") and "mdps" not in page


def test_the_averages_are_arrays(calibration):
    group = calibration.groups()["gyro_x"]
    assert {column.shape for column in group.values()} == {group["time_s"].shape}
    assert np.std(group["residual"]) < np.std(group["rate"])


def test_drawing_says_what_it_needs(calibration):
    try:
        import matplotlib
    except ImportError:
        with pytest.raises(zerorate.Error, match="pip install matplotlib"):
            calibration.plot()
    else:
        matplotlib.use("Agg")
        assert len(calibration.plot()) == 3
