"""Every event, typical and at both ends of its range, and beyond; in files and by commands: test_commands.py SERVER"""
import re
import subprocess
import sys

from openigtlink import Connection, pack, pack_command, pack_string, pack_transform, read_command, read_image, read_status, read_string
from server_process import Server

IDENTITY = [1, 0, 0, 0, 1, 0, 0, 0, 1]
NUMBER = r"(-?[\d.]+(?:e[+-]?\d+)?)"

# How many numbers an event takes, where it is not one; names with examples are valid in themselves.
LISTS = {"slide": 2, "entry": 2, "measure": 4, "area": 8, "hold_probe": 12, "hold_needle": 12, "freeze": 0, "unfreeze": 0, "release": 0}


def events_of(text):
    """Name, range and step of each number, of all events that --help lists; 0: no steps."""
    events = {}
    for line in text.splitlines():
        found = re.match(r"([a-z_]+): ", line)
        if not found:
            continue
        name = found.group(1)
        ranges = [tuple(map(float, pair)) for pair in re.findall(NUMBER + " to " + NUMBER, line.split(" (")[-1])]
        count = LISTS.get(name, len(ranges))
        assert (count == 0) == (not ranges), line
        step = re.search(r", in steps of (\d+)\)", line)
        steps = [float(step.group(1)) if step else 0] if len(ranges) == 1 else [1, 0] if name == "slider" else [0] * len(ranges)
        ranges = [(low, high, each) for (low, high), each in zip(ranges, steps)]
        events[name] = ranges * count if len(ranges) == 1 else ranges
    return events


class Commands:
    def __init__(self, port):
        self.client, self.number = Connection(port, 60), 0

    def send(self, text):
        """Status and sentence of the answer."""
        self.number += 1
        self.client.send(pack_command(self.number, "", text))
        while True:
            number, _, _, metadata = read_command(self.client.until("RTS_COMMAND", check=False))
            if number == self.number:
                return metadata["Status"], metadata.get("Message", metadata.get("Error"))

    def accepted(self, text):
        status, sentence = self.send(text)
        assert status == "SUCCESS", (text, sentence)

    def refused(self, text, why):
        status, sentence = self.send(text)
        assert status == "FAIL" and re.search(why, sentence), (text, status, sentence)


def line_of(name, values):
    return " ".join([name, *(f"{value:.9g}" for value in values)])


