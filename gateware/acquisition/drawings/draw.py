#!/usr/bin/env python3
"""Draw blocks.svg and timing.svg for ../README.md.

usage: python3 draw.py

Only Python's own library; the same input gives the same files. Coordinates are pixels, y down.
"""

from pathlib import Path
from xml.sax.saxutils import escape

HERE = Path(__file__).resolve().parent
INK, GREY, PAPER = "#1b1b1b", "#707070", "#ffffff"
SPI, CLOCK, MEMORY = "#e8d9f0", "#dbe8f5", "#e3f0db"
NOTE = "#8a3b00"


class Drawing:
    def __init__(self, width, height, title):
        self.width, self.height = width, height
        self.parts = [f"<title>{escape(title)}</title>", f'<rect width="{width}" height="{height}" fill="{PAPER}"/>']

    def line(self, points, colour=INK, width=1.5, arrow=False, dashed=False):
        path = " ".join(f"{x:g},{y:g}" for x, y in points)
        extra = ' marker-end="url(#tip)"' if arrow else ""
        extra += ' stroke-dasharray="5 4"' if dashed else ""
        self.parts.append(
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"{extra}/>')

    def text(self, x, y, text, size=13, anchor="middle", colour=INK, bold=False):
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}" fill="{colour}"'
                          f"{weight}>{escape(text)}</text>")

    def box(self, x, y, width, height, name, lines=(), fill=CLOCK):
        self.parts.append(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="5" fill="{fill}" '
                          f'stroke="{INK}" stroke-width="1.3"/>')
        top = y + height / 2 + 5 - 8 * len(lines)
        self.text(x + width / 2, top, name, 14, bold=True)
        for index, line in enumerate(lines):
            self.text(x + width / 2, top + 16 * (index + 1), line, 12)

    def save(self, name):
        tip = ('<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
               f'orient="auto"><path d="M0,0.5 L8,4 L0,7.5 z" fill="{INK}"/></marker></defs>')
        svg = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" '
               f'width="{self.width}" height="{self.height}" font-family="DejaVu Sans, Helvetica, sans-serif">')
        (HERE / name).write_text("\n".join([svg, tip, *self.parts, "</svg>", ""]), encoding="utf-8")


