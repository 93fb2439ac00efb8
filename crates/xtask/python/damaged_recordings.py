#!/usr/bin/env python3
"""Check what `zerorate fit` says of recordings that were damaged in known ways.

usage: damaged_recordings.py ZERORATE encode_flight_logs.py RECORDING.tsv

The encoder writes the whole recording as CSV, and the damaged ones. A narrow span and a stuck temperature must be
rejected; rows without a temperature dropped and counted; spikes, a rotation and a step told of, which is: a reason is
given, or samples are rejected, that the whole recording gave no cause for.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

REJECTED = 1
# The encoder takes the temperature from every 50th row, beginning with the first.
NAN_EVERY = 50


def fit(zerorate, recording):
    """Exit code and result of a fit."""
    command = [zerorate, "fit", str(recording), "--model", "poly:3", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, REJECTED):
        sys.exit(f"`{' '.join(command)}` ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.returncode, json.loads(done.stdout)


def losses(result):
    """Samples rejected, by axis and reason."""
    return {
        (axis, loss["reason"]): loss["count"]
        for axis, fitted in result["axes"].items()
        for loss in fitted["samples_rejected"]
    }


def rejected(code, result, _whole, _rows):
    return code == REJECTED and result["verdict"] == "rejected" and result["reasons"]


def dropped_and_counted(code, result, _whole, rows):
    lost = len(range(0, rows, NAN_EVERY))
    counts = [[loss["count"] for loss in axis["samples_rejected"]] for axis in result["axes"].values()]
    return code == 0 and counts and all(lost in of_axis for of_axis in counts)


def told_of(_code, result, whole, _rows):
    # By kind and not by text: a text has numbers, and they differ without having noticed anything.
    kinds = {reason["kind"] for reason in result["reasons"]} - {reason["kind"] for reason in whole["reasons"]}
    before = losses(whole)
    return kinds or any(count > before.get(place, 0) for place, count in losses(result).items())


EXPECTED = {
    "narrow-span": rejected,
    "stuck-temperature": rejected,
    "nan-temperature": dropped_and_counted,
    "spikes": told_of,
    "rotation": told_of,
    "step": told_of,
}


def main():
    zerorate, encoder, recording = sys.argv[1:]
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        prefix = Path(folder, "recording")
        for options in ([], ["--faults"]):
            encode = [sys.executable, encoder, recording, prefix, *options]
            subprocess.run(encode, check=True, stdout=subprocess.DEVNULL)
        _, whole = fit(zerorate, f"{prefix}.csv")
        print(f"    whole: {whole['verdict']}")
        for damage, expected in EXPECTED.items():
            damaged = Path(f"{prefix}.{damage}.csv")
            rows = sum(1 for _ in damaged.open()) - 1
            code, result = fit(zerorate, damaged)
            kinds = ", ".join(reason["kind"] for reason in result["reasons"]) or "no reasons"
            good = bool(expected(code, result, whole, rows))
            judged = "as it should be" if good else f"NOT {expected.__name__}"
            print(f"    {damage}: {result['verdict']} ({kinds}): {judged}")
            if not good:
                missed.append(damage)
    if missed:
        sys.exit(f"not seen for what they are: {', '.join(missed)}")


if __name__ == "__main__":
    main()
