"""A chamber's controller on pymodbus's server, with a chamber behind it that lags: 2.5 K/min at most, and it overshoots.

Prints its port and serves until it is killed. The registers are those of a preset; faults are what controllers do.
"""

import argparse
import asyncio
import math
import socket
import struct
import time

from pymodbus.client import ModbusTcpClient
from pymodbus.constants import ExcCodes
from pymodbus.datastore import ModbusBaseDeviceContext, ModbusServerContext
from pymodbus.framer import FramerType
from pymodbus.server import ModbusTcpServer

MAPS = {
    # air, set point, mode (or None), form
    "watlow-f4t": (2820, 2782, 2730, "f32"),
    "eurotherm": (1, 2, None, "i16"),
}


class Chamber:
    """The air follows a rate-limited regulator as a damped oscillator."""

    RATE = 2.5 / 60  # K/s
    OMEGA = 2 * math.pi / 240  # 1/s
    DAMPING = 0.6

    def __init__(self, speed):
        self.speed, self.set_point = speed, 25.0
        self.aim = self.air = 25.0
        self.slope = 0.0
        self.then = time.monotonic()

    def now(self):
        left = min((time.monotonic() - self.then) * self.speed, 7200.0)
        self.then = time.monotonic()
        while left > 0:
            step = min(left, 1.0)
            left -= step
            self.aim += max(-self.RATE * step, min(self.RATE * step, self.set_point - self.aim))
            pull = self.OMEGA**2 * (self.aim - self.air) - 2 * self.DAMPING * self.OMEGA * self.slope
            self.slope += pull * step
            self.air += self.slope * step
        return self.air


class Behind:
    """Another controller's chamber, which pymodbus's client asks: a Watlow F4T's registers, as a virtual board has them."""

    def __init__(self, port):
        self.client = ModbusTcpClient("127.0.0.1", port=port)
        self.client.connect()

    def read(self, register):
        low, high = self.client.read_holding_registers(register, count=2, device_id=1).registers
        return struct.unpack(">f", struct.pack(">HH", high, low))[0]

    def now(self):
        return self.read(2820)

    @property
    def set_point(self):
        return self.read(2782)

    @set_point.setter
    def set_point(self, celsius):
        high, low = struct.unpack(">HH", struct.pack(">f", celsius))
        answer = self.client.write_registers(2782, [low, high], device_id=1)
        assert not answer.isError(), answer


class Controller(ModbusBaseDeviceContext):
    def __init__(self, preset, fault, chamber):
        self.actual, self.target, self.mode_register, self.form = MAPS[preset]
        self.fault, self.mode, self.chamber = fault, 10, chamber

    def words(self, celsius):
        if self.form == "f32":
            high, low = struct.unpack(">HH", struct.pack(">f", celsius))
            return [low, high]
        return [round(celsius * 10) & 0xFFFF]

    def getValues(self, func_code, address, count=1):
        table = {}
        air = self.words(math.nan if self.fault == "nan" else self.chamber.now())
        if self.fault == "32767":
            air = [32767]
        for register, words in [(self.actual, air), (self.target, self.words(self.chamber.set_point))]:
            table.update({register + place: word for place, word in enumerate(words)})
        if self.mode_register is not None:
            table[self.mode_register] = self.mode
        wanted = range(address, address + count)
        if any(register not in table for register in wanted):
            return ExcCodes.ILLEGAL_ADDRESS
        return [table[register] for register in wanted]

    def setValues(self, func_code, address, values):
        self.chamber.now()
        if address == self.mode_register:
            self.mode = values[0]
        elif address == self.target and self.fault == "refuse":
            return ExcCodes.ILLEGAL_VALUE
        elif address == self.target and self.fault != "ignore":
            if self.form == "f32":
                self.chamber.set_point = struct.unpack(">f", struct.pack(">HH", values[1], values[0]))[0]
            else:
                self.chamber.set_point = struct.unpack(">h", struct.pack(">H", values[0]))[0] / 10
        elif address != self.target:
            return ExcCodes.ILLEGAL_ADDRESS
        return None


async def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--preset", choices=MAPS, default="watlow-f4t")
    parser.add_argument("--rtu", action="store_true", help="RTU frames, for a serial line that ends here")
    parser.add_argument("--fault", choices=["none", "nan", "32767", "ignore", "refuse"], default="none")
    parser.add_argument("--speed", type=float, default=0.0, help="how many times faster than the clock; 0: it stands still")
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--behind", type=int, help="the port of a virtual board's chamber, which is then the one behind this")
    arguments = parser.parse_args()
    port = arguments.port
    if not port:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
    chamber = Behind(arguments.behind) if arguments.behind else Chamber(arguments.speed)
    context = ModbusServerContext(Controller(arguments.preset, arguments.fault, chamber), single=True)
    framer = FramerType.RTU if arguments.rtu else FramerType.SOCKET
    server = ModbusTcpServer(context, framer=framer, address=("127.0.0.1", port))
    task = asyncio.create_task(server.serve_forever())
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            break
        except OSError:
            await asyncio.sleep(0.02)
    print(port, flush=True)
    await task


asyncio.run(main())