def blocks():
    d = Drawing(1100, 560, "The acquisition block's modules and what passes between them")
    d.line([(245, 44), (245, 545)], GREY, 1.2, dashed=True)
    d.text(232, 28, "SCK, up to 10 MHz", 13, "end", colour=GREY)
    d.text(258, 28, "clk, 24 MHz", 13, "start", colour=GREY)

    d.box(90, 130, 130, 250, "spi_slave", ["place in the", "transfer,", "bits in, bits", "out, their CRC"], SPI)
    for y, name, to_block in ((165, "SCK", True), (215, "CS", True), (265, "MOSI", True), (335, "MISO", False)):
        d.line([(22, y), (90, y)] if to_block else [(90, y), (22, y)], arrow=True)
        d.text(52, y - 6, name, 12)

    d.box(275, 60, 150, 80, "port_events", ["4 synchronisers,", "edges to pulses"])
    d.box(490, 60, 150, 80, "transfer", ["address, read or", "write, release"])
    d.box(490, 175, 150, 80, "registers", ["RUN, settings,", "STATUS"])
    d.box(275, 285, 150, 80, "reader", ["next word to send;", "crc32"])
    d.box(490, 285, 150, 80, "banks", ["fills, waits, is read;", "numbers, losses"])
    d.box(705, 175, 140, 80, "scan_timer", ["SCAN_PERIOD"])
    d.box(705, 285, 140, 80, "filler", ["scan in the set,", "set is full"])
    d.box(275, 430, 150, 90, "samples", ["2 banks x 512 x 4", "x 16 bit: 16 RAMs"], MEMORY)
    d.box(490, 430, 150, 90, "sums", ["2 banks x 4 x 6", "x 16 bit: 2 RAMs"], MEMORY)
    d.box(705, 430, 140, 90, "accumulator", ["square, and add", "in 16 bit parts"])
    d.box(880, 175, 140, 240, "ad7949_master", ["six frames", "a pass"])
    d.box(880, 440, 140, 80, "decimator", ["a scan's passes", "to samples"])
    d.line([(950, 415), (950, 440)], arrow=True)

    # Crossings.
    d.line([(220, 145), (248, 145), (248, 100), (275, 100)], arrow=True)
    d.text(150, 112, "3 toggles, CS", 12, colour=NOTE)
    d.line([(275, 335), (220, 335)], arrow=True)
    d.text(251, 352, "transmit", 11, colour=NOTE)
    d.line([(220, 215), (490, 215)], arrow=True)
    d.text(345, 208, "head, received, is_sound", 12, colour=NOTE)

    d.line([(425, 100), (490, 100)], arrow=True)
    d.line([(565, 140), (565, 175)], arrow=True)
    d.text(573, 162, "write", 12, "start")
    d.line([(490, 125), (455, 125), (455, 300), (425, 300)], arrow=True)
    d.text(449, 175, "fetch", 12, "end")
    d.line([(640, 90), (665, 90), (665, 310), (640, 310)], arrow=True)
    d.text(672, 118, "read begins, ends,", 12, "start")
    d.text(672, 133, "releases", 12, "start")
    d.line([(490, 240), (438, 240), (438, 318), (425, 318)], arrow=True)
    d.line([(490, 345), (425, 345)], arrow=True)
    d.text(457, 338, "set", 12)
    d.line([(640, 200), (705, 200)], arrow=True)
    d.text(685, 193, "run", 12)
    d.line([(845, 200), (880, 200)], arrow=True)
    d.line([(775, 255), (775, 285)], arrow=True)
    d.text(783, 275, "scan due", 12, "start")
    d.line([(705, 345), (640, 345)], arrow=True)
    d.text(672, 362, "full", 12)
    d.line([(775, 430), (775, 365)], arrow=True)
    d.text(783, 402, "scan done", 12, "start")
    d.line([(880, 460), (845, 460)], arrow=True)
    d.text(862, 452, "14", 11)
    d.line([(705, 460), (640, 460)], arrow=True)
    d.line([(640, 490), (705, 490)], arrow=True)
    d.line([(350, 430), (350, 365)], arrow=True)
    d.line([(530, 430), (530, 398), (390, 398), (390, 365)], arrow=True)
    d.line([(600, 365), (600, 430)], arrow=True)
    d.text(608, 402, "which bank", 12, "start")
    d.line([(880, 508), (862, 508), (862, 538), (350, 538), (350, 520)], arrow=True)
    d.line([(640, 325), (652, 325), (652, 270), (684, 270)], arrow=True)
    d.text(690, 275, "data ready", 12, "start")
    for y, name in ((235, "CNV"), (285, "SCK"), (335, "DIN")):
        d.line([(1020, y), (1084, y)], arrow=True)
        d.text(1050, y - 6, name, 12)
    d.line([(1084, 405), (1020, 405)], arrow=True)
    d.text(1052, 399, "SDO", 12)
    d.save("blocks.svg")


class Waves:
    """Rows of signals on one axis of time."""

    def __init__(self, drawing, x, y, width, until):
        self.d, self.x, self.y, self.scale, self.until = drawing, x, y, width / until, until
        self.row = 0

    def at(self, time):
        return self.x + time * self.scale

    def begin(self, name, height=24, gap=14):
        top = self.y + self.row
        self.row += height + gap
        self.d.text(self.x - 10, top + height / 2 + 5, name, 13, "end")
        return top, top + height

    def level(self, name, changes, first=0):
        """`changes`: the times at which the level turns."""
        high, low = self.begin(name)
        y = high if first else low
        points = [(self.at(0), y)]
        for time in changes:
            points.append((self.at(time), y))
            y = low if y == high else high
            points.append((self.at(time), y))
        points.append((self.at(self.until), y))
        self.d.line(points)
        return high, low

    def words(self, name, spans):
        """`spans`: (from, to, text, fill) of what a bus or a bank holds."""
        high, low = self.begin(name)
        self.d.line([(self.at(0), (high + low) / 2), (self.at(self.until), (high + low) / 2)], GREY, 1)
        for begins, ends, text, fill in spans:
            a, b = self.at(begins), self.at(ends)
            slant = min(4, (b - a) / 4)
            corners = [(a, (high + low) / 2), (a + slant, high), (b - slant, high), (b, (high + low) / 2),
                       (b - slant, low), (a + slant, low)]
            path = " ".join(f"{x:g},{y:g}" for x, y in corners)
            self.d.parts.append(f'<polygon points="{path}" fill="{fill}" stroke="{INK}" stroke-width="1.2"/>')
            self.d.text((a + b) / 2, (high + low) / 2 + 4.5, text, 12)
        return high, low

    def span(self, begins, ends, y, text):
        """An arrow with two ends and what it measures."""
        a, b = self.at(begins), self.at(ends)
        self.d.line([((a + b) / 2, y), (b, y)], NOTE, 1.2)
        self.d.line([((a + b) / 2, y), (a, y)], NOTE, 1.2)
        for x in (a, b):
            self.d.line([(x, y - 4), (x, y + 4)], NOTE, 1.2)
        self.d.text((a + b) / 2, y - 6, text, 12, colour=NOTE)


