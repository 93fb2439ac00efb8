"""Takes the temperature drift out of the zero-rate output of MEMS gyroscopes.

>>> import zerorate
>>> calibration = zerorate.fit("chamber.csv")                  # doctest: +SKIP
>>> calibration.predict([20.0, 25.0], time=[0.0, 10.0])        # doctest: +SKIP
>>> open("chamber.table.csv", "w").write(calibration.export("csv"))  # doctest: +SKIP

What is computed is computed by the code of the command ``zerorate``, with the same numbers to the last bit.
"""

from zerorate._fit import fit
from zerorate._logs import read_log
from zerorate._verify import verify
from zerorate._zerorate import Calibration, Error, RejectedLog, allan_deviation

__all__ = ["Calibration", "Error", "RejectedLog", "allan_deviation", "fit", "read_log", "verify"]
