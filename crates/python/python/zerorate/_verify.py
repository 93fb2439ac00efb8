"""A second run against a calibration."""

from zerorate import _zerorate
from zerorate._sources import named_columns, sources


def verify(
    log,
    calibration,
    *,
    max_rms=None,
    max_pp=None,
    max_offset=None,
    sensor=None,
    in_sample=False,
    temperature=None,
    rates=None,
    time=None,
    temperature_unit=None,
    rate_unit=None,
    time_unit=None,
):
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
    columns = named_columns(time, temperature, rates, time_unit)
    columns |= {"temperature_unit": temperature_unit, "rate_unit": rate_unit}
    against = {"max_rms": max_rms, "max_pp": max_pp, "max_offset": max_offset, "sensor": sensor, "in_sample": in_sample}
    return _zerorate.verify(source, calibration, columns, against)
