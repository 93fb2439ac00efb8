#!/usr/bin/env python3
"""The board as a netlist that a layout can start from: every part, every pin that is used, footprints.

usage, as `cargo xtask circuit` calls it (SKiDL in a venv of its own):
    capture.py FOLDER
It writes FOLDER/zero-adjust.net, which KiCad's layout editor imports, after SKiDL's electrical rules check; one fault of that check is a
failure. Values and part numbers come from parts.csv. One axis is one function, called twice.

Pins have numbers where the package's are known for certain; those of U5 have their names instead, and get numbers and a
footprint when the maker's present sheet is at hand.
"""

import csv
import sys
from pathlib import Path

from skidl import ERC, POWER, SKIDL, TEMPLATE, Net, Part, Pin, erc_logger, generate_netlist

HERE = Path(__file__).resolve().parent
KINDS = {"i": Pin.types.INPUT, "o": Pin.types.OUTPUT, "p": Pin.types.PASSIVE, "v": Pin.types.PWRIN, "w": Pin.types.PWROUT,
         "t": Pin.types.TRISTATE, "n": Pin.types.NOCONNECT}
# Name, pins as number:name:kind, footprint.
PARTS = {
    "R": ("1:1:p 2:2:p", "Resistor_SMD:R_0603_1608Metric"),
    "C": ("1:1:p 2:2:p", "Capacitor_SMD:C_0603_1608Metric"),
    "RV": ("1:1:p 2:2:p 3:3:p", "Potentiometer_THT:Potentiometer_Bourns_3296W_Vertical"),
    "LT5400": ("1:A1:p 2:B1:p 3:C1:p 4:D1:p 5:D2:p 6:C2:p 7:B2:p 8:A2:p", "Package_SO:MSOP-8-1EP_3x3mm_P0.65mm_EP1.68x1.88mm"),
    "AD8630": ("1:OA:o 2:MA:i 3:PA:i 4:V+:v 5:PB:i 6:MB:i 7:OB:o 8:OC:o 9:MC:i 10:PC:i 11:V-:v 12:PD:i 13:MD:i 14:OD:o",
               "Package_SO:TSSOP-14_4.4x5mm_P0.65mm"),
    "AD8629": ("1:OA:o 2:MA:i 3:PA:i 4:V-:v 5:PB:i 6:MB:i 7:OB:o 8:V+:v", "Package_SO:SOIC-8_3.9x4.9mm_P1.27mm"),
    "MAX5494": ("VDD:VDD:v VSS:VSS:v GND:GND:v CS:CS:i SCLK:SCLK:i DIN:DIN:i "
                "H1:HA:p W1:WA:p L1:LA:p H2:HB:p W2:WB:p L2:LB:p", "to-be-numbered:TQFN-16"),
    "ADR45": ("2:VIN:v 4:GND:v 6:VOUT:w", "Package_SO:SOIC-8_3.9x4.9mm_P1.27mm"),
    # MSE, as KiCad's library numbers it; power good is open.
    "LT3045": ("1:IN:v 2:IN2:v 3:IN3:v 4:EN:i 5:PG:n 6:ILIM:p 7:PGFB:i 8:SET:p 9:GND:v 10:OUTS:p 11:OUT:w 12:OUT2:p 13:GND2:v",
               "Package_SO:MSOP-12-1EP_3x4mm_P0.65mm_EP1.65x2.85mm"),
    "AD7949": ("1:VDD:v 2:REF:p 3:REFIN:p 4:GND:v 5:GND2:v 6:IN4:i 7:IN5:i 8:IN6:i 9:IN7:i 10:COM:i 11:CNV:i 12:DIN:i 13:SCK:i "
               "14:SDO:o 15:VIO:v 16:IN0:i 17:IN1:i 18:IN2:i 19:IN3:i 20:VDD2:v",
               "Package_CSP:LFCSP-20-1EP_4x4mm_P0.5mm_EP2.1x2.1mm"),
    "74AHCT125": ("1:OE1:i 2:A1:i 3:Y1:t 4:OE2:i 5:A2:i 6:Y2:t 7:GND:v 8:Y3:t 9:A3:i 10:OE3:i 11:Y4:t 12:A4:i 13:OE4:i 14:VCC:v",
                  "Package_SO:TSSOP-14_4.4x5mm_P0.65mm"),
    "header of 4": ("1:1:p 2:2:p 3:3:p 4:4:p", "Connector_PinHeader_2.54mm:PinHeader_1x04_P2.54mm_Vertical"),
    "header of 5": ("1:1:p 2:2:p 3:3:p 4:4:p 5:5:p", "Connector_PinHeader_2.54mm:PinHeader_1x05_P2.54mm_Vertical"),
    "terminal of 2": ("1:1:p 2:2:p", "TerminalBlock:TerminalBlock_bornier-2_P5.08mm"),
    "PMOD": ("1:1:p 2:2:p 3:3:p 4:4:p 5:5:p 6:6:p", "Connector_PinHeader_2.54mm:PinHeader_2x06_P2.54mm_Vertical"),
}


