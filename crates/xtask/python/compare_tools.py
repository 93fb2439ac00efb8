#!/usr/bin/env python3
"""Set `zerorate fit` beside ArduPilot's script for the temperature calibration of IMUs.

usage: compare_tools.py ZERORATE ENCODER RECORDING.tsv FOLDER DEADLINE_S [HZ ...]

The chamber cycle, as ENCODER writes it at 2 (as recorded), 25 and 100 Hz. Both get the same DataFlash file, and are held
by the same yardstick: wall time and peak memory of the command as a user types it; in-sample, what its curve leaves of
the file; held out, what it leaves of each of 8 contiguous stretches when it was given the other 7 (zerorate chooses its
model anew each time; the script has one). Figures are root mean squares over averages of 10.6 s, in mrad/s, X / Y / Z.
ArduPilot's parameters hold no constant: the script is given the one that is best on what it was fitted to.

ArduPilot's script is the fork that the package ardupilot_methodic_configurator carries; its time grows with the square
of the log's length, so it is stopped after DEADLINE_S seconds, and what was not finished is said so.
"""

import csv
import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

STRETCHES = 8
GROUP_S = 10.6
AXES = "XYZ"
REFERENCE_C = 35.0
SCRIPT = [sys.executable, "-m", "ardupilot_methodic_configurator.tempcal_imu", "--no-graph", "--outfile"]


def run(command, deadline_s=None):
    """Wall time in s, peak resident memory in MB, and whether it came to its end and succeeded."""
    started = time.monotonic()
    peak_mb = 0.0
    with subprocess.Popen(
        [str(part) for part in command],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, "MPLBACKEND": "agg"},
    ) as process:
        while True:
            peak_mb = max(peak_mb, high_water_mb(process.pid))
            pid, status = os.waitpid(process.pid, os.WNOHANG)
            took = time.monotonic() - started
            if pid:
                break
            if deadline_s and took > deadline_s:
                os.kill(process.pid, signal.SIGKILL)
                os.waitpid(process.pid, 0)
                process.returncode = -signal.SIGKILL
                return took, peak_mb, False
            time.sleep(0.002)
        process.returncode = os.waitstatus_to_exitcode(status)
        told = process.stderr.read().decode(errors="replace").strip()
        # zerorate ends with 1 for a log that it warns of in no other way.
        if process.returncode != 0:
            sys.exit(f"{' '.join(map(str, command))} ended with {process.returncode}: {told[-500:]}")
    return took, peak_mb, True


def high_water_mb(pid):
    """The most memory that a running process has had; 0 when it is gone.

    What wait4 tells begins with this script's own memory, from before the process became another program.
    """
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM:")), 0.0)


