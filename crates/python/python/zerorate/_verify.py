"""A second run against a calibration."""

from __future__ import annotations

from typing import Any

from zerorate import _zerorate
from zerorate._sources import named_columns, sources


def verify(
    log: Any,
    calibration: _zerorate.Calibration,
    *,
    max_rms: str | None = None,
    max_pp: str | None = None,
    max_offset: str | None = None,
    sensor: str | int | None = None,
    in_sample: bool = False,
    temperature: str | None = None,
    rates: str | list[str] | None = None,
    time: str | None = None,
    temperature_unit: str | None = None,
    rate_unit: str | None = None,
    time_unit: str | None = None,
) -> dict[str, Any]:
    """See what a calibration leaves of a log that it has not seen, in averages of 10 s.

    Parameters
    ----------
    log : path, bytes, data frame or dict of columns
        The second run. The log that was fitted is refused, for it is no test.
    calibration : Calibration
    max_rms, max_pp, max_offset : str, optional
        What may be left at most, with its unit: ``"0.5mrad/s"``, ``"30deg/h"``.
    sensor : str, optional
        These sensors alone, of the calibration and of the log.
    in_sample : bool
        Take the log that was fitted all the same.
    temperature, rates, time, temperature_unit, rate_unit, time_unit
        As for `fit`, with a log.

    Returns
    -------
    dict
        What ``zerorate verify --json`` prints: ``passed`` (None without limits), ``verdict``, ``axes``, ``reasons`` and
        more. Rates are in each axis's ``rate_unit``.

    Raises
    ------
    Error
        The log cannot be read, is no test, or its axes are not the calibration's.
    """
    [source] = sources([log])
    columns = named_columns(
        time, temperature, rates, time_unit, temperature_unit=temperature_unit, rate_unit=rate_unit
    )
    against = {"max_rms": max_rms, "max_pp": max_pp, "max_offset": max_offset, "in_sample": in_sample}
    against["sensor"] = None if sensor is None else str(sensor)
    return _zerorate.verify(source, calibration, columns, against)