def timing():
    d = Drawing(1010, 860, "Timing: the head of a burst, a scan of the A/D, and the banks")

    # The head of a burst at 10 MHz; time in SCK periods. The first rise is at 1, a rise each period.
    d.text(20, 30, "A burst begins, SCK at 10 MHz", 15, "start", bold=True)
    w = Waves(d, 150, 70, 830, 22)
    w.level("CS", [0.4], 1)
    clocks = [time for bit in range(21) for time in (bit + 1, bit + 1.5)]
    sck_high, _ = w.level("SCK", clocks)
    for number in (1, 8, 9, 16, 17):
        d.text(w.at(number + 0.25), sck_high - 5, str(number), 11, colour=GREY)
    w.words("MOSI", [(0.5, 8.5, "0x10: read the set", SPI), (8.5, 16.5, "turn-around", SPI)])
    w.words("MISO", [(0.4, 16.5, "0", PAPER), (16.5, 22, "word 0, bit 31 first", CLOCK)])
    # Two to three clocks in the synchroniser, then the pulse; the slowest case, in clocks of 41.7 ns.
    w.level("head_in", [8 + 1.25, 8 + 1.67])
    w.words("transmit", [(8 + 2.92, 22, "word 0", CLOCK)])
    y = 70 + w.row + 12
    w.span(8, 8 + 2.92, y, "7 clocks, 292 ns")
    w.span(8 + 2.92, 16.5, y, "to spare: 558 ns")
    d.line([(w.at(16.5), sck_high), (w.at(16.5), y)], GREY, 1, dashed=True)

    # A scan, microseconds.
    top = 375
    d.text(20, top, "A scan of the A/D", 15, "start", bold=True)
    w = Waves(d, 150, top + 30, 830, 40)
    frame_us, low_us = 6.25, 2.75
    edges = [time for k in range(6) for time in (1 + k * frame_us, 1 + k * frame_us + low_us)]
    w.level("CNV", edges, 1)
    spans = [(1 + k * frame_us, 1 + k * frame_us + low_us) for k in range(6)]
    w.words("SCK", [(a, b, "16 x", PAPER) for a, b in spans])
    w.words("DIN", [(a, b, f"CFG {c}", SPI) for (a, b), c in zip(spans, (0, 1, 2, 3, 0, 0))])
    w.words("SDO", [(a, b, c, f) for (a, b), c, f in zip(
        spans, ("old", "old", "ch 0", "ch 1", "ch 2", "ch 3"), (PAPER, PAPER, *[CLOCK] * 4))])
    w.words("sums", [(b, b + 1.2, "+", MEMORY) for a, b in spans[2:]])
    y = top + 30 + w.row + 14
    w.span(1, 1 + low_us, y, "2.75 us")
    w.span(1 + low_us, 1 + frame_us, y, "3.5 us")
    w.span(1 + frame_us, 1 + 2 * frame_us, y, "6.25 us a frame")

    # Banks; time in sets.
    top = 645
    d.text(20, top, "Sets and banks", 15, "start", bold=True)
    w = Waves(d, 150, top + 30, 830, 6.2)
    fills = [(n, n + 1, f"set {n} fills", PAPER) for n in range(6)]
    w.words("bank 0", [fills[0], (1, 1.2, "", MEMORY), (1.2, 1.6, "read", CLOCK), fills[2], (3, 3.6, "2 waits", MEMORY),
                       (3.6, 4.4, "2 is read", CLOCK), fills[5]])
    w.words("bank 1", [fills[1], (2, 3, "1 waits", MEMORY), fills[3], fills[4], (5, 6.2, "4 waits", MEMORY)])
    w.level("data ready", [1, 1.6, 2, 4.4, 5])
    y = top + 30 + w.row + 12
    for time, lines in ((3, ("2 is full, nobody reads 1:", "1 is lost, 2 waits, 3 fills over 1")),
                        (4, ("", "3 is full while 2 is read:", "3 is lost, 4 fills over it"))):
        x = w.at(time)
        d.line([(x, top + 32), (x, y - 8 + 15 * (lines[0] == ""))], NOTE, 1.2, dashed=True)
        for index, line in enumerate(lines):
            d.text(x + (40 if time == 4 else -60), y + 8 + 16 * index, line, 12, colour=NOTE)
    d.save("timing.svg")


blocks()
timing()
