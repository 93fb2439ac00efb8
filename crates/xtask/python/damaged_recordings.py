#!/usr/bin/env python3
"""Check what `zerorate fit` says of recordings that were damaged in known ways, in every format.

usage: damaged_recordings.py ZERORATE encode_flight_logs.py RECORDING.tsv

The encoder writes the whole recording as CSV, ULog and DataFlash, and the damaged ones. A narrow span and a stuck
temperature must be rejected; rows without a temperature dropped and counted; spikes, a rotation and a step told of by
their names, and nothing of the kind told of the whole recording. Where a damaged recording is fitted, the cubic must be
that of the whole one to a fiftieth of its peak to peak.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

REJECTED = 1
# The encoder takes the temperature from every 50th row, beginning with the first.
NAN_EVERY = 50
# Of the curve's peak to peak, anywhere in its range.
MOST_CHANGE = 0.02
FORMATS = ("csv", "ulg", "bin")
EXPECTED = {
    "narrow-span": ("rejected", "narrow-span"),
    "stuck-temperature": ("rejected", "stuck-temperature"),
    "nan-temperature": ("warning", "missing-values"),
    "spikes": ("warning", "spikes"),
    "rotation": ("warning", "rotation"),
    "step": ("warning", "step"),
}


def fit(zerorate, recording):
    """Exit code and result of a fit."""
    command = [zerorate, "fit", str(recording), "--model", "poly:3", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, REJECTED):
        sys.exit(f"`{' '.join(command)}` ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.returncode, json.loads(done.stdout)


def kinds(result):
    return {reason["kind"] for reason in result["reasons"]}


def value(axis, temperature):
    return sum(c * temperature**k for k, c in enumerate(axis["raw_coefficients"]))


def change(axis, whole):
    """How far a curve is from the whole recording's, of that one's peak to peak, over the range of both."""
    low = max(axis["temperature"][0], whole["temperature"][0])
    high = min(axis["temperature"][1], whole["temperature"][1])
    at = [low + (high - low) * k / 200 for k in range(201)]
    of_whole = [value(whole, t) for t in at]
    difference = max(abs(value(axis, t) - v) for t, v in zip(at, of_whole))
    return difference / (max(of_whole) - min(of_whole))


def judge(code, result, whole, verdict, kind, rows):
    """What is wrong with what was said; empty where nothing is."""
    wrong = []
    if result["verdict"] != verdict or (code == REJECTED) != (verdict == "rejected"):
        wrong.append(f"verdict {result['verdict']} (exit {code}), not {verdict}")
    if kind not in kinds(result):
        wrong.append(f"no reason {kind}")
    if kind == "missing-values":
        lost = len(range(0, rows, NAN_EVERY))
        for name, axis in result["axes"].items():
            if lost not in [loss["count"] for loss in axis["samples_rejected"]]:
                wrong.append(f"{name}: not {lost} rows counted")
    worst = 0.0
    if verdict != "rejected":
        for name, axis in result["axes"].items():
            # An accelerometer's curve is of no damage here, but its left-out rows are the gyro's.
            moved = change(axis, whole["axes"][name])
            worst = max(worst, moved)
            if moved > MOST_CHANGE:
                wrong.append(f"{name} moved by {100 * moved:.2f} %")
    return wrong, worst


def main():
    zerorate, encoder, recording = sys.argv[1:]
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        prefix = Path(folder, "recording")
        for options in ([], ["--faults"]):
            encode = [sys.executable, encoder, recording, prefix, *options]
            subprocess.run(encode, check=True, stdout=subprocess.DEVNULL)
        for form in FORMATS:
            code, whole = fit(zerorate, f"{prefix}.{form}")
            invented = kinds(whole) & {kind for _, kind in EXPECTED.values()}
            print(f"    whole.{form}: {whole['verdict']} ({', '.join(sorted(kinds(whole))) or 'no reasons'})")
            if code or invented:
                missed.append(f"whole.{form}: {invented}")
            for damage, (verdict, kind) in EXPECTED.items():
                code, result = fit(zerorate, f"{prefix}.{damage}.{form}")
                rows = sum(1 for _ in Path(f"{prefix}.{damage}.csv").open()) - 1
                wrong, worst = judge(code, result, whole, verdict, kind, rows)
                said = ", ".join(sorted(kinds(result)))
                print(f"    {damage}.{form}: {result['verdict']} ({said}), curve moved {100 * worst:.2f} %")
                missed.extend(f"{damage}.{form}: {what}" for what in wrong)
    if missed:
        sys.exit("not seen for what they are:\n  " + "\n  ".join(missed))


if __name__ == "__main__":
    main()