def listed():
    """Value and part number of every reference of the parts list."""
    found = {}
    for row in csv.DictReader(open(HERE / "parts.csv", newline="", encoding="utf-8")):
        words = row["reference"].split()
        if row["quantity"] == "0":
            continue
        if "to" in words:
            letter = words[0][0]
            words = [f"{letter}{number}" for number in range(int(words[0][1:]), int(words[2][1:]) + 1)]
        found.update({word: (row["value"], row["part"]) for word in words})
    return found


class Board:
    """Makes parts by their references, and knows which were made."""

    def __init__(self):
        self.listed, self.made = listed(), {}
        self.templates = {name: self.template(name, pins) for name, (pins, _) in PARTS.items()}

    @staticmethod
    def template(name, pins):
        """A part with no library."""
        pins = [pin.split(":") for pin in pins.split()]
        pins = [Pin(num=number, name=name_, func=KINDS[kind]) for number, name_, kind in pins]
        return Part(name=name, tool=SKIDL, dest=TEMPLATE, ref_prefix="U", pins=pins)

    def part(self, reference, name, **nets):
        """A part of the list, its pins joined to nets by their names."""
        value, number = self.listed[reference]
        made = self.templates[name](ref=reference, tag=reference, value=value or number, footprint=PARTS[name][1])
        made.fields["part"] = number
        self.made[reference] = made
        for pin, net in nets.items():
            net += pin_of(made, pin)
        return made

    def two(self, reference, first, second):
        """A resistor or a capacitor."""
        return self.part(reference, reference[0], **{"1": first, "2": second})


def pin_of(part, name):
    """The pin of that name."""
    wanted = name.replace("Vplus", "V+").replace("Vminus", "V-")
    return next(pin for pin in part.pins if pin.name == wanted)


def amplifier(part, letter, plus, minus, output):
    """One amplifier of a package."""
    for kind, net in (("P", plus), ("M", minus), ("O", output)):
        net += pin_of(part, kind + letter)