def test_events(commands, events):
    small = "width 64\nlines 24\nplanes 1\ndepth 40\nfrequency 5\ncompound 1\nunfreeze"  # quick, whatever is at its end
    for name, ranges in events.items():
        commands.accepted(small)
        if name == "interval":
            commands.refused("interval 4", "the server's clock sets it")
            continue
        if name == "cine":  # of frozen pictures: 0 to 31 of as many
            for _ in range(33):
                commands.client.until("IMAGE", check=False)
            commands.refused("cine 0", "send freeze first")
            small = small.replace("\nunfreeze", "\nfreeze")
            commands.accepted(small)
        if name == "case":  # the last one is opened here, and the first one again
            commands.refused("case", r"takes 1 number: .*; 0 Nerve block phantom, 1 Neck: carotid, across")
        if name.startswith("hold_"):
            commands.accepted(line_of(name, IDENTITY + [0, 0, 20]))
            commands.accepted(line_of(name, IDENTITY + [1e5, -1e5, 1e5]))
            commands.refused(line_of(name, IDENTITY + [0, 0, 1e6]), "is not -100000 to 100000 mm")
            commands.refused(line_of(name, [1] * 12), "do not form a rigid transform")
            commands.accepted("release")
            continue
        commands.accepted(line_of(name, [low + (0.5 * (high - low) if step == 0 else step * (0.5 * (high - low) // step)) for low, high, step in ranges]))
        commands.client.until("IMAGE", check=False)
        for end in (0, 1):
            commands.accepted(line_of(name, [ends[end] for ends in ranges]))
            commands.client.until("IMAGE", check=False)
        commands.accepted(small)
        for beyond in ([ends[0] for ends in ranges[:-1]] + [high + 1 for _, high, _ in ranges[-1:]],
                       [low - 1 for low, *_ in ranges[:1]] + [ends[1] for ends in ranges[1:]]):
            if beyond:
                commands.refused(line_of(name, beyond), f"{name}: .* is not .* to ")
        commands.refused(line_of(name, [0] * (len(ranges) + 1)), f"{name} takes ")
        small = small.replace("\nfreeze", "\nunfreeze")
        if name == "patient":
            commands.accepted("patient 0\ncase 0")
    print(f"{len(events)} events: typical, at both ends and beyond")


def test_us_parameters(commands):
    """SetUsParameter: typical, extreme, beyond."""
    parameters = {"DepthMm": (40, 240, 1e9), "FrequencyMhz": (7.5, 15, 99), "DynRangeDb": (70, 120, 0),
                  "GainPercent": (50, 100, 1000), "FocusDepthPercent": (50, 100, 1e6)}
    for name, (typical, extreme, beyond) in parameters.items():
        xml = '<Command Name="SetUsParameter"><Parameter Name="%s" Value="%g"/></Command>'
        commands.accepted(xml % (name, typical))
        commands.accepted(xml % (name, extreme))
        commands.refused(xml % (name, beyond), " is not .* to ")
    commands.refused('<Command Name="SetUsParameter"><Parameter Name="Power" Value="1"/></Command>', "there is no parameter 'Power'")


def test_whole_numbers(commands):
    for event, sentence in (("case 3.5", "case: 3.5 is not a whole number from 0 to "), ("mode 2.6", "; 0 B, 1 M, 2 Colour"), ("patient 7.4", "whole number"),
                            ("labels 0.5", "labels: 0.5 is not a whole number from 0 to 1; 0 Off, 1 On"), ("planes 2", "planes: 2 is not 1 to 7, in steps of 2"),
                            ("slider 7.5 3", r"slider: 7.5 is not a whole number from 0 to 7$"), ("slider 3 3.5", None), ("planes 3", None)):
        commands.accepted(event) if sentence is None else commands.refused(event, sentence)


def test_all_or_nothing(commands):
    commands.accepted("gain 3")
    commands.refused("gain 7\ndepth 1e+09", r"depth: 1e\+09 is not 10 to 240 mm")
    commands.refused("gian 6", "there is no event 'gian'")


def test_without_effect(commands):
    """What would do nothing now is refused, and with it the whole command; the sentence says what to do first."""
    commands.accepted("unfreeze\nrelease\ngain 3")
    commands.refused("gain 7\ncine 3", "cine: earlier frames are shown while frozen; send freeze first")
    commands.accepted("freeze\ncine 3")
    commands.accepted("unfreeze")
    commands.accepted(line_of("hold_probe", IDENTITY + [0, 0, 0]))
    commands.refused("slide -2 0", "slide: a tracker holds the probe; send release first")
    commands.accepted("release\nslide -2 0")
    commands.accepted("advance -20\n" * 5 + "advance 75\nadvance 20")
    commands.refused("advance 1", "advance: that is the end of its way; it can only go back")
    commands.accepted("advance -20")


def test_cases(commands):
    """Another body with its own probe: a sector, whose image has another size and place; then the first one again."""
    def image():
        commands.client.until("IMAGE", check=False)
        return read_image(commands.client.until("IMAGE", check=False)["body"])

    commands.accepted("case 0\nwidth 160\nlines 48")
    first = image()
    commands.accepted("case 14")  # gallbladder, convex
    size, _, gray = image()
    assert first[0][0] == 160 and size[0] == 160 and size[1] < 0.85 * size[0] < first[0][1], (first[0], size)
    corner, middle = gray[0], gray[size[0] // 2 + size[0] * (size[1] // 3)]
    assert corner == 0 and max(gray) > 60, (corner, middle)
    assert sum(g > 8 for g in gray) > 0.3 * len(gray)
    commands.accepted("case 0")
    assert image()[0] == first[0]


def test_messages(client):
    """The messages that are no commands."""
    far = pack_transform("ProbeToReference", IDENTITY + [0, 0, 2e5])
    client.send(far)
    code, _, sentence = read_status(client.until("STATUS")["body"])
    while "running" in sentence or sentence == "starting":  # the greeting
        code, _, sentence = read_status(client.until("STATUS")["body"])
    assert code == 10 and "is not -100000 to 100000 mm" in sentence, (code, sentence)
    client.send(pack_string("CMD_1", "depth 1e+09"))
    assert 'Status="FAIL"' in read_string(client.until("STRING")["body"])
    for kind in ("GET_IMAGE", "GET_TRANS"):
        client.send(pack(kind, "", b""))
        client.until({"GET_IMAGE": "IMAGE", "GET_TRANS": "TRANSFORM"}[kind])


def main():
    help_text = subprocess.run([sys.argv[1], "--help"], check=True, capture_output=True, text=True).stdout
    events = events_of(help_text)
    assert {"gain", "slide", "slider", "area", "hold_probe", "release"} <= set(events), events
    with Server(sys.argv[1], "--fps", "120") as server:
        commands = Commands(server.port)
        test_events(commands, events)
        commands.accepted("release\nunfreeze\nwidth 64\nlines 24\nplanes 1\nmode 0")
        test_us_parameters(commands)
        test_whole_numbers(commands)
        test_all_or_nothing(commands)
        test_without_effect(commands)
        test_cases(commands)
        test_messages(commands.client)
        assert server.end() == 0


main()
