#!/usr/bin/env python3
"""Hold the netlist that a layout starts from against the one that ngspice simulates.

usage: compare_capture.py zero-adjust.net
Reads KiCad's netlist (from capture.py) and zero-adjust.cir, each by itself. Every device of the SPICE netlist must stand on
the board under its schematic's name, with its value, and two of their pins are joined on the board if and only if they are
joined in SPICE. The models of amplifiers and potentiometers are looked at from outside, by their pins.
"""

import re
import sys
from pathlib import Path

from simp_sexp import Sexp

HERE = Path(__file__).resolve().parent
AXES = {"xx": 1, "xy": 2, "xtx": 1, "xty": 2}
SCALES = {"": 1.0, "k": 1e3, "meg": 1e6, "u": 1e-6, "n": 1e-9, "p": 1e-12}
# Pins in the order of the models' .subckt: plus, minus, supply, ground, output; H, L, wiper (by name: U5 has no numbers yet).
# By the packages' sheets and not by capture.py, which has them, too.
QUAD = {"A": "3 2 4 11 1", "B": "5 6 4 11 7", "C": "10 9 4 11 8", "D": "12 13 4 11 14"}
DUAL = {"A": "3 2 8 4 1", "B": "5 6 8 4 7"}
POTENTIOMETER = {"x": "H1 L1 W1", "y": "H2 L2 W2"}
NETWORK = {"A": "1 8", "B": "2 7", "C": "3 6", "D": "4 5"}


def number(text):
    """A value with SPICE's scale letter."""
    digits, scale = re.fullmatch(r"([0-9.]+)([a-z]*)", text.lower()).groups()
    return float(digits) * SCALES[scale]


def read_spice(text):
    """Devices of the flattened board: (path, model or value, nodes). Amplifiers and potentiometers are not entered."""
    top, circuits, inside = [], {}, None
    for line in text.splitlines():
        words = line.lower().split()
        if not words or line.startswith(("*", "+")):
            continue
        if words[0] == ".subckt":
            pins = [word for word in words[2:] if "=" not in word]
            inside = circuits.setdefault(words[1], (pins, []))[1]
        elif words[0] == ".ends":
            inside = None
        else:
            (top if inside is None else inside).append(words)

    def flatten(lines, path, names, parameters):
        local = lambda node: names.get(node, "0" if node == "0" else ".".join(path + (node,)))
        for words in lines:
            arguments = [word for word in words[1:] if "=" not in word]
            given = dict(word.split("=") for word in words[1:] if "=" in word)
            here = path + (words[0],)
            if words[0][0] != "x":
                value = arguments[2].strip("{}") if words[0][0] in "rc" else None
                yield ".".join(here), parameters.get(value, value), [local(node) for node in arguments[:2]]
                continue
            nodes, model = [local(node) for node in arguments[:-1]], arguments[-1]
            if model in ("ad8629", "max5494"):
                yield ".".join(here), model, nodes
            else:
                pins, body = circuits[model]
                yield from flatten(body, here, dict(zip(pins, nodes)), given)

    return list(flatten(top, (), {}, {}))


def on_the_board(path, model, nodes):
    """The part's reference, its pins for the nodes, its value; None for what stands for a supply."""
    *outer, name = path.split(".")
    axis = AXES.get(outer[0]) if outer else None
    if model == "max5494":
        return "U5", POTENTIOMETER[name[2]].split(), None
    if model == "ad8629":
        if name == "xu3" or name == "xu4":
            return f"U{name[2]}", DUAL["AB"[axis - 1]].split(), None
        return f"U{axis}", QUAD[name[-1].upper()].split(), None
    if re.fullmatch("rn1[a-d]", name):
        return f"RN{axis}", NETWORK[name[3].upper()].split(), None
    if re.fullmatch("rn3[ab]", name):
        return "RN3", NETWORK[{1: "AB", 2: "CD"}[axis]["ab".index(name[3])]].split(), None
    if name in ("rvtop", "rvbottom"):
        return f"RV{axis}01", ["1", "2"] if name == "rvtop" else ["2", "3"], None
    if re.fullmatch("[rc][0-9]+", name):
        return f"{name[0].upper()}{axis}{int(name[1:]):02}", ["1", "2"], number(model)
    return None


def read_board(path):
    """Nets as {(reference, pin): net}, and values by reference."""
    netlist = Sexp(Path(path).read_text(encoding="utf-8"))
    nets, values = {}, {}
    first = lambda parent, key: next(item[1] for item in parent if isinstance(item, list) and item[0] == key)
    for component in netlist.search("/export/components/comp"):
        component = component[1] if isinstance(component, tuple) else component
        values[str(first(component, "ref"))] = str(first(component, "value"))
    for net in netlist.search("/export/nets/net"):
        net = net[1] if isinstance(net, tuple) else net
        for node in (item for item in net if isinstance(item, list) and item[0] == "node"):
            nets[str(first(node, "ref")), str(first(node, "pin"))] = str(first(net, "name"))
    return nets, values


def main(path):
    """Compares; the faults are the message."""
    nets, values = read_board(path)
    faults, of_spice, devices, pins = [], {}, 0, 0
    # What SPICE has a source for is a rail of the board.
    for net in ("GND", "5VA", "VREF"):
        of_spice[{"GND": "0", "5VA": "v5a", "VREF": "vref"}[net]] = net
    of_board = {net: node for node, net in of_spice.items()}
    for device, model, nodes in read_spice((HERE / "zero-adjust.cir").read_text(encoding="utf-8")):
        found = on_the_board(device, model, nodes)
        if found is None:
            if device not in ("v5", "vr"):
                faults.append(f"{device}: nothing of the board is known to be this")
            continue
        reference, names, value = found
        devices += 1
        if value is not None and abs(number(values[reference]) / value - 1) > 1e-9:
            faults.append(f"{device}: {model}, but {reference} is {values[reference]}")
        for node, name in zip(nodes, names):
            pins += 1
            net = nets.get((reference, name))
            if of_spice.setdefault(node, net) != net or of_board.setdefault(net, node) != node:
                faults.append(f"{device} ({reference}.{name}): node {node} is on net {net}, "
                              f"where {of_spice[node]} and {of_board.get(net)} belong together")
    if faults:
        sys.exit("\n".join(faults))
    print(f"{devices} devices and {pins} pins of the SPICE netlist are on the board as they are simulated")


if __name__ == "__main__":
    main(sys.argv[1])
