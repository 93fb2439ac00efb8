#!/usr/bin/env python3
"""Recompute with numpy what `calibrate`, `fit` and `verify` print, from the recordings beside it.

usage: printed_numbers.py ZERORATE

Then holds docs/claims.md against what was printed: every number has its row, and every test that a row names is there.

Shares no code with the program: recordings are read by pyarrow, the paper's curve and its folds are fitted by
numpy.polyfit, a made log's residuals are taken from `apply`'s own columns. Names every number that differs, and by what.
"""

import csv
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyarrow.parquet

AXES = ("x", "y")
FOLDS = 8
# Of a row of the made log, deg/s.
NOISE = 0.02
# How near a chamber is held to its set point, K; the paper's set-up has so many counts in one.
HELD_TO_K, COUNTS_PER_CELSIUS = 0.5, 34.0


class Differences:
    """What was compared, and what differs."""

    def __init__(self):
        self.compared, self.found = 0, []

    def hold(self, what, printed, own, tolerance):
        """`tolerance` is relative; of what should be equal, 0."""
        self.compared += 1
        near = np.all(np.abs(np.subtract(printed, own, dtype=float)) <= tolerance * np.maximum(np.abs(own), 1e-12))
        if not near:
            self.found.append(f"{what}: printed {printed}, by numpy {own}")


