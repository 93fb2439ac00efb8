"""A calibration, drawn."""

import numpy as np

from zerorate._zerorate import Error

# Points of a curve, enough for the page.
_POINTS = 400


def plot(calibration, axes=None):
    """One panel an axis: the averages that were fitted, and the curve through them."""
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise Error("drawing needs matplotlib: pip install matplotlib") from error
    groups = calibration.groups()
    if axes is None:
        _, axes = plt.subplots(len(groups), squeeze=False, sharex=True, layout="constrained")
    axes = np.ravel(axes)
    for panel, (name, group) in zip(axes, groups.items(), strict=True):
        panel.plot(group["temperature"], group["rate"], ".", markersize=2, label="averages")
        span = np.linspace(np.nanmin(group["temperature"]), np.nanmax(group["temperature"]), _POINTS)
        panel.plot(span, calibration.curve(name, span), label="curve")
        panel.set_ylabel(f"{name}, {calibration.rate_units[name]}")
        panel.legend()
    axes[-1].set_xlabel(f"temperature, {calibration.temperature_unit}")
    return axes
