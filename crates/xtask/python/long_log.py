"""Makes a ULog very long, as a log of a whole day is: other messages between those of the sensors.

usage: long_log.py LOG OUT BYTES
"""

import os
import struct
import sys

log, out, length = sys.argv[1], sys.argv[2], int(sys.argv[3])
with open(log, "rb") as file:
    data = file.read()
# A message of another topic, as long as one can be: its subscription is the first after those of the log.
body = struct.pack("<H", 3) + os.urandom(65000)
other = struct.pack("<HB", len(body), ord("D")) + body
head = 16
with open(out, "wb") as file:
    file.write(data[:head])
    messages, at = [], head
    while at < len(data):
        size = struct.unpack_from("<H", data, at)[0] + 3
        messages.append(data[at : at + size])
        at += size
    # Definitions first; then as many of the others as make it so long, evenly.
    first = next(place for place, message in enumerate(messages) if message[2:3] == b"D")
    file.write(b"".join(messages[:first]))
    topic = b"F" + b"debug_array:uint64_t timestamp;uint8_t[64992] data;"
    file.write(struct.pack("<HB", len(topic) - 1, topic[0]) + topic[1:])
    added = struct.pack("<BH", 0, 3) + b"debug_array"
    file.write(struct.pack("<HB", len(added), ord("A")) + added)
    others = (length - len(data)) // len(other)
    step = max(1, (len(messages) - first) // others)
    for place, message in enumerate(messages[first:]):
        file.write(message)
        if place % step == 0 and others > 0:
            file.write(other)
            others -= 1
    file.write(other * others)
