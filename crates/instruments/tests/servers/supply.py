"""A supply on sinstruments' server: SCPI lines, a load of so many ohms, a current limit that it keeps to.

Prints its port and serves until it is killed.
"""

import argparse
import socket
import types

from sinstruments.simulator import BaseDevice, Server


class Supply(BaseDevice):
    def __init__(self, name, **options):
        self.load_ohm = options.pop("load_ohm")
        behind = options.pop("behind")
        # A virtual board's supply, which is then the one behind this.
        self.behind = socket.create_connection(("127.0.0.1", behind)) if behind else None
        self.volts, self.limit, self.is_on, self.errors = 0.0, 0.1, False, []
        super().__init__(name, **options)

    def given(self):
        return min(self.volts, self.limit * self.load_ohm) if self.is_on else 0.0

    def asked(self, question):
        self.behind.sendall(question + b"\n")
        answer = b""
        while not answer.endswith(b"\n"):
            answer += self.behind.recv(256)
        return answer

    def handle_message(self, message):
        if self.behind and message.strip().upper().startswith((b"VOLT ", b"OUTP ")):
            self.behind.sendall(message.strip() + b"\n")
        elif self.behind and b"(@" in message:
            return self.asked(message.strip())
        header, _, parameter = message.decode().strip().upper().partition(" ")
        answers = {
            "*IDN?": "SINSTRUMENTS,SUPPLY,1,1.4.0",
            "VOLT?": f"{self.volts:.6E}",
            "CURR?": f"{self.limit:.6E}",
            "OUTP?": str(int(self.is_on)),
            "MEAS:VOLT?": f"{self.given():.6E}",
            "MEAS:CURR?": f"{self.given() / self.load_ohm:.6E}",
        }
        if header == "SYST:ERR?":
            return (self.errors.pop(0) if self.errors else '+0,"No error"').encode() + b"\n"
        if header in answers:
            return answers[header].encode() + b"\n"
        try:
            if header == "VOLT" and not 0 <= float(parameter) <= 6:
                self.errors.append('-222,"Data out of range"')
            elif header == "VOLT":
                self.volts = float(parameter)
            elif header == "OUTP":
                self.is_on = parameter in ("ON", "1")
            else:
                self.errors.append('-113,"Undefined header"')
        except ValueError:
            self.errors.append('-104,"Data type error"')
        return None


parser = argparse.ArgumentParser()
parser.add_argument("--load-ohm", type=float, default=1e5)
parser.add_argument("--behind", type=int)
arguments = parser.parse_args()
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
transports = [{"type": "tcp", "url": ["127.0.0.1", port]}]
device = {"class": "Supply", "name": "supply", "load_ohm": arguments.load_ohm, "behind": arguments.behind, "transports": transports}
# A registry is of what is loaded when it is needed.
registry = {"Supply": types.SimpleNamespace(load=lambda: Supply)}
server = Server([device], registry=registry)
for transport in server.devices["supply"].transports:
    transport.start()
print(port, flush=True)
server.serve_forever()
