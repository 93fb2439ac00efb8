"""A log's rows as data frames."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from zerorate import _zerorate
from zerorate._sources import named_columns, sources

_KINDS = ("polars", "pandas", "numpy")


def read_log(
    log: Any,
    *,
    frames: str | None = None,
    temperature: str | None = None,
    rates: str | list[str] | None = None,
    time: str | None = None,
    temperature_unit: str | None = None,
    rate_unit: str | None = None,
    time_unit: str | None = None,
) -> dict[str, Any]:
    """Read a log of any kind that the command reads.

    Parameters
    ----------
    log : path or bytes
    frames : {"polars", "pandas", "numpy"}, optional
        What to give: data frames, or dicts of arrays. Without it the first of the three that is installed.
    temperature, rates, time, temperature_unit, rate_unit, time_unit
        As for `fit`, with a log.

    Returns
    -------
    dict of str to data frame
        Of each sensor (``gyro0``, ``accel1``; ``gyro`` of a table with one) its rows: ``time_s``, seconds from the log's
        first row; ``temperature_c`` or ``temperature_counts``; and a column an axis whose name ends in its unit, ``_rad_s``,
        ``_dps``, ``_m_s2`` or ``_counts``. What is missing is NaN. Such a frame can be fitted.

    Raises
    ------
    Error
        The log cannot be read, or its columns are unclear.
    """
    kind = frames or next(kind for kind in _KINDS if find_spec(kind))
    if kind not in _KINDS:
        raise _zerorate.Error(f"'{kind}' are no frames: give one of {', '.join(_KINDS)}")
    [source] = sources([log])
    columns = named_columns(
        time, temperature, rates, time_unit, temperature_unit=temperature_unit, rate_unit=rate_unit
    )
    return {sensor: _frame(kind, dict(rows)) for sensor, rows in _zerorate.read_log(source, columns)}


def _frame(kind, rows):
    if kind == "polars":
        import polars

        return polars.DataFrame(rows)
    if kind == "pandas":
        import pandas

        return pandas.DataFrame(rows)
    return rows
