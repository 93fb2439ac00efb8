#!/usr/bin/env python3
"""Hold `zerorate fit --plain` against numpy.polyfit.

usage: compare_fit.py ZERORATE [RECORDING.tsv]

Fits a cubic to a made recording, and to a real one where it is given, with both. The two curves may differ by 1e-9 of
the curve's own range (its highest value less its lowest over the temperatures of the recording) and no more.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ORDER = 3
TOLERANCE = 1e-9
HEADER = "timestamp\timu.gyro.x\timu.gyro.y\timu.gyro.z\timu.acc.x\timu.acc.y\timu.acc.z\timu.status\timu.temperature"
RATES = ("imu.gyro.x", "imu.gyro.y", "imu.gyro.z")
TEMPERATURE = "imu.temperature"


def made_recording(path):
    """A chamber's cycle: three known cubics, an offset up to 1000 times the noise, some temperatures lost."""
    rng = np.random.default_rng(2)
    rows = 20_000
    time_us = np.arange(rows) * 500_000
    temperature = 15.0 - 35.0 * np.cos(np.linspace(0.0, 2.0 * np.pi, rows)) + rng.normal(0.0, 0.02, rows)
    warm = temperature - 25.0
    drifts = [1.0 + 2e-4 * warm - 3e-6 * warm**2 + 2e-8 * warm**3, -0.5 - 1e-4 * warm, 0.02 + 5e-6 * warm**2]
    rates = [drift + rng.normal(0.0, 1e-3, rows) for drift in drifts]
    temperature[::997] = np.nan
    zero = np.zeros(rows)
    columns = [time_us, *rates, zero, zero, zero - 9.81, zero, temperature]
    formats = ["%d"] + ["%.12g"] * 6 + ["%d", "%.12g"]
    np.savetxt(path, np.column_stack(columns), delimiter="\t", header=HEADER, comments="", fmt=formats)


def fitted(zerorate, recording):
    """The axes of the fit, by column name."""
    command = [zerorate, "fit", str(recording), "--model", f"poly:{ORDER}", "--plain", "--json", "--rate-unit", "rad/s"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"`{' '.join(command)}` ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return json.loads(done.stdout)["axes"]


def distances(zerorate, recording):
    """For each rate column: the largest distance of the two curves, in ranges of numpy's."""
    table = np.genfromtxt(recording, delimiter="\t", names=True, deletechars="")
    axes = fitted(zerorate, recording)
    for rate in RATES:
        rows = np.isfinite(table[TEMPERATURE]) & np.isfinite(table[rate])
        temperature, reading = table[TEMPERATURE][rows], table[rate][rows]
        grid = np.linspace(temperature.min(), temperature.max(), 1001)
        theirs = np.polyval(np.polyfit(temperature, reading, ORDER), grid)
        ours = np.polyval(axes[rate]["raw_coefficients"][::-1], grid)
        if axes[rate]["samples_used"] != rows.sum():
            sys.exit(f"{recording}: {rate}: {axes[rate]['samples_used']} samples used of {rows.sum()}")
        yield rate, np.max(np.abs(ours - theirs)) / np.ptp(theirs)


def main():
    zerorate, *recordings = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "made.tsv")
        made_recording(made)
        apart = False
        for recording in [made, *map(Path, recordings)]:
            for rate, distance in distances(zerorate, recording):
                print(f"    {recording.name} {rate}: {distance:.1e} of the curve's range")
                apart |= not distance <= TOLERANCE
    if apart:
        sys.exit(f"the curves may be {TOLERANCE:.0e} of their range apart")


if __name__ == "__main__":
    main()
