"""The half in Rust."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Format = Literal["px4", "ardupilot", "methodic-configurator", "c", "json", "csv"]
_Column = NDArray[np.float64] | tuple[NDArray[np.int64], str]

class Error(ValueError):
    """What cannot be done, and what to do about it."""

class RejectedLog(Error):
    """A log that can be read and is no good for a calibration."""

    reasons: list[str]
    """Why, a sentence each."""

class Calibration:
    """What was fitted, as ``calibration.json`` keeps it; of one that was just fitted its averages and report too."""

    @staticmethod
    def read(path: str | os.PathLike[str]) -> Calibration:
        """Read the file that `save` or the command wrote. Raises Error where it is none."""

    @staticmethod
    def from_json(text: str) -> Calibration:
        """Read a calibration from the file's text."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``calibration.json``, over what is there."""

    def to_json(self) -> str:
        """The text of ``calibration.json``, to the byte what the command writes."""

    def to_dict(self) -> dict[str, Any]:
        """The same as a dict; docs/schemas/calibration.json says what is in it."""

    @property
    def axes(self) -> list[str]:
        """The axes' names, sorted."""

    @property
    def rate_units(self) -> dict[str, str]:
        """Of each axis the unit of its rates: ``rad/s``, ``dps``, ``m/s^2`` or ``counts``."""

    @property
    def temperature_unit(self) -> str:
        """The unit of every temperature: ``C`` or ``counts``."""

    @property
    def warnings(self) -> list[str]:
        """What to look at, a sentence each."""

    @property
    def notes(self) -> list[str]:
        """What to know of how the log was read, a sentence each."""

    def predict(self, temperature: ArrayLike, time: ArrayLike | None = None) -> dict[str, NDArray[np.float64]]:
        """What a device takes off that is switched on with the first row, and knows nothing of what was before.

        Parameters
        ----------
        temperature : array of shape (n,), in `temperature_unit`
        time : array of shape (n,), seconds from anywhere
            Needed where the model lags behind its temperature.

        Returns
        -------
        dict of arrays of shape (n,)
            Of each axis the drift, in its rate unit; NaN without a temperature. Beyond what was measured the curve is
            held where it is no longer believed. The recording's own drift in time is left out.
        """

    def curve(self, axis: str, temperature: ArrayLike) -> NDArray[np.float64]:
        """The static curve of an axis at temperatures of shape (n,); of a model with a history that for an unknown one."""

    def export(self, format: _Format, *, device_id: int | None = None, instance: int | None = None) -> str:
        """The text of a file of parameters, source code or a table.

        Parameters
        ----------
        format : str
        device_id : int, optional
            The sensor's, for px4 where the log did not tell it.
        instance : int, optional
            Which of the autopilot's sensors it is, from 0, where the log did not tell it.

        Raises
        ------
        Error
            The calibration lacks what the format needs.
        """

    def report_html(self, *, units: str | None = None) -> str:
        """The report as one page that is whole by itself, with rates in ``units`` (``mdps``, ``deg/h``) if given."""

    def groups(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Of each axis the averages that were fitted: ``time_s``, ``temperature``, ``rate``, ``residual``."""

    def plot(self, axes: Any = None) -> NDArray[Any]:
        """Draw each axis with matplotlib: its averages, and the curve. Into ``axes``, one each, or a new figure."""

class Source:
    """Something that is read."""

    @staticmethod
    def file(path: str) -> Source: ...
    @staticmethod
    def bytes(name: str, bytes: bytes) -> Source: ...
    @staticmethod
    def columns(name: str, columns: Sequence[tuple[str, _Column]]) -> Source: ...
    @staticmethod
    def stream(name: str, frame: Any) -> Source: ...

def fit(sources: Sequence[Source], columns: Mapping[str, Any], how: Mapping[str, Any]) -> Calibration: ...
def verify(
    source: Source, calibration: Calibration, columns: Mapping[str, Any], against: Mapping[str, Any]
) -> dict[str, Any]: ...
def read_log(source: Source, columns: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, NDArray[np.float64]]]]]: ...
def allan_deviation(rates: ArrayLike, period_s: float) -> dict[str, Any]:
    """The overlapping Allan deviation of evenly spaced rates at constant temperature.

    Parameters
    ----------
    rates : array of shape (n,), n at least 32
        NaN marks a gap.
    period_s : float
        Time between samples, seconds.

    Returns
    -------
    dict
        Arrays of one shape: ``tau_s``, averaging time, seconds; ``deviation``, ``low`` and ``high``, its confidence bounds,
        in the rates' unit; ``degrees_of_freedom``. And ``coefficients``: angle random walk, bias instability, rate random walk;
        ``filtered_below_s``: the averaging time below which samples resemble their neighbours, as behind a filter, or None;
        ``smooth_trend``: whether the curve rises by a smooth trend, which is no noise.
    """

def command(typed: Sequence[str]) -> int: ...
