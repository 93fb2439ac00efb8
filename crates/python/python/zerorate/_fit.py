"""The fit of logs, frames and arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from zerorate import _zerorate
from zerorate._sources import named_columns, of_arrays, sources


def fit(
    log: Any = None,
    *,
    temperature: str | ArrayLike | None = None,
    rates: str | Sequence[str] | ArrayLike | Mapping[str, ArrayLike] | None = None,
    time: str | ArrayLike | None = None,
    temperature_unit: str | None = None,
    rate_unit: str | None = None,
    time_unit: str | None = None,
    model: str = "auto",
    plain: bool = False,
    allow_narrow: bool = False,
    group_seconds: float | None = None,
    sensor: str | int | None = None,
    serial: str | None = None,
    labels: Mapping[str, str] | None = None,
) -> _zerorate.Calibration:
    """Fit the drift of a log: rate over temperature, recorded at rest.

    Give a log, or the arrays themselves::

        zerorate.fit("chamber.csv")
        zerorate.fit(frame, temperature="imu.temp", rates=["gx", "gy", "gz"], rate_unit="dps")
        zerorate.fit(time=t, temperature=T, rates=w)

    Parameters
    ----------
    log : path, bytes, data frame, dict of columns, or a list of these
        A file of any kind that the command reads, its bytes, or a frame of polars, pandas or any other with Arrow's C
        stream interface. A list is logs of one unit, fitted as one.
    temperature : str or array of shape (n,)
        With a log the name of its column; without one the temperatures, degrees C.
    rates : list of str, array of shape (n,) or (n, 3), or dict of arrays of shape (n,)
        With a log the names of its columns; without one the rates, rad/s. An array's columns are called ``gyro_x``,
        ``gyro_y``, ``gyro_z``; a dict has names of its own, which may say the unit: ``x_dps``.
    time : str or array of shape (n,), optional
        With a log the name of its column; without one the times, seconds from anywhere, or datetime64.
    temperature_unit : {"celsius", "fahrenheit", "kelvin", "counts"}, optional
        Where the column's name does not say it, or says it wrongly.
    rate_unit : {"dps", "mdps", "deg/h", "rad/s", "mrad/s", "counts"}, optional
        The same of the rates. Rates in no known unit are taken for rad/s, with a warning.
    time_unit : {"s", "ms", "us", "ns"}, optional
        The same of the times; arrays of numbers are in seconds.
    model : str
        ``auto``, ``poly:1`` to ``poly:5``, ``table:1`` to ``table:32``.
    plain : bool
        Ordinary least squares on every row with numbers, to compare with other tools.
    allow_narrow : bool
        Accept a temperature span under 10 C.
    group_seconds : float, optional
        Seconds over which rows are averaged, 0.01 to 600; about 10 without it.
    sensor : str, optional
        These sensors alone: ``gyro``, ``accel``, ``gyro0``, or a part's device id.
    serial : str, optional
        The unit's serial number.
    labels : dict of str, optional
        What is to stand in the calibration besides, as ``{"operator": "A. N."}``.

    Returns
    -------
    Calibration

    Raises
    ------
    RejectedLog
        The log can be read and is no good; its ``reasons`` say why, a sentence each.
    Error
        The log cannot be read, or its columns are unclear.
    """
    units = {"temperature_unit": temperature_unit, "rate_unit": rate_unit}
    if log is None:
        if temperature is None or rates is None:
            raise _zerorate.Error("give a log, or the arrays `temperature` and `rates`")
        source, columns = of_arrays(temperature, rates, time, time_unit, **units)
        read = [source]
    else:
        read = sources(log)
        columns = named_columns(time, temperature, rates, time_unit, **units)
    how = {
        "model": model,
        "plain": plain,
        "allow_narrow": allow_narrow,
        "group_seconds": group_seconds,
        "sensor": None if sensor is None else str(sensor),
        "serial": serial,
        "labels": labels,
    }
    return _zerorate.fit(read, columns, how)
