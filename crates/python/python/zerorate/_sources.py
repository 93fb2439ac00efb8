"""What a log may be in Python: a path, bytes, a data frame, arrays."""

import os
from collections.abc import Mapping

import numpy as np

from zerorate._zerorate import Error, Source

_AXES = ("x", "y", "z")


def sources(log):
    """Of a log, or a list of logs of one unit, what is read."""
    several = log if isinstance(log, (list, tuple)) else [log]
    if not several:
        raise Error("give a log at least")
    return [_source(log) for log in several]


def of_arrays(temperature, rates, time, time_unit, **units):
    """Of arrays what is read, and which of its columns is which."""
    rates = _named(rates)
    columns = {"temperature": temperature} | rates
    if time is not None:
        columns |= {"time": time}
        if time_unit is None and _array(time).dtype.kind != "M":
            time_unit = "s"
    names = named_columns(None if time is None else "time", "temperature", list(rates), time_unit, **units)
    return _columns("arrays", columns), names


def named_columns(time, temperature, rates, time_unit, **units):
    """Which column is which, by name, and the units of the others."""
    rates = [rates] if isinstance(rates, str) else rates
    return {"time": time, "temperature": temperature, "rates": rates, "time_unit": time_unit} | units


def _source(log):
    if isinstance(log, (bytes, bytearray, memoryview)):
        return Source.bytes("bytes", bytes(log))
    if isinstance(log, (str, os.PathLike)):
        # Python's own error where there is no such file.
        os.stat(log)
        return Source.file(os.fspath(log))
    if isinstance(log, Mapping):
        return _columns("columns", log)
    if hasattr(log, "columns") or hasattr(log, "__arrow_c_stream__"):
        return _frame(log)
    raise Error(f"a log is a path, bytes, a data frame or a dict of columns, and this is a {type(log).__name__}")


def _frame(frame):
    if hasattr(frame, "reset_index") and type(frame.index).__name__ != "RangeIndex":
        # An index of times is a column like any other.
        frame = frame.reset_index()
    try:
        return Source.stream("frame", frame)
    except (ImportError, TypeError, ValueError, Error):
        # pandas gives Arrow's columns where pyarrow is there, and polars has kinds that no other Arrow knows; numpy's they have.
        return _columns("frame", {str(name): frame[name] for name in frame.columns}, whole=False)


def _columns(name, columns, whole=True):
    """Columns of numpy; of a frame that is not taken whole those that are no numbers are left out."""
    arrays = {str(column): _array(values) for column, values in columns.items()}
    if not whole:
        arrays = {column: array for column, array in arrays.items() if array.dtype.kind in "biufM"}
    lengths = {column: array.shape for column, array in arrays.items()}
    if len(set(lengths.values())) != 1 or any(len(shape) != 1 for shape in lengths.values()):
        told = ", ".join(f"{column} {shape}" for column, shape in lengths.items())
        raise Error(f"columns must be of one dimension and one length, and are: {told}")
    return Source.columns(name, [(column, _plain(column, array)) for column, array in arrays.items()])


def seconds(times):
    """Times as seconds from anywhere: numbers as they are, dates from the first one."""
    times = _array(times)
    if times.dtype.kind == "M":
        times = (times - times[~np.isnat(times)][:1]) / np.timedelta64(1, "s") if times.size else np.zeros(0)
    return numbers(times)


def numbers(values):
    """Numbers of shape (n,)."""
    array = _array(values)
    if array.ndim != 1:
        raise Error(f"an array of shape {array.shape}: give one of shape (n,)")
    if array.dtype.kind == "M":
        raise Error("dates where numbers should be: give numbers")
    try:
        return np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise Error(f"no numbers: {error}") from error


def _array(values):
    """An array of numpy, with what is masked missing, and every kind of time as a date: one that lasted from 1970 on."""
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        # Dates of a time zone are objects to numpy.
        values = getattr(values, "dt", values).tz_convert(None)
    if np.ma.isMaskedArray(values):
        is_time = values.dtype.kind in "mM"
        values = values.filled("NaT") if is_time else values.astype(np.float64).filled(np.nan)
    array = np.asarray(values)
    if array.dtype.kind not in "mM":
        return array
    unit = np.datetime_data(array.dtype)[0]
    if unit == "generic":
        raise Error("times of timedelta64 or datetime64 need a unit: give datetime64[us]")
    if array.dtype.kind == "m":
        array = array + np.datetime64(0, unit)
    # Of several of a unit, as datetime64[10us], one.
    return array.astype(f"datetime64[{unit}]")


def _plain(column, array):
    if array.dtype.kind == "M":
        return np.ascontiguousarray(array).view(np.int64), np.datetime_data(array.dtype)[0]
    try:
        return numbers(array)
    except Error as error:
        raise Error(f"column '{column}': {error}") from error


def _named(rates):
    """Rates as columns by name: a dict as it is, an array's columns as gyro_x, gyro_y, gyro_z."""
    if isinstance(rates, Mapping):
        return dict(rates)
    array = _array(rates)
    if array.ndim == 1:
        return {"gyro": array}
    if array.ndim != 2 or array.shape[1] > len(_AXES):
        raise Error(f"rates of shape {array.shape}: give (n,), (n, 2), (n, 3), or a dict of names")
    return {f"gyro_{axis}": array[:, place] for place, axis in enumerate(_AXES[: array.shape[1]])}