def axis(board, number, rails, wiper, rate, centre_at, centre_elements, ad):
    """Input pair, difference amplifier with the adder, centre, low-pass, driver: zero-adjust.svg. `number` 1 is X, 2 is Y."""
    ground, v5a, vref = rails
    name = "XY"[number - 1]
    node = {key: Net(f"{name}_{key}") for key in
            "rate_in a b g wa wb dp dm diff centre c c20 t lp buffered".split()}
    of = lambda kind, index: f"{kind}{number}{index:02}"
    quad = board.part(f"U{number}", "AD8630", Vplus=v5a, Vminus=ground)
    # The gyro's connector.
    board.two(of("R", 16), rate, ground)
    board.two(of("R", 15), rate, node["rate_in"])
    # Input pair.
    amplifier(quad, "A", wiper, node["a"], node["wa"])
    amplifier(quad, "B", node["rate_in"], node["b"], node["wb"])
    board.two(of("R", 1), node["wa"], node["a"])
    board.two(of("R", 2), node["wb"], node["b"])
    board.two(of("R", 3), node["a"], node["g"])
    board.two(of("R", 4), node["g"], node["b"])
    # Difference amplifier.
    board.part(f"RN{number}", "LT5400", A1=node["wa"], A2=node["dp"], B1=node["dp"], B2=node["centre"],
               C1=node["wb"], C2=node["dm"], D1=node["dm"], D2=node["diff"])
    amplifier(quad, "C", node["dp"], node["dm"], node["diff"])
    # The centre; two elements of RN3 and one amplifier of U3 are this axis'.
    network, (upper, lower) = centre_elements
    vref += pin_of(network, f"{upper}1")
    node["c"] += pin_of(network, f"{upper}2"), pin_of(network, f"{lower}1")
    node["c20"] += pin_of(network, f"{lower}2")
    board.two(of("R", 7), node["c20"], ground)
    board.part(of("RV", 1), "RV", **{"1": vref, "2": node["t"], "3": ground})
    board.two(of("R", 8), node["t"], node["c"])
    amplifier(centre_at[0], centre_at[1], node["c"], node["centre"], node["centre"])
    # Low-pass and driver.
    board.two(of("R", 5), node["diff"], node["lp"])
    board.two(of("C", 1), node["lp"], ground)
    amplifier(quad, "D", node["lp"], node["buffered"], node["buffered"])
    board.two(of("R", 6), node["buffered"], ad)
    board.two(of("C", 2), ad, ground)


def temperature(board, number, rails, amplifier_at, temp, ad):
    """Shift, gain and low-pass of a gyro's temperature output."""
    ground, v5a, _ = rails
    s, f, out = (Net(f"T{'XY'[number - 1]}_{key}") for key in ("s", "f", "out"))
    of = lambda kind, index: f"{kind}{number}{index:02}"
    board.two(of("R", 10), temp, s)
    board.two(of("R", 11), v5a, s)
    board.two(of("C", 10), s, ground)
    amplifier(amplifier_at[0], amplifier_at[1], s, f, out)
    board.two(of("R", 12), f, ground)
    board.two(of("R", 13), out, f)
    board.two(of("R", 14), out, ad)
    board.two(of("C", 11), ad, ground)


def digital(board, rails, supplies, ads):
    """The A/D and its way to the FPGA; the processor's way to the potentiometer."""
    ground, v5a, vref = rails
    v3 = Net("3V3", drive=POWER)
    cnv, din, sdo, sdo_in, sck, refin = (Net(name) for name in ("AD_CNV", "AD_DIN", "AD_SDO", "AD_SDO_FPGA", "AD_SCK", "AD_REFIN"))
    tx, zx, ty, zy = ads
    board.part("U9", "AD7949", VDD=v5a, VDD2=v5a, VIO=v3, REF=vref, REFIN=refin, GND=ground, GND2=ground, COM=ground,
               IN0=tx, IN1=zx, IN2=ty, IN3=zy, IN4=ground, IN5=ground, IN6=ground, IN7=ground, CNV=cnv, DIN=din, SCK=sck, SDO=sdo)
    board.two("R304", sdo, sdo_in)
    board.part("J3", "PMOD", **{"1": cnv, "2": din, "3": sdo_in, "4": sck, "5": ground, "6": v3})
    # 3.3 V in, 5 V out; the fourth gate is unused.
    lines = {name: (Net(f"POT_{name}_3V3"), Net(f"POT_{name}")) for name in ("CS", "SCLK", "DIN")}
    (cs, cs5), (sclk, sclk5), (pot_din, pot_din5) = lines.values()
    board.part("U10", "74AHCT125", VCC=v5a, GND=ground, OE1=ground, OE2=ground, OE3=ground, OE4=v5a, A4=ground,
               A1=cs, Y1=cs5, A2=sclk, Y2=sclk5, A3=pot_din, Y3=pot_din5)
    pin_of(board.made["U10"], "Y4").do_erc = False
    board.part("J4", "header of 5", **{"1": cs, "2": sclk, "3": pot_din, "4": ground, "5": supplies["3V3_PROCESSOR"]})
    board.two("R301", cs, supplies["3V3_PROCESSOR"])
    board.two("R302", sclk, ground)
    board.two("R303", pot_din, ground)
    for reference, net in (("C12", v5a), ("C13", v3), ("C14", refin), ("C15", v5a)):
        board.two(reference, net, ground)
    return cs5, sclk5, pot_din5


