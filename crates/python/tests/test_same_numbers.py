"""However a log comes, its calibration has the numbers of the command, to the last bit."""

import csv as text
import json

import numpy as np
import pandas
import polars
import pytest

from conftest import by_parameters

import zerorate


def numbers(calibration):
    """All of a calibration but where it came from."""
    return {key: value for key, value in calibration.items() if key != "sources"}


def rows(calibration):
    return calibration["sources"][0]["rows"]


@pytest.fixture(scope="module")
def commanded(command, csv, tmp_path_factory):
    out = tmp_path_factory.mktemp("commanded") / "calibration.json"
    command("fit", csv, "--time-unit", "s", "--out", out)
    return by_parameters(out.read_text())


def held(calibration, commanded):
    commanded = json.loads(commanded)
    assert numbers(calibration.to_dict()) == numbers(commanded)
    assert rows(calibration.to_dict()) == rows(commanded)


def test_a_file_gives_the_commands_own_text(csv, commanded):
    assert zerorate.fit(csv, time_unit="s").to_json() == commanded
    assert zerorate.fit(str(csv), time_unit="s").to_json() == commanded


def test_bytes(csv, commanded):
    held(zerorate.fit(csv.read_bytes(), time_unit="s"), commanded)


def test_arrays_of_numpy(ramp, commanded):
    time, temperature, rates = ramp
    held(zerorate.fit(time=time, temperature=temperature, rates=rates), commanded)


def test_a_dict_of_arrays(columns, commanded):
    held(zerorate.fit(columns, time_unit="s"), commanded)


def test_polars(columns, commanded):
    held(zerorate.fit(polars.DataFrame(columns), time_unit="s"), commanded)


def test_a_frame_of_polars_in_pieces(columns, commanded):
    frame = polars.DataFrame(columns)
    pieces = polars.concat([frame[:100], frame[100:5000], frame[5000:]], rechunk=False)
    held(zerorate.fit(pieces, time_unit="s"), commanded)


def test_pandas(columns, commanded):
    held(zerorate.fit(pandas.DataFrame(columns), time_unit="s"), commanded)


def test_a_frame_of_pandas_whose_index_is_the_time(columns, commanded):
    held(zerorate.fit(pandas.DataFrame(columns).set_index("time"), time_unit="s"), commanded)


def test_a_frame_with_a_column_of_words(columns, commanded):
    words = ["chamber"] * len(columns["time"])
    held(zerorate.fit(polars.DataFrame(columns | {"where": words}), time_unit="s"), commanded)
    held(zerorate.fit(pandas.DataFrame(columns | {"where": words}), time_unit="s"), commanded)


def test_columns_and_units_that_are_named(command, columns, csv, tmp_path):
    out = tmp_path / "named.json"
    options = ["--temperature", "temperature", "--rate", "gyro_z,gyro_x", "--rate-unit", "mdps"]
    command("fit", csv, "--model", "poly:3", "--temperature-unit", "fahrenheit", *options, "--out", out)
    keywords = {"temperature": "temperature", "rates": ["gyro_z", "gyro_x"], "rate_unit": "mdps"}
    keywords |= {"temperature_unit": "fahrenheit", "model": "poly:3"}
    held(zerorate.fit(polars.DataFrame(columns), **keywords), by_parameters(out.read_text()))


# Nanoseconds since 1970 are more than a double holds: a table has them to 256 ns.
@pytest.mark.parametrize("unit", ["s", "ms", "us"])
def test_datetime64_is_the_same_time(ramp, commanded, unit):
    time, temperature, rates = ramp
    # Half seconds are no whole number of seconds.
    scale = {"s": 1, "ms": 1000, "us": 1_000_000}[unit]
    if unit == "s":
        time, temperature, rates = time[::2], temperature[::2], rates[::2]
    stamps = (time * scale).astype(np.int64).view(f"datetime64[{unit}]") + np.timedelta64(1_700_000_000 * scale, unit)
    of_stamps = zerorate.fit(time=stamps, temperature=temperature, rates=rates).to_dict()
    of_seconds = zerorate.fit(time=time, temperature=temperature, rates=rates).to_dict()
    assert numbers(of_stamps) == numbers(of_seconds)


@pytest.mark.parametrize("kind", ["timedelta64[us]", "timedelta64[10us]", "datetime64[10us]", "zone", "lasted"])
def test_other_times_are_times_too(ramp, kind):
    time, temperature, rates = ramp
    micros = (time * 1_000_000).astype(np.int64)
    if kind in ("zone", "lasted"):
        index = pandas.to_timedelta(micros, unit="us")
        if kind == "zone":
            index = (index + pandas.Timestamp("2026-01-01")).tz_localize("Europe/Berlin")
        frame = {"temperature": temperature} | {f"gyro_{axis}": rates[:, k] for k, axis in enumerate("xyz")}
        made = zerorate.fit(pandas.DataFrame(frame, index=index.rename("time")))
    else:
        several = 10 if "10" in kind else 1
        made = zerorate.fit(time=(micros // several).view(kind), temperature=temperature, rates=rates)
    of_seconds = zerorate.fit(time=time, temperature=temperature, rates=rates)
    at = np.array([0.0, 20.0, 40.0])
    assert made.to_dict()["axes"]["gyro_x"]["model"] == of_seconds.to_dict()["axes"]["gyro_x"]["model"]
    assert np.allclose(made.curve("gyro_x", at), of_seconds.curve("gyro_x", at), rtol=1e-6, atol=0.0)


@pytest.mark.parametrize("kind", [polars.Categorical, polars.Enum(["lab"]), polars.Null], ids=str)
def test_a_column_of_another_kind_is_left_alone(columns, commanded, kind):
    count = len(columns["time"])
    values = [None if kind == polars.Null else "lab"] * count
    held(zerorate.fit(polars.DataFrame(columns | {"where": polars.Series(values, dtype=kind)}), time_unit="s"), commanded)


def test_what_is_masked_is_missing(columns):
    hot = columns["temperature"] > 40.0
    masked = columns | {"temperature": np.ma.masked_where(hot, columns["temperature"])}
    missing = columns | {"temperature": np.where(hot, np.nan, columns["temperature"])}
    assert numbers(zerorate.fit(masked).to_dict()) == numbers(zerorate.fit(missing).to_dict())


def test_the_chamber_cycle(command, chamber_cycle, tmp_path):
    out = tmp_path / "chamber.json"
    command("fit", chamber_cycle, "--rate-unit", "rad/s", "--out", out)
    assert zerorate.fit(chamber_cycle, rate_unit="rad/s").to_json() == by_parameters(out.read_text())
    with open(chamber_cycle, newline="") as file:
        head, *lines = text.reader(file, delimiter="\t")
    cells = {name: [line[place] for line in lines] for place, name in enumerate(head)}
    columns = {name: np.array(column, dtype=float) for name, column in cells.items()}
    held(zerorate.fit(columns, rate_unit="rad/s"), by_parameters(out.read_text()))
    held(zerorate.fit(polars.DataFrame(columns), rate_unit="rad/s"), by_parameters(out.read_text()))
    held(zerorate.fit(pandas.DataFrame(columns), rate_unit="rad/s"), by_parameters(out.read_text()))