def run(zerorate, *arguments):
    done = subprocess.run([zerorate, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"zerorate {' '.join(map(str, arguments))} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout


def recording(folder, name):
    """The groups of each axis, in order of time, columns by name."""
    table = pyarrow.parquet.read_table(folder / f"{name}.parquet").to_pydict()
    table = {column: np.array(values) for column, values in table.items()}
    return {axis: {column: values[table["axis"] == axis] for column, values in table.items()} for axis in AXES}


def of_phase(groups, phase):
    keep = groups["phase"] == phase
    return {column: values[keep] for column, values in groups.items()}


def held_out(temperature, reading, order):
    edges = np.linspace(0, len(reading), FOLDS + 1).astype(int)
    left = []
    for start, end in zip(edges, edges[1:]):
        others = np.r_[0:start, end : len(reading)]
        curve = np.polyfit(temperature[others], reading[others], order)
        left.append(reading[start:end] - np.polyval(curve, temperature[start:end]))
    return np.concatenate(left)


def rms_error(residuals):
    """The standard error of an rms by eight folds, each a block: as of a mean of their mean squares (ddof 1)."""
    edges = np.linspace(0, len(residuals), FOLDS + 1).astype(int)
    mean_squares = [np.nanmean(np.square(residuals[start:end])) for start, end in zip(edges, edges[1:])]
    return np.std(mean_squares, ddof=1) / np.sqrt(FOLDS) / (2 * np.sqrt(np.nanmean(np.square(residuals))))


def error_by_zero(left, averaged):
    """By the noise of the mean of some averages, which was taken off all others: as of the square of a mean."""
    zero, mean = np.mean(np.diff(left) ** 2) / 2 / averaged, np.mean(left)
    return np.sqrt(4 * max(mean**2 - zero, 0) * zero + 2 * zero**2) / (2 * rms(left))


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def find(value, name):
    """The first object of this name within another."""
    if name in value and isinstance(value[name], dict):
        return value[name]
    inner = (find(inner, name) for inner in value.values() if isinstance(inner, dict))
    return next((found for found in inner if found), None)


def ramp(differences, folder, printed):
    groups = recording(folder, "full-temperature")
    for axis in AXES:
        own, heating = printed["axes"][axis], of_phase(groups[axis], "heating")
        order = int(own["model"].removeprefix("poly:"))
        temperature, reading = (heating[f"{what}_sum"] / heating["n"] for what in ("temperature", "zro"))
        curve = np.polyfit(temperature, reading, order)
        left, out = reading - np.polyval(curve, temperature), held_out(temperature, reading, order)
        printed_curve = np.polyval(own["drift_raw_coefficients"][::-1], temperature)
        hold = lambda name, value, tolerance: differences.hold(f"summary.json {axis} {name}", own[name], value, tolerance)
        hold("drift_pp_counts", np.ptp(reading), 1e-9)
        hold("temperature_counts", [temperature.min(), temperature.max()], 1e-9)
        hold("heating_temperature_counts", [temperature.min(), temperature.max()], 1e-9)
        # The paper's ramp is from -40 to 60 C.
        hold("share_of_asked_range", np.ptp(temperature) / (100 * COUNTS_PER_CELSIUS), 1e-9)
        hold("fit_rms_counts", rms(left), 1e-6)
        hold("fit_pp_counts", np.ptp(left), 1e-6)
        hold("held_out_rms_counts", rms(out), 1e-6)
        hold("held_out_pp_counts", np.ptp(out), 1e-6)
        kept = json.loads((folder / "calibration.json").read_text())["axes"][axis]
        error = find(kept, "held_out")["rms_standard_error"]
        differences.hold(f"calibration.json {axis} held_out.rms_standard_error", error, rms_error(out), 1e-6)
        # To a millionth of the drift.
        differences.hold(f"summary.json {axis} curve", printed_curve, np.polyval(curve, temperature), 1e-7)


def compensation_tests(differences, folder, printed):
    drift = recording(folder, "full-temperature")
    for test in printed["tests"]:
        groups = recording(folder, f"compensation-test-{test['mode']}")
        axis, other = test["axis"], test["control"]
        # An axis's own ramp is the one in which it is compensated.
        keep = (groups[axis]["phase"] == test["direction"]) & (groups[axis]["compensation_mode"] == test["mode"])
        corrected, tap = groups[axis]["corrected_counts"][keep], groups[axis]["tap"][keep].astype(int)
        name = f"summary.json {axis} {test['mode']} {test['direction']}"
        hold = lambda field, value, tolerance: differences.hold(f"{name} {field}", test[field], value, tolerance)
        hold("residual_pp_counts", np.ptp(corrected), 1e-9)
        hold("residual_rms_counts", np.std(corrected), 1e-9)
        hold("mean_counts", np.mean(corrected), 1e-9)
        hold("control_pp_counts", np.ptp(groups[other]["zro_counts"][keep]), 1e-9)
        temperature, fitted = groups[axis]["temperature_counts"][keep], drift[axis]["temperature_counts"]
        fitted = fitted[drift[axis]["phase"] != "soak"]
        hold("temperature_counts", [temperature.min(), temperature.max()], 1e-9)
        beyond = np.maximum(fitted.min() - temperature, temperature - fitted.max())
        hold("outside", np.mean(beyond > HELD_TO_K * COUNTS_PER_CELSIUS), 1e-9)
        # The tap of a write is in the groups after it; that of the last group may be in none.
        writes = np.count_nonzero(np.diff(tap))
        differences.hold(f"{name} wiper_writes", test["wiper_writes"] in (writes, writes + 1), True, 0)
        before = of_phase(drift[axis], test["direction"])["zro_counts"]
        if len(before):
            hold("uncompensated_pp_counts", np.ptp(before), 1e-9)


def soaks(differences, folder, printed):
    groups, hours = recording(folder, "soaks"), printed["soaks"]
    ramps, outside_of_any = recording(folder, "full-temperature"), set()
    for axis in AXES:
        ramp_counts = of_phase(ramps[axis], "heating")["temperature_counts"]
        own, curve = hours[axis], printed["axes"][axis]["drift_raw_coefficients"][::-1]
        differences_of_axis = []
        for point in own["points"]:
            here = (groups[axis]["chamber_set_c"] == point["chamber_c"]) & (groups[axis]["phase"] == "soak")
            temperature, reading = (groups[axis][f"{what}_counts"][here].mean() for what in ("temperature", "zro"))
            name = f"soaks {axis} {point['chamber_c']} C"
            differences.hold(f"{name} temperature_counts", point["temperature_counts"], temperature, 1e-9)
            differences.hold(f"{name} zro_counts", point["zro_counts"], reading, 1e-9)
            differences.hold(f"{name} ramp_counts", point["ramp_counts"], np.polyval(curve, temperature), 1e-9)
            beyond = max(ramp_counts.min() - temperature, temperature - ramp_counts.max())
            outside = bool(beyond > HELD_TO_K * COUNTS_PER_CELSIUS)
            differences.hold(f"{name} outside_ramp", point["outside_ramp"], outside, 0)
            if outside:
                outside_of_any.add(point["chamber_c"])
            else:
                differences_of_axis.append(abs(reading - np.polyval(curve, temperature)))
        differences.hold(f"soaks {axis} maximum", own["max_difference_counts"], max(differences_of_axis), 1e-6)
    saved = hours["soak_hours"] - hours["ramp_hours"]
    if outside_of_any:
        differences.hold("soaks hours_saved is less than all", hours["hours_saved"] < saved, True, 0)
    else:
        differences.hold("soaks hours_saved", hours["hours_saved"], saved, 1e-9)


def made_log(path, seed, drifts_dps=0.0):
    """A cycle with three drifts and noise, two rows a second, Z's noise twice as much on the way back; what is written is
    what is compared. X drifts in time by so much."""
    rng = np.random.default_rng(seed)
    time = np.arange(12_000) / 2
    temperature = 20 - 40 * np.cos(2 * np.pi * time / time[-1])
    x = (temperature - 20) / 40
    drifts = np.stack([0.3 * x + 0.2 * x**2, 0.1 - 0.2 * x, 0.05 * x**3], 1)
    drifts[:, 0] += drifts_dps * time / time[-1]
    back = time > time[-1] / 2
    rates = drifts + rng.normal(0, NOISE, (len(time), 3)) * np.stack([1 + 0 * back, 1 + 0 * back, 1 + back], 1)
    with open(path, "w", encoding="ascii") as out:
        print("time_s,temperature_c,x_dps,y_dps,z_dps", file=out)
        for row in np.column_stack([time, temperature, rates]):
            print(",".join(f"{cell:.9g}" for cell in row), file=out)


def averages(values, rows):
    whole = len(values) // rows * rows
    return values[:whole].reshape(-1, rows).mean(1)


def logs(differences, zerorate, folder):
    first, second = folder / "first.csv", folder / "second.csv"
    made_log(first, 1)
    made_log(second, 2)
    calibration, applied = folder / "calibration.json", folder / "applied.csv"
    fitted = json.loads(run(zerorate, "fit", first, "--out", calibration, "--report", folder / "report.html", "--json"))
    verified = json.loads(run(zerorate, "verify", second, "--with", calibration, "--json"))
    run(zerorate, "apply", calibration, second, "--out", applied)
    with open(applied, encoding="ascii") as text:
        rows = list(csv.DictReader(text))
    rows_of_a_group = round(verified["averaged_over_s"] * 2)
    temperature = averages(np.array([float(row["temperature_c"]) for row in rows]), rows_of_a_group)
    for axis in verified["axes"]:
        name = axis["name"]
        raw = averages(np.array([float(row[name]) for row in rows]), rows_of_a_group)
        predicted = averages(np.array([float(row[f"predicted_{name}"]) for row in rows]), rows_of_a_group)
        left, own = raw - predicted, fitted["axes"][name]
        hold = lambda field, printed, value, tolerance: differences.hold(f"{name} {field}", printed, value, tolerance)
        # Groups are cut by time, and a few rows lie in the group beside.
        hold("verify raw.rms", axis["raw"]["rms"], np.std(raw), 0.01)
        hold("verify corrected.rms", axis["corrected"]["rms"], np.std(left), 0.05)
        hold("verify offset", axis["offset"], np.mean(left), 0.05 + 1e-4 / abs(np.mean(left)))
        # About the mean; or less a zero, by more than chance.
        from_a_zero = axis["deployed"]["rms"] > 1.05 * axis["uncorrected"]["rms"]
        hold("verify worse", axis["worse"], np.std(left) > np.std(raw) or from_a_zero, 0)
        hold("verify temperature", axis["temperature"], [temperature.min(), temperature.max()], 0.01)
        hold("fit temperature", own["temperature"], [temperature.min(), temperature.max()], 0.01)
        # A row far from its neighbours is left out, and of as many rows of noise one is.
        hold("fit samples_used", own["samples_used"], len(rows), 1e-3)
        # Of white noise alone the residual is the noise of an average, in-sample and held out.
        noise_of_ways = NOISE / np.sqrt(rows_of_a_group) * np.array([1, 2 if name.startswith("z") else 1])
        noise = rms(noise_of_ways)
        hold("fit in_sample.rms", own["in_sample"]["rms"], noise, 0.1)
        hold("fit held_out.rms", own["held_out"]["rms"], noise, 0.15)
        cubic = next(candidate for candidate in own["candidates"] if candidate["model"] == "poly:3")
        hold("fit candidates[].by_direction_rms", cubic["by_direction_rms"], noise_of_ways, 0.25)
        # The zero is the mean of two of these averages, and has their noise: a third of all, of eight folds' eight draws. The rms
        # scatters by a twelfth; three of these.
        hold("fit candidates[].deployed_rms", cubic["deployed_rms"], noise * np.sqrt(1 + 1 / 2), 0.25)
        # About the mean of the first half minute, which is left out.
        zeroed = lambda values: values[3:] - values[:3].mean()
        hold("verify uncorrected.rms", axis["uncorrected"]["rms"], rms(zeroed(raw)), 0.02)
        hold("verify deployed.rms", axis["deployed"]["rms"], rms(zeroed(left)), 0.1)
        # Of the fit's longer averages the coldest is a hair warmer than the coldest of these, of which there is one at each end.
        ends = 2 / len(temperature)
        differences.hold(f"{name} verify outside", abs(axis["outside"] - np.mean(np.abs(temperature - 20) > 40)) <= ends, True, 0)
        for field, values in (
            ("raw", raw),
            ("corrected", left),
            ("deployed", zeroed(left)),
            ("uncorrected", zeroed(raw)),
        ):
            hold(f"verify {field}.pp", axis[field]["pp"], np.ptp(values), 0.1)
    errors_of_folds(differences, zerorate, folder, first)
    return trends(differences, zerorate, folder, fitted), verified


def errors_of_folds(differences, zerorate, folder, log):
    """Of a line by least squares on every row, and of what is recorded without a model in averages of 10 s."""
    plain = json.loads(run(zerorate, "fit", log, "--plain", "--model", "poly:3", "--json"))
    fitted = json.loads(run(zerorate, "fit", log, "--json"))
    columns = np.genfromtxt(log, delimiter=",", names=True)
    for name, own in plain["axes"].items():
        temperature, rate = columns["temperature_c"], columns[name]
        fitted_to_all = rate - np.polyval(np.polyfit(temperature, rate, 3), temperature)
        left = held_out(temperature, rate, 3)
        for figure, residuals in (("in_sample", fitted_to_all), ("held_out", left)):
            differences.hold(f"{name} {figure}.rms", own[figure]["rms"], rms(residuals), 1e-6)
            differences.hold(f"{name} {figure}.pp", own[figure]["pp"], np.ptp(residuals), 1e-6)
        printed = own["held_out"]["rms_standard_error"]
        differences.hold(f"{name} held_out.rms_standard_error", printed, rms_error(left), 1e-6)
        raw = averages(columns[name], 20)
        zeroed = raw - raw[:3].mean()
        zeroed[:3] = np.nan
        printed = fitted["axes"][name]["uncorrected"]["rms_standard_error"]
        # The first half minute is left out of a fold.
        error = np.hypot(rms_error(zeroed), error_by_zero(zeroed[3:], 3))
        differences.hold(f"{name} uncorrected.rms_standard_error", printed, error, 0.05)
        # Groups are cut by time, and a few rows lie in the group beside: an extreme one has another noise.
        uncorrected = fitted["axes"][name]["uncorrected"]
        differences.hold(f"{name} uncorrected.rms", uncorrected["rms"], rms(zeroed[3:]), 0.02)
        differences.hold(f"{name} uncorrected.pp", uncorrected["pp"], np.ptp(zeroed[3:]), 0.1)


def trends(differences, zerorate, folder, fitted):
    """A drift in time of 0.1 deg/s is named with its size; without one nothing is. Gives what was printed with the trend."""
    for name, own in fitted["axes"].items():
        differences.hold(f"{name} trends of none", own.get("trends", []) == [], True, 0)
    drifting = folder / "drifting.csv"
    made_log(drifting, 3, 0.1)
    printed = json.loads(run(zerorate, "fit", drifting, "--json"))
    found = {name: own.get("trends", []) for name, own in printed["axes"].items()}
    against = [trend["against"] for trend in found["x_dps"]]
    differences.hold("x_dps trends[].against", against == ["time"], True, 0)
    for trend in found["x_dps"]:
        differences.hold("x_dps trends[].change", trend["change"], 0.1, 0.1)
    differences.hold("y_dps trends of none", found["y_dps"] == [], True, 0)
    return printed


CHAPTERS = {"summary.json": "`summary.json`", "fit --json": "`fit --json`", "verify --json": "`verify --json`"}


def paths(value, path=""):
    """The path of every number, an axis's name as `*`."""
    if isinstance(value, dict):
        for name, inner in value.items():
            # An axis stands where its fellows do, and has a name of the log's own.
            is_axis = path == "axes" or (path == "soaks" and name in AXES)
            yield from paths(inner, f"{path}.{'*' if is_axis else name}".lstrip("."))
    elif isinstance(value, list):
        for inner in value:
            yield from paths(inner, f"{path}[]")
    elif isinstance(value, (int, float)):
        yield path


def claims(differences, printed):
    """Every number printed has its row, and the tests that rows name are there."""
    text = Path("docs/claims.md").read_text(encoding="utf-8")
    chapters = {chapter.split("\n", 1)[0]: chapter for chapter in text.split("\n## ")}
    for command, name in CHAPTERS.items():
        chapter = next(text for head, text in chapters.items() if head.startswith(name))
        rows = set(re.findall(r"^\| `([^`]+)`", chapter, re.MULTILINE))
        missing = sorted(set(paths(printed[command])) - rows)
        differences.hold(f"docs/claims.md, {command}: no row for {', '.join(missing)}", len(missing), 0, 0)
    sources = "\n".join(path.read_text(encoding="utf-8") for path in Path("crates").rglob("*.rs"))
    for test in set(re.findall(r"`([a-z0-9_]{20,})`", text)):
        differences.hold(f"docs/claims.md names {test}, which is no test", f"fn {test}(" in sources, True, 0)


def main():
    zerorate = sys.argv[1]
    differences = Differences()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run(zerorate, "calibrate", "--seed", "5", "--out", folder / "run")
        printed = json.loads((folder / "run/summary.json").read_text())
        ramp(differences, folder / "run", printed)
        compensation_tests(differences, folder / "run", printed)
        soaks(differences, folder / "run", printed)
        fitted, verified = logs(differences, zerorate, folder)
        claims(differences, {"summary.json": printed, "fit --json": fitted, "verify --json": verified})
    if differences.found:
        sys.exit("\n".join(differences.found))
    print(f"{differences.compared} numbers are numpy's")


if __name__ == "__main__":
    main()