def main(folder):
    """The whole board."""
    board = Board()
    ground, v5a, vref, v6 = Net("GND", drive=POWER), Net("5VA", drive=POWER), Net("VREF", drive=POWER), Net("6V", drive=POWER)
    supplies = {"3V3_PROCESSOR": Net("3V3_PROCESSOR", drive=POWER)}
    rails = (ground, v5a, vref)
    signals = {name: Net(name) for name in "RATEX RATEY TEMPX TEMPY WX WY ADX ADY ADTX ADTY SET5".split()}
    cs, sclk, din = digital(board, rails, supplies, [signals[name] for name in ("ADTX", "ADX", "ADTY", "ADY")])
    board.part("U5", "MAX5494", VDD=v5a, VSS=ground, GND=ground, CS=cs, SCLK=sclk, DIN=din,
               HA=v5a, WA=signals["WX"], LA=ground, HB=v5a, WB=signals["WY"], LB=ground)
    centre = board.part("U3", "AD8629", Vplus=v5a, Vminus=ground)
    temperatures = board.part("U4", "AD8629", Vplus=v5a, Vminus=ground)
    halves = board.part("RN3", "LT5400")
    axis(board, 1, rails, signals["WX"], signals["RATEX"], (centre, "A"), (halves, "AB"), signals["ADX"])
    axis(board, 2, rails, signals["WY"], signals["RATEY"], (centre, "B"), (halves, "CD"), signals["ADY"])
    temperature(board, 1, rails, (temperatures, "A"), signals["TEMPX"], signals["ADTX"])
    temperature(board, 2, rails, (temperatures, "B"), signals["TEMPY"], signals["ADTY"])
    # Supplies: the rail follows its reference.
    board.part("U6", "ADR45", VIN=v6, GND=ground, VOUT=signals["SET5"])
    board.part("U7", "LT3045", IN=v6, IN2=v6, IN3=v6, EN=v6, PGFB=v6, ILIM=ground, SET=signals["SET5"],
               GND=ground, GND2=ground, OUT=v5a, OUT2=v5a, OUTS=v5a)
    board.part("U8", "ADR45", VIN=v6, GND=ground, VOUT=vref)
    board.part("J5", "terminal of 2", **{"1": v6, "2": ground})
    for axis_number, name in ((1, "X"), (2, "Y")):
        board.part(f"J{axis_number}", "header of 4", **{"1": v5a, "2": ground, "3": signals[f"RATE{name}"], "4": signals[f"TEMP{name}"]})
    for number in range(1, 6):
        board.two(f"C{number}", v5a, ground)
    for reference, net in (("C6", v6), ("C7", v6), ("C8", vref), ("C9", v6), ("C10", v5a), ("C11", vref)):
        board.two(reference, net, ground)
    missing, more = set(board.listed) - set(board.made), set(board.made) - set(board.listed)
    if missing or more:
        sys.exit(f"in parts.csv and not in the capture: {sorted(missing)}; the other way: {sorted(more)}")
    ERC()
    if erc_logger.error.count or erc_logger.warning.count:
        sys.exit(f"the electrical rules check has {erc_logger.error.count} errors and {erc_logger.warning.count} warnings")
    generate_netlist(file_=str(Path(folder) / "zero-adjust.net"))
    print(f"{len(board.made)} parts, no fault in the electrical rules check")


if __name__ == "__main__":
    main(sys.argv[1])