class Log:
    """The cycle at one rate."""

    def __init__(self, encoder, recording, hz):
        self.encoder = encoder
        self.t, self.gyro, self.accel, self.temp = encoder.load(recording)
        if hz:
            self.t, self.gyro, self.accel, self.temp = encoder.resample(self.t, self.gyro, self.accel, self.temp, hz)
        self.stretches = np.array_split(np.arange(len(self.t)), STRETCHES)

    def write_dataflash(self, path, rows=slice(None)):
        self.encoder.write_dataflash(path, self.t[rows], self.gyro[rows], self.accel[rows], self.temp[rows])

    def rms(self, residuals):
        """Of residuals of some stretches, each averaged over whole groups by itself; mrad/s."""
        rows = max(1, round(GROUP_S * (len(self.t) - 1) / (self.t[-1] - self.t[0])))
        means = [r[: len(r) // rows * rows].reshape(-1, rows, 3).mean(1) for r in residuals]
        return 1e3 * np.sqrt((np.concatenate(means) ** 2).mean(0))


class ArduPilot:
    """The script, called as its users call it."""

    def __init__(self, folder):
        self.parameters, self.part = folder / "tcal.parm", folder / "part.bin"

    def fit(self, path, deadline_s):
        return run([*SCRIPT, self.parameters, path], deadline_s)

    def curve(self, temperature):
        """ArduPilot's formula on the parameters written."""
        lines = (line.split() for line in self.parameters.read_text().splitlines() if line.strip())
        found = {name: float(value) for name, value in lines}
        x = np.clip(temperature, found["INS_TCAL1_TMIN"], found["INS_TCAL1_TMAX"]) - REFERENCE_C
        terms = [[found[f"INS_TCAL1_GYR{power}_{axis}"] for axis in AXES] for power in (1, 2, 3)]
        return 1e-6 * sum(np.outer(x**power, term) for power, term in zip((1, 2, 3), terms))

    def residuals(self, log, fitted, predicted):
        constant = (log.gyro[fitted] - self.curve(log.temp[fitted])).mean(0)
        return log.gyro[predicted] - self.curve(log.temp[predicted]) - constant

    def held_out(self, log, deadline_s):
        found = []
        for stretch in log.stretches:
            rest = np.setdiff1d(np.arange(len(log.t)), stretch)
            log.write_dataflash(self.part, rest)
            if not self.fit(self.part, deadline_s)[2]:
                return None
            found.append(self.residuals(log, rest, stretch))
        return log.rms(found)


class Zerorate:
    """The command, with the model that it chooses."""

    def __init__(self, program, folder):
        self.program = program
        self.model, self.table, self.out = folder / "model.json", folder / "part.csv", folder / "out.csv"
        told = subprocess.run([program, "apply", "--help"], capture_output=True, text=True, check=True).stdout
        # The recording's own slow drift belongs to what is predicted of it.
        self.options = ["--with-time-drift"] if "--with-time-drift" in told else []

    def fit(self, path, report):
        return run([self.program, "fit", path, "--out", self.model, "--report", report])

    def residuals(self, log, blanked=None):
        """Of a fit of the table in which a stretch has no rates, over that stretch; of all without one."""
        rate = log.gyro.copy()
        if blanked is not None:
            rate[blanked] = np.nan
        head = "t_s,temperature_c,x_rad_s,y_rad_s,z_rad_s"
        np.savetxt(self.table, np.c_[log.t, log.temp, rate], delimiter=",", header=head, comments="", fmt="%.9g")
        run([self.program, "fit", self.table, "--out", self.model])
        run([self.program, "apply", self.model, self.table, *self.options, "--out", self.out])
        with open(self.out, newline="") as file:
            rows = csv.reader(file)
            names = next(rows)
            places = [names.index(f"predicted_{axis}_rad_s") for axis in "xyz"]
            predicted = np.array([[float(row[place]) for place in places] for row in rows])
        kept = slice(None) if blanked is None else blanked
        return log.gyro[kept] - predicted[kept]


def line(name, wall_s, peak_mb, in_sample, held_out):
    def figures(values):
        return " / ".join(f"{v:5.2f}" for v in values) if values is not None else "-".center(21)

    print(f"  {name:20s} {wall_s:8.2f} {peak_mb:8.0f}    {figures(in_sample)}    {figures(held_out)}", flush=True)


def compare(encoder, recording, program, folder, hz, deadline_s):
    log = Log(encoder, recording, hz)
    path = folder / f"log-{hz or 2:g}.bin"
    log.write_dataflash(path)
    print(f"{hz or 1.98:g} Hz: {len(log.t)} samples, {path.stat().st_size / 1e6:.1f} MB")
    script, own = ArduPilot(folder), Zerorate(program, folder)
    wall_s, peak_mb, finished = script.fit(path, deadline_s)
    if finished:
        everything = np.arange(len(log.t))
        in_sample = log.rms([script.residuals(log, everything, everything)])
        line("ArduPilot's script", wall_s, peak_mb, in_sample, script.held_out(log, deadline_s))
    else:
        print(f"  ArduPilot's script   not finished in {deadline_s:.0f} s, {peak_mb:.0f} MB by then")
    own_wall_s, own_peak_mb, _ = own.fit(path, folder / "report.html")
    held_out = log.rms([own.residuals(log, stretch) for stretch in log.stretches])
    line("zerorate", own_wall_s, own_peak_mb, log.rms([own.residuals(log)]), held_out)
    more = "" if finished else "more than "
    print(f"  {more}{wall_s / own_wall_s:.0f} times as fast\n", flush=True)


def main():
    program, encoder_path, recording, folder = map(Path, sys.argv[1:5])
    deadline_s = float(sys.argv[5])
    rates = [float(hz) for hz in sys.argv[6:]] or [0.0, 25.0, 100.0]
    spec = importlib.util.spec_from_file_location("encoder", encoder_path)
    encoder = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(encoder)
    folder.mkdir(parents=True, exist_ok=True)
    print(f"{'':22s} {'wall, s':>8s} {'peak, MB':>8s}    {'in-sample rms, mrad/s':23s} {'held-out rms, mrad/s':23s}")
    for hz in rates:
        compare(encoder, recording, program, folder, 0.0 if hz == 2 else hz, deadline_s)


if __name__ == "__main__":
    main()
