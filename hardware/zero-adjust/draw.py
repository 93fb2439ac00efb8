#!/usr/bin/env python3
"""Draw zero-adjust.svg: the zero-adjust circuit of axis X, its temperature channel and the supplies.

usage, in this folder:
    python3 -m venv ../../target/venv-schematic
    ../../target/venv-schematic/bin/pip install -r requirements.txt
    ../../target/venv-schematic/bin/python draw.py

Values come from parts.csv, which `cargo xtask circuit` holds against the netlist. The same input gives the same file.
Coordinates are schemdraw's units, x to the right, y up; two units are half an inch.
"""

import csv
from pathlib import Path

import schemdraw
import schemdraw.elements as elm

HERE = Path(__file__).resolve().parent
NOTE = "#1f4e79"
SMALL = 11
# From an amplifier's inputs, 0.625 above and below its middle, to its output.
HALF = 0.625
LENGTH = 2.165


def read_values():
    """The text beside each reference: value, and tolerance where it is better than 2 %."""
    values = {}
    with open(HERE / "parts.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            tolerance = row["tolerance"]
            tight = tolerance.endswith("%") and float(tolerance.split()[0]) < 1.0 or row["value"] == "47n"
            for reference in row["reference"].split():
                text = row["value"].replace("meg", "M")
                values.setdefault(reference, f"{text} {tolerance}" if tight else text)
    return values


class Sheet:
    """A drawing on absolute coordinates."""

    def __init__(self, drawing, values):
        self.drawing = drawing
        self.values = values

    def wire(self, *points, dot_at=()):
        """A line through the points."""
        for start, end in zip(points, points[1:]):
            self.drawing += elm.Line().at(start).to(end)
        for point in dot_at:
            self.dot(point)

    def dot(self, point):
        """A junction."""
        self.drawing += elm.Dot().at(point)

    def part(self, element, start, end, reference, side, text=None):
        """A part with two leads; `side` is where its label stands: top, bottom, left, right of the sheet."""
        value = self.values[reference] if text is None else text
        self.drawing += element.at(start).to(end)
        (x0, y0), (x1, y1) = start, end
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        place = {
            "top": ((x, y + 0.6), ("center", "center"), f"{reference}  {value}"),
            "bottom": ((x, y - 0.68), ("center", "center"), f"{reference}  {value}"),
            "left": ((x - 0.45, y), ("right", "center"), f"{reference}\n{value}"),
            "right": ((x + 0.45, y), ("left", "center"), f"{reference}\n{value}"),
        }
        at, align, label = place[side]
        self.text(at, label, align=align)

    def resistor(self, start, end, reference, side, text=None):
        """A resistor."""
        self.part(elm.ResistorIEC(), start, end, reference, side, text)

    def capacitor_to_ground(self, top, reference, side="right"):
        """A capacitor from a node down to ground."""
        bottom = (top[0], top[1] - 2.0)
        self.part(elm.Capacitor(), top, bottom, reference, side)
        self.ground(bottom)

    def ground(self, point):
        """The analogue ground."""
        self.drawing += elm.Ground().at(point)

    def rail(self, point, name):
        """A supply or a reference, from above."""
        self.drawing += elm.Vdd().at(point)
        self.text((point[0], point[1] + 0.95), name, align=("center", "center"))

    def amplifier(self, left, middle, name, plus_on_top):
        """An amplifier with its inputs at x = left; gives plus, minus and output."""
        # As it comes, minus is above; flipped, plus is. It is placed by the input that is above.
        if plus_on_top:
            self.drawing += elm.Opamp().flip().at((left, middle + HALF)).anchor("in2").right()
        else:
            self.drawing += elm.Opamp().at((left, middle + HALF)).anchor("in1").right()
        self.text((left + 0.95, middle), name, align=("center", "center"))
        top, bottom, output = (left, middle + HALF), (left, middle - HALF), (left + LENGTH, middle)
        return (top, bottom, output) if plus_on_top else (bottom, top, output)

    def text(self, point, text, align=("left", "center"), size=SMALL, color="black"):
        """A piece of text, centred on the point or beside it; schemdraw sets it too high."""
        lower = 0.2 if "\n" in text else 0.1
        self.drawing += elm.Label().at((point[0], point[1] - lower)).label(text, loc="center", halign=align[0], valign=align[1],
                                                    fontsize=size, color=color, ofst=(0, 0))

    def note(self, point, text, align=("left", "center"), size=SMALL):
        """What a stage is for."""
        self.text(point, text, align, size, NOTE)

    def port(self, point, name, to_left):
        """Where a signal comes from or goes to."""
        self.drawing += elm.Dot(open=True).at(point)
        shift, align = (-0.25, "right") if to_left else (0.25, "left")
        self.text((point[0] + shift, point[1]), name, align=(align, "center"))

    def box(self, corner, width, height, text):
        """An integrated circuit that needs no inside."""
        x, y = corner
        self.wire((x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y))
        self.text((x + width / 2, y + height / 2), text, align=("center", "center"))


def axis(sheet):
    """Potentiometer, input pair, difference amplifier with the adder, low-pass, driver."""
    # Potentiometer.
    pot_x, wiper_y = 1.2, 12.625
    sheet.drawing += elm.ResistorIEC().at((pot_x, wiper_y + 1.5)).to((pot_x, wiper_y - 1.5))
    sheet.rail((pot_x, wiper_y + 1.5), "5VA")
    sheet.ground((pot_x, wiper_y - 1.5))
    sheet.text((pot_x - 0.45, wiper_y), "U5A\nMAX5494\n10k", align=("right", "center"))
    sheet.text((pot_x + 0.3, wiper_y + 1.2), "H", size=9)
    sheet.text((pot_x + 0.3, wiper_y - 1.2), "L", size=9)
    sheet.drawing += elm.Line(arrow="<-").at((pot_x + 0.25, wiper_y)).to((2.6, wiper_y))
    sheet.text((pot_x + 0.85, wiper_y + 0.4), "W", size=9, align=("center", "center"))
    sheet.note((pot_x + 0.9, wiper_y - 0.45), "5 V N/1023")

    # Input pair: one resistor, R103 + R104, sets the gain.
    plus, minus, top_out = sheet.amplifier(5.6, 12.0, "U1A", plus_on_top=True)
    sheet.wire((2.6, wiper_y), plus)
    a, b = (4.9, 9.7), (4.9, 4.8)
    sheet.wire(minus, (a[0], minus[1]), a)
    sheet.resistor(a, (8.6, a[1]), "R101", "top")
    sheet.wire((8.6, a[1]), (8.6, 12.0), dot_at=[(8.6, 12.0), a])
    sheet.wire(top_out, (8.9, 12.0))
    sheet.resistor(a, (a[0], 7.4), "R103", "right")
    sheet.resistor((a[0], 7.4), b, "R104", "right", "2.49k 0.1 %\n(Y: R204 1.43k)")
    plus, minus, low_out = sheet.amplifier(5.6, 2.8, "U1B", plus_on_top=False)
    sheet.wire(minus, (b[0], minus[1]), b)
    sheet.resistor(b, (8.6, b[1]), "R102", "bottom")
    sheet.wire((8.6, b[1]), (8.6, 2.8), dot_at=[(8.6, 2.8), b])
    sheet.wire(low_out, (8.9, 2.8))
    sheet.port((1.2, plus[1]), "RATE X", to_left=True)
    sheet.wire((1.2, plus[1]), plus)
    sheet.note((1.1, plus[1] - 0.75), "gyro: 2.5 V +\n6 mV/(deg/s)")
    sheet.note((4.3, 7.4), "gain\n1 + 2 R101/(R103+R104)\nX 1.5990\nY 1.6186", align=("right", "center"))

    # Difference amplifier; RN1b is the adder.
    sum_x, plus_y, minus_y = 12.7, 7.4 + HALF, 7.4 - HALF
    sheet.resistor((8.9, 12.0), (sum_x, 12.0), "RN1a", "top", sheet.values["RN1"].split()[0])
    sheet.wire((sum_x, 12.0), (sum_x, plus_y), (13.6, plus_y), dot_at=[(sum_x, 12.0)])
    sheet.resistor((8.9, 2.8), (sum_x, 2.8), "RN1c", "bottom", sheet.values["RN1"].split()[0])
    sheet.wire((sum_x, 2.8), (sum_x, minus_y), (13.6, minus_y), dot_at=[(sum_x, 4.9)])
    plus, minus, out = sheet.amplifier(13.6, 7.4, "U1C", plus_on_top=True)
    sheet.resistor((sum_x, 4.9), (16.4, 4.9), "RN1d", "bottom", sheet.values["RN1"].split()[0])
    sheet.wire((16.4, 4.9), (16.4, 7.4), dot_at=[(16.4, 7.4)])
    sheet.wire(out, (17.0, 7.4))
    sheet.note((13.2, 9.6), "wiper on +, rate on -:\nhere the sign is turned")
    sheet.note((12.4, 7.4), "difference\namplifier,\ngain 1", align=("right", "center"))

    # Low-pass and driver.
    sheet.resistor((17.0, 7.4), (20.4, 7.4), "R105", "top")
    sheet.wire((20.4, 7.4), (21.4, 7.4), dot_at=[(20.4, 7.4)])
    sheet.capacitor_to_ground((20.4, 7.4), "C101", side="left")
    sheet.note((18.3, 4.6), "low-pass 40 Hz", align=("center", "center"))
    plus, minus, out = sheet.amplifier(21.4, 7.4 + HALF, "U1D", plus_on_top=False)
    sheet.wire(minus, (21.0, minus[1]), (21.0, 9.7), (24.2, 9.7), (24.2, out[1]), dot_at=[(24.2, out[1])])
    sheet.wire(out, (24.5, out[1]))
    sheet.resistor((24.5, out[1]), (27.3, out[1]), "R106", "top")
    sheet.wire((27.3, out[1]), (28.8, out[1]), dot_at=[(27.6, out[1])])
    sheet.capacitor_to_ground((27.6, out[1]), "C102")
    sheet.port((28.8, out[1]), "ZERO-RATE X\nto the A/D", to_left=False)
    sheet.note((22.0, 12.3), "at the A/D:\n2.05 V + 1.599 (wiper - rate)\n1 tap: +31.26 counts (Y +31.64)\n1 deg/s: -38.4 counts",
               align=("left", "center"))


def centre(sheet):
    """Half of the A/D's reference and 2 mV, trimmed, buffered."""
    x, top, node_y = 6.2, 21.6, 18.9
    sheet.rail((x, top), "VREF 4.096 V")
    half = sheet.values["RN3"].split()[0]
    sheet.resistor((x, top), (x, node_y), "RN3a", "right", half)
    sheet.resistor((x, node_y), (x, 16.9), "RN3b", "right", half)
    sheet.resistor((x, 16.9), (x, 15.1), "R107", "right")
    sheet.ground((x, 15.1))
    # Trimmer: a 10 kOhm part, two halves in the list.
    trim_x = 1.2
    sheet.rail((trim_x, node_y + 1.5), "VREF")
    sheet.drawing += elm.ResistorIEC().at((trim_x, node_y + 1.5)).to((trim_x, node_y - 1.5))
    sheet.ground((trim_x, node_y - 1.5))
    sheet.drawing += elm.Line(arrow="<-").at((trim_x + 0.25, node_y)).to((2.4, node_y))
    sheet.text((trim_x - 0.45, node_y), "RV101\n10k\n25 turns", align=("right", "center"))
    sheet.resistor((2.4, node_y), (5.4, node_y), "R108", "top")
    sheet.wire((5.4, node_y), (x, node_y), dot_at=[(x, node_y)])
    plus, minus, out = sheet.amplifier(8.4, node_y + HALF, "U3A", plus_on_top=False)
    sheet.wire((x, node_y), plus)
    sheet.wire(minus, (8.0, minus[1]), (8.0, 21.2), (11.2, 21.2), (11.2, out[1]), dot_at=[(11.2, out[1])])
    sheet.wire(out, (12.7, out[1]), (12.7, 16.2))
    sheet.resistor((12.7, 16.2), (12.7, 13.2), "RN1b", "right", sheet.values["RN1"].split()[0])
    sheet.wire((12.7, 13.2), (12.7, 12.0))
    sheet.note((13.15, 19.5), "CENTRE 2.05 V = 8200 counts", align=("left", "center"))
    sheet.note((14.9, 14.7), "the adder: adds the centre, once", align=("left", "center"))
    sheet.note((2.3, 18.2), "trims +-81 counts")


def temperature(sheet):
    """Shift, gain and low-pass of the gyro's temperature output."""
    y = -4.2
    sheet.port((1.2, y), "TEMP X", to_left=True)
    sheet.note((1.1, y - 1.0), "gyro:\n2.5 V at 25 C\n9 mV/C")
    sheet.wire((1.2, y), (1.8, y))
    sheet.resistor((1.8, y), (5.0, y), "R110", "top")
    sheet.wire((5.0, y), (8.4, y), dot_at=[(5.0, y), (6.4, y)])
    sheet.capacitor_to_ground((5.0, y), "C110")
    sheet.rail((6.4, y + 2.6), "5VA")
    sheet.resistor((6.4, y + 2.6), (6.4, y), "R111", "right")
    _, minus, out = sheet.amplifier(8.4, y - HALF, "U4A", plus_on_top=True)
    corner = (7.9, -7.3)
    sheet.wire(minus, (corner[0], minus[1]), corner, dot_at=[corner])
    sheet.resistor(corner, (11.4, corner[1]), "R113", "bottom")
    sheet.wire((11.4, corner[1]), (11.4, out[1]), dot_at=[(11.4, out[1])])
    sheet.resistor(corner, (corner[0], -9.6), "R112", "left")
    sheet.ground((corner[0], -9.6))
    sheet.wire(out, (11.7, out[1]))
    sheet.resistor((11.7, out[1]), (14.5, out[1]), "R114", "top")
    sheet.wire((14.5, out[1]), (15.5, out[1]), dot_at=[(14.8, out[1])])
    sheet.capacitor_to_ground((14.8, out[1]), "C111")
    sheet.port((15.5, out[1]), "TEMPERATURE X\nto the A/D", to_left=False)
    sheet.note((9.3, -2.2), "2.6775 V at 25 C, 8.5 mV/C\n34 counts a degree, 8500 at -40 C", align=("left", "center"))


def supplies(sheet):
    """The 5 V rail that follows a reference, and the A/D's reference."""
    left, top = 21.4, -2.4
    sheet.port((left, top - 0.7), "6 V", to_left=True)
    sheet.box((left + 4.6, top - 1.4), 3.0, 1.4, "")
    sheet.text((left + 6.1, top + 0.4), "U7 LT3045", align=("center", "center"))
    sheet.wire((left, top - 0.7), (left + 4.6, top - 0.7), dot_at=[(left + 0.6, top - 0.7)])
    sheet.text((left + 4.75, top - 0.7), "IN", size=9)
    sheet.text((left + 7.45, top - 0.7), "OUT", size=9, align=("right", "center"))
    sheet.text((left + 6.1, top - 1.12), "SET", size=9, align=("center", "center"))
    sheet.wire((left + 7.6, top - 0.7), (left + 8.8, top - 0.7))
    sheet.port((left + 8.8, top - 0.7), "5VA  5.000 V", to_left=False)
    sheet.box((left + 1.4, top - 3.9), 3.2, 1.4, "U6 ADR4550B")
    sheet.wire((left + 0.6, top - 0.7), (left + 0.6, top - 3.2), (left + 1.4, top - 3.2), dot_at=[(left + 0.6, top - 3.2)])
    sheet.wire((left + 4.6, top - 3.2), (left + 6.1, top - 3.2), (left + 6.1, top - 1.4))
    sheet.box((left + 1.4, top - 6.4), 3.2, 1.4, "U8 ADR4540B")
    sheet.wire((left + 0.6, top - 3.2), (left + 0.6, top - 5.7), (left + 1.4, top - 5.7))
    sheet.wire((left + 4.6, top - 5.7), (left + 8.8, top - 5.7))
    sheet.port((left + 8.8, top - 5.7), "VREF  4.096 V", to_left=False)
    sheet.note((left + 6.4, top - 2.4), "the rail follows the reference", align=("left", "center"))
    sheet.note((left + 4.8, top - 6.2), "also the A/D's reference", align=("left", "center"))


def words(sheet):
    """Frame, title, and what is not drawn."""
    sheet.wire((-2.8, -11.2), (33.8, -11.2), (33.8, 26.2), (-2.8, 26.2), (-2.8, -11.2))
    sheet.wire((-2.8, 0.5), (33.8, 0.5))
    sheet.wire((19.4, 0.5), (19.4, -11.2))
    sheet.text((-2.2, 25.2), "Zero-adjust circuit, axis X", size=22)
    sheet.text((-2.2, 24.0), "Axis Y is the same, with R2xx, C2xx, RV201, U2, RN2, U3B, U4B, U5B. One value differs: R204 is 1.43k.", size=12)
    sheet.note((16.0, 22.6), "U1, U2 AD8630; U3, U4 AD8629: from 5VA and ground, 100n at each.\n"
               "RN1, RN2, RN3: LT5400B-1, four matched resistors of 10k each; RN3c, RN3d halve VREF for Y.\n"
               "U5 MAX5494 from 5VA; its SPI goes to the processor. C9 to C11, 10u, at U7 and U8.",
               align=("left", "center"))
    sheet.text((-2.2, -0.3), "Temperature channel, axis X", size=14)
    sheet.text((20.0, -0.3), "Supplies", size=14)


def main():
    """Draws everything."""
    schemdraw.use("svg")
    with schemdraw.Drawing(show=False, fontsize=SMALL, lw=1.4, font="DejaVu Sans, Verdana, Arial, sans-serif") as drawing:
        drawing.config(inches_per_unit=0.42, bgcolor="white", margin=0.3)
        sheet = Sheet(drawing, read_values())
        axis(sheet)
        centre(sheet)
        temperature(sheet)
        supplies(sheet)
        words(sheet)
    svg = drawing.get_imagedata("svg").decode()
    (HERE / "zero-adjust.svg").write_text(svg.rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
