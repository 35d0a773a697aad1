"""Hostile clients beside a good one, which must go on receiving at the server's rate: test_hostile.py SERVER"""
import random
import socket
import struct
import sys
import threading
import time

from openigtlink import HEADER, Connection, crc64, pack, pack_command, pack_string, pack_transform, read_status
from server_process import Server

RATE = 20


def closed_by_server(client, seconds=5):
    """True where the server closes the connection; what it sends before is read."""
    client.socket.settimeout(seconds)
    try:
        while client.socket.recv(1 << 16):
            pass
        return True
    except ConnectionError:
        return True
    except TimeoutError:
        return False


def hostile_header(port, header):
    client = Connection(port)
    client.send(header)
    assert closed_by_server(client), f"the server goes on after {header!r}"
    client.close()


def refused(port, data, code):
    """A message that is answered by STATUS; the connection lives on."""
    client = Connection(port)
    client.until("STATUS")
    client.send(data)
    answer = read_status(client.until("STATUS", check=False)["body"])
    assert answer[0] == code, (data[:80], answer)
    client.send(pack("GET_STATUS", "", b""))
    assert read_status(client.until("STATUS", check=False)["body"])[0] == 1
    client.close()


def header_of(kind, size, crc=0, version=1):
    return HEADER.pack(version, kind, b"test", 0, size, crc)


def garbage(port):
    noise = random.Random(1)
    for _ in range(10):
        hostile_header(port, b"\xff" + noise.randbytes(4000))
    hostile_header(port, b"GET / HTTP/1.1\r\nHost: localhost\r\nAccept: */*\r\nUser-Agent: a browser\r\n\r\n")
    for header in (header_of(b"TRANSFORM", 2**63), header_of(b"TRANSFORM", 2**64 - 1), header_of(b"COMMAND", 1 << 20),
                   header_of(b"VIDEO", 1 << 30), header_of(b"TRANS\x07FORM", 48), header_of(b"", 0),
                   header_of(b"TRANSFORM", 48, version=0), header_of(b"TRANSFORM", 48, version=77)):
        hostile_header(port, header)


def wrong_messages(port):
    good = pack_transform("ProbeToReference", [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0])
    refused(port, good[:-1] + b"\x01", 9)  # the checksum
    refused(port, pack("TRANSFORM", "ProbeToReference", b"\0" * 47), 2)
    refused(port, pack("TRANSFORM", "ProbeToReference", b""), 2)
    refused(port, pack("TRANSFORM", "ProbeToReference", struct.pack(">12f", *[float("nan")] * 12)), 10)
    refused(port, pack("STRING", "CMD_1", struct.pack(">HH", 3, 60000) + b"gain"), 2)
    refused(port, pack("COMMAND", "x", struct.pack(">I128sHI", 1, b"x" * 128, 3, 2**32 - 1)), 2)
    refused(port, pack("COMMAND", "x", struct.pack(">HHII", 65535, 0, 0, 0), 2), 2)
    refused(port, pack("COMMAND", "x", struct.pack(">HHII", 12, 65535, 2**32 - 1, 0), 2), 2)
    refused(port, pack("COMMAND", "x", b"\0", 2), 2)
    refused(port, pack("POLYDATA", "x", b"\0" * 100000), 12)  # skipped


def disconnects(port):
    """Fifty clients that leave in the middle of a message."""
    for i in range(50):
        client = Connection(port)
        client.send(pack_transform("NeedleToReference", [1, 0, 0, 0, 1, 0, 0, 0, 1, -24, 0, 0])[:2 * i])
        if i % 2:  # a reset instead of an orderly end
            client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.close()


def flood(port):
    """Thousands of commands, whose answers are never read."""
    client = Connection(port)
    try:
        for i in range(20000):
            client.send(pack_string(f"CMD_{i}", "gain 0"))
    except (ConnectionError, TimeoutError):
        pass
    client.close()


def random_bodies(port):
    """Well-formed headers, right checksums, random bodies."""
    noise = random.Random(2)
    client = Connection(port)
    for _ in range(300):
        kind = noise.choice(["TRANSFORM", "COMMAND", "STRING", "STT_IMAGE", "GET_TRANS", "STATUS", "IMAGE"])
        client.send(pack(kind, noise.choice(["ProbeToReference", "CMD_", "_"]), noise.randbytes(noise.randrange(200)),
                         noise.choice([1, 2, 2])))
    client.send(pack("GET_STATUS", "", b""))
    client.until("STATUS")
    client.close()


class GoodClient(threading.Thread):
    """Receives all the time; keeps when images came."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.client, self.times, self.fault = Connection(port), [], None
        self.running = True

    def run(self):
        try:
            while self.running:
                self.client.until("IMAGE", check=False)
                self.times.append(time.monotonic())
        except Exception as fault:  # the test reports it
            self.fault = fault


def rate_of(times):
    return (len(times) - 1) / (times[-1] - times[0])


def stalled_clients(port):
    """Take nothing, or never complete a message; the server closes them after 5 s."""
    silent = Connection(port)
    silent.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    half = Connection(port)
    half.send(header_of(b"COMMAND", 1000, crc64(b"")) + b"half a body")
    return silent, half


def main():
    with Server(sys.argv[1], "--fps", str(RATE)) as server:
        time.sleep(1)
        before = server.cpu_seconds()
        time.sleep(1)
        print(f"without a client: {1e3 * (server.cpu_seconds() - before):.0f} ms of CPU time in a second, expected less than 100")
        assert server.cpu_seconds() - before < 0.1
        knobs = Connection(server.port)
        knobs.send(pack_command(1, "", "width 160\nlines 32\nplanes 1"))
        knobs.until("RTS_COMMAND")
        knobs.close()
        good = GoodClient(server.port)
        good.start()
        deadline = time.monotonic() + 60
        while len(good.times) < 30 and time.monotonic() < deadline:
            time.sleep(0.1)
        usual = rate_of(good.times[10:])  # the first pictures make tables
        silent, half = stalled_clients(server.port)
        stalled_since = time.monotonic()
        begin = len(good.times)
        for attack in (garbage, wrong_messages, disconnects, random_bodies, flood, disconnects):
            since, seen = time.monotonic(), len(good.times)
            attack(server.port)
            seconds = time.monotonic() - since
            print(f"{attack.__name__}: {seconds:.1f} s, {len(good.times) - seen} images in them")
        # The stalled ones are closed after 5 s, and not before.
        assert closed_by_server(half, 15), "half a message is kept for ever"
        waited = time.monotonic() - stalled_since
        assert 4.9 < waited < 7, waited
        print(f"half a message: disconnected after {waited:.1f} s, expected 5 to 7")
        try:  # its buffers must fill first
            while time.monotonic() - stalled_since < 40:
                silent.send(pack("GET_STATUS", "", b""))
                time.sleep(0.2)
            raise AssertionError("a client that reads nothing is kept")
        except ConnectionError:
            waited = time.monotonic() - stalled_since
            print(f"a client that reads nothing: disconnected after {waited:.1f} s, expected more than 5")
            assert waited > 4.9
        times = good.times[begin:]
        assert good.fault is None, good.fault
        longest = max(b - a for a, b in zip(times, times[1:]))
        print(f"the good client: {rate_of(times):.1f} images a second, alone {usual:.1f}; longest pause {1e3 * longest:.0f} ms")
        assert rate_of(times) > 0.6 * usual and longest < max(1, 10 / usual)
        good.running = False
        assert server.end() == 0


main()
