"""Makes the logs that the book's commands read: two runs of one made-up vehicle, as PX4's ULog and as a table.

usage: example_logs.py FOLDER

Its gyro follows a cubic of temperature with a play of half a kelvin (hysteresis), and has white noise. A run goes from cold to
warm and back.
"""

import pathlib
import struct
import sys

import numpy as np

folder = pathlib.Path(sys.argv[1])
HZ, HOURS = 5, 1.5
DEVICE_ID = 2621448


def run(seed, coldest, warmest):
    random = np.random.default_rng(seed)
    t = np.arange(0, HOURS * 3600, 1 / HZ)
    temperature = coldest + (warmest - coldest) * np.sin(np.pi * t / t[-1])
    play, at = np.empty(len(t)), temperature[0]
    for row, now in enumerate(temperature):
        at = min(max(at, now - 0.5), now + 0.5)
        play[row] = at
    curve = 2e-3 - 4e-4 * (play - 25) + 6e-6 * (play - 25) ** 2 - 5e-8 * (play - 25) ** 3
    rates = np.stack([weight * curve + random.normal(0, 1.5e-3, len(t)) for weight in (1.0, -0.6, 0.3)], 1)
    return t, rates, temperature + random.normal(0, 0.02, len(t))


def write_ulog(path, t, rates, temperature):
    def message(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;uint32_t error_count;"
    row = struct.Struct("<HQQIffffI")
    microseconds = (t * 1e6).astype(np.uint64) + 1_000_000
    with open(path, "wb") as file:
        file.write(b"\x55\x4c\x6f\x67\x01\x12\x35\x01" + struct.pack("<Q", int(microseconds[0])))
        file.write(message("B", bytes(40)) + message("F", b"sensor_gyro:" + fields.encode()))
        file.write(message("A", struct.pack("<BH", 0, 0) + b"sensor_gyro"))
        for time, rate, degrees in zip(microseconds, rates, temperature):
            file.write(message("D", row.pack(0, int(time), int(time), DEVICE_ID, *rate, degrees, 0)))


for name, seed, coldest, warmest in (("flight", 1, -12.0, 48.0), ("second", 2, -8.0, 45.0)):
    t, rates, temperature = run(seed, coldest, warmest)
    write_ulog(folder / f"{name}.ulg", t, rates, temperature)
    table = np.column_stack([t, temperature, rates])
    head = "time_s,temperature_c,x_rad_s,y_rad_s,z_rad_s"
    np.savetxt(folder / f"{name}.csv", table, fmt="%.6g", delimiter=",", header=head, comments="")
