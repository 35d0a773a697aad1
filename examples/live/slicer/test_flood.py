"""Floods of events that are costly one by one: pictures go on, and SIGTERM is answered: test_flood.py SERVER"""
import sys
import threading
import time

from openigtlink import Connection, pack_command, read_command
from server_process import Server

FLOODS = {
    "gauge": "gauge 18\ngauge 25\n" * 3000,  # 54,000 bytes, each of which would make a needle and build the scene
    "bevel": "bevel 10\nbevel 60\n" * 3000,
    "preset": "preset 0\npreset 4\n" * 3000,
    "cine": "freeze\n" + "cine 1\ncine 2\n" * 3000 + "unfreeze\n",
    "entry": "entry -20 1\nentry -24 0\n" * 2000,
}


class Watcher(threading.Thread):
    """Keeps when images came."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.client, self.times, self.runs = Connection(port), [], True

    def run(self):
        try:
            while self.runs:
                self.client.until("IMAGE")
                self.times.append(time.monotonic())
        except OSError:
            pass

    def pictures(self, count):
        """Waits for so many more."""
        until, deadline = len(self.times) + count, time.monotonic() + 60
        while len(self.times) < until:
            assert time.monotonic() < deadline, "no pictures"
            time.sleep(0.01)

    def longest_pause(self, since):
        times = self.times[since:]
        return max(b - a for a, b in zip(times, times[1:]))


def start(program):
    server = Server(program)
    client = Connection(server.port, 30)
    client.send(pack_command(1, "", "width 160\nlines 32\nplanes 1"))
    client.until("RTS_COMMAND")
    watcher = Watcher(server.port)
    watcher.start()
    watcher.pictures(30)
    return server, client, watcher


def test_pictures(program):
    server, client, watcher = start(program)
    usual = watcher.longest_pause(10)
    for name, text in FLOODS.items():
        since, begin = len(watcher.times) - 1, time.monotonic()
        client.send(pack_command(2, name, text))
        answer = read_command(client.until("RTS_COMMAND"))[3]
        seconds = time.monotonic() - begin
        assert answer["Status"] == "SUCCESS", answer
        watcher.pictures(5)
        pause = watcher.longest_pause(since)
        print(f"{name}: {len(text)} bytes, answered after {1e3 * seconds:.0f} ms; longest pause of the pictures {1e3 * pause:.0f} ms, "
              f"usual {1e3 * usual:.0f} ms")
        assert pause < usual + 0.5 and seconds < 2
    for _ in range(64):  # as much as a client may have waiting
        client.send(pack_command(3, "", FLOODS["gauge"][:18 * 200]))
    since = len(watcher.times) - 1
    watcher.pictures(10)
    print(f"64 commands: longest pause {1e3 * watcher.longest_pause(since):.0f} ms")
    assert watcher.longest_pause(since) < usual + 0.5
    watcher.runs = False
    assert server.end() == 0


def test_end(program):
    server, client, watcher = start(program)
    for _ in range(4):
        client.send(pack_command(2, "", FLOODS["gauge"]))
    begin = time.monotonic()
    assert server.end() == 0
    seconds = time.monotonic() - begin
    print(f"SIGTERM in a flood: ended after {seconds:.2f} s, expected less than 2")
    assert seconds < 2


test_pictures(sys.argv[1])
test_end(sys.argv[1])
