"""What the tests have in common: a made log, and the command that the package is held against."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]

ROWS = 8000


def by_parameters(text):
    """What the command tells, as the package tells it: it names a parameter where that names an option. All else is the same."""
    return re.sub(r"--([a-z]+(?:-[a-z]+)*)", lambda option: f"`{option[1].replace('-', '_')}`", text)


@pytest.fixture(scope="session")
def ramp():
    """Time, s, shape (n,); temperature, degrees C, shape (n,); rates, rad/s, shape (n, 3): there and back again."""
    random = np.random.default_rng(7)
    time = 0.5 * np.arange(ROWS)
    temperature = 25.0 + 30.0 * np.sin(2.0 * np.pi * time / time[-1])
    drift = np.stack([2e-3 * k + 3e-4 * temperature - k * 2e-6 * temperature**2 for k in range(3)], axis=1)
    return time, temperature, drift + 1e-3 * random.standard_normal(drift.shape)


@pytest.fixture(scope="session")
def columns(ramp):
    """The same by the names that a CSV has."""
    time, temperature, rates = ramp
    return {"time": time, "temperature": temperature} | {f"gyro_{axis}": rates[:, k] for k, axis in enumerate("xyz")}


@pytest.fixture(scope="session")
def csv(columns, tmp_path_factory):
    """The same as a file, every number with all its digits."""
    path = tmp_path_factory.mktemp("logs") / "ramp.csv"
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="session")
def command():
    """Runs the built command that ZERORATE_COMMAND names."""
    program = os.environ.get("ZERORATE_COMMAND")
    if program is None:
        pytest.skip("ZERORATE_COMMAND names no built command to compare with")

    def run(*arguments):
        return subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True)

    return run


@pytest.fixture(scope="session")
def chamber_cycle():
    """A real gyro's chamber cycle, where it is."""
    data = Path(os.environ.get("ZERORATE_DATA", ROOT / "../shared/data"))
    path = data / "imu-chamber-cycle/imu_raw_data.tsv"
    if not path.is_file():
        pytest.skip(f"{path.name} is missing: ../shared/data is not there, and ZERORATE_DATA names no other folder")
    return path
