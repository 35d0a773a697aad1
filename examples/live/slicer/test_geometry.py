"""A small ball at a known place is where the image says it is, and the latency is that of a client: test_geometry.py SERVER CLIENT"""
import math
import pathlib
import subprocess
import sys

import numpy as np

from openigtlink import Connection, pack_command, pack_transform, read_image
from server_process import Server

BALL, RADIUS = np.array([2.0, 1.0, 20.0]), 0.3  # mm in the world; wider than the distance of the lines


def write_ball(path):
    """An octahedron, divided four times: outwards oriented. A second ball lies below the picture."""
    points = [np.array(p, float) for p in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(4):
        middle, divided = {}, []

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(points)
                points.append((points[a] + points[b]) / np.linalg.norm(points[a] + points[b]))
            return middle[key]

        for a, b, c in faces:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            divided += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = divided
    lines = []
    for number, centre in enumerate((BALL, BALL + [0, 0, 60])):
        lines += [f"o ball{number}", "usemtl steel"]  # smooth: a rough ball echoes from anywhere on it
        lines += ["v %.9g %.9g %.9g" % tuple(centre + RADIUS * p) for p in points]
        lines += ["f %d %d %d" % tuple(number * len(points) + i + 1 for i in face) for face in faces]
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def probe_columns(turn, tilt, lateral, depth):
    """A probe that sees the ball at (lateral, depth) of its picture: turned about its axis, tilted in the slice."""
    x = np.array([math.cos(turn) * math.cos(tilt), math.sin(turn) * math.cos(tilt), -math.sin(tilt)])
    z = np.array([math.cos(turn) * math.sin(tilt), math.sin(turn) * math.sin(tilt), math.cos(tilt)])
    origin = BALL - lateral * x - depth * z
    return np.concatenate([x, np.cross(z, x), z, origin])


def level_of(gray):
    """Decibels below white of gray values, by the tone curve of the scanner: presets::clinical_grey over 85 dB."""
    reject, shoulder, softness = 0.35, 0.55, 0.06
    bend = lambda x: (x + np.sqrt(x * x + 4 * softness * softness)) / 2
    levels = np.linspace(0, 1, 2001)
    curve = bend(levels - reject) - bend(levels - shoulder) / 2
    curve = (curve - curve[0]) / (curve[-1] - curve[0])
    return 85 * (np.interp(gray / 255, curve, levels) - 1)


def brightest_spot(image):
    """Its place in the world: the middle of the pixels within 10 dB of the brightest, weighted by their amplitudes."""
    size, numbers, gray = image
    axes = np.reshape(numbers, (4, 3))
    level = level_of(np.frombuffer(gray, np.uint8).reshape(size[1], size[0]).astype(float))
    level[:size[1] // 10] = -85  # the skin of the probe
    amplitude = 10 ** (level / 20)
    amplitude[amplitude < 0.3 * amplitude.max()] = 0
    rows, columns = np.indices(amplitude.shape)
    column, row = (amplitude * columns).sum() / amplitude.sum(), (amplitude * rows).sum() / amplitude.sum()
    return axes[3] + axes[0] * (column - (size[0] - 1) / 2) + axes[1] * (row - (size[1] - 1) / 2)


def test_ball(program):
    write_ball("ball.obj")
    with Server(program, "--obj", "ball.obj", "--unit", "1mm", "--background", "urine") as server:  # 1538 m/s
        client = Connection(server.port)
        client.send(pack_command(1, "", "lines 512\nwidth 800\nplanes 1\ngain -26\nfocus 20"))
        client.until("RTS_COMMAND")
        client.send(pack_transform("NeedleTipToReference", [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 200, 0]))  # out of the picture
        for turn, tilt, lateral, depth in ((0, 0, 8, 20), (1.2, 0.15, -6, 18), (-2.5, -0.3, 3, 24)):
            columns = probe_columns(turn, tilt, lateral, depth)
            client.send(pack_transform("ProbeToReference", columns))
            while not np.allclose(np.frombuffer(client.until("TRANSFORM", device="ProbeToReference")["body"], ">f4"),
                                  columns, atol=1e-4):
                pass
            spot = brightest_spot(read_image(client.until("IMAGE")["body"]))
            # The echo is that of the near side, and scanners take the sound speed for 1540 m/s.
            late = depth * (1540 / 1538 - 1) + 3 * (1540 / 1520 - 1540 / 1538)  # 3 mm of gel
            expected = BALL + (late - RADIUS) * columns[6:9]
            error = np.linalg.norm(spot - expected)
            print(f"ball at ({lateral}, {depth}) mm of the picture: {spot}, expected {expected}: {error:.3f} mm, at most 0.05")
            assert error < 0.05


def test_latency(program, client):
    with Server(program) as server:
        quick = Connection(server.port)
        quick.send(pack_command(1, "", "width 256\nlines 64\nplanes 1"))
        quick.until("RTS_COMMAND")
        quick.close()
        subprocess.run([client, "--port", str(server.port), "--transforms", "60"], check=True, timeout=60)


test_latency(sys.argv[1], sys.argv[2])
test_ball(sys.argv[1])
