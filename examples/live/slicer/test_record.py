"""Reads a recorded sequence as PLUS's documentation describes it, and compares it with what a client has received; then
ends a server in the middle: test_record.py SERVER"""
import pathlib
import signal
import sys
import time

import numpy as np

from openigtlink import Connection, read_image
from server_process import Server


def read_sequence(path):
    """The fields, the fields of each frame, and the frames."""
    data = pathlib.Path(path).read_bytes()
    fields, frames, at = {}, {}, 0
    while "ElementDataFile" not in fields:
        end = data.index(b"\n", at)
        assert end - at < 500, "PLUS and MetaIO read lines of at most 500 characters"
        key, value = data[at:end].decode("ascii").split(" = ", 1)
        at = end + 1
        if key.startswith("Seq_Frame"):
            number, name = key[len("Seq_Frame"):].split("_", 1)
            frames.setdefault(int(number), {})[name] = value.strip()
        elif key != "Padding":
            assert key not in fields, key
            fields[key] = value.strip()
    assert next(iter(fields)) == "ObjectType" and fields["ObjectType"] == "Image"
    expected = {"NDims": "3", "BinaryData": "True", "BinaryDataByteOrderMSB": "False", "CompressedData": "False",
                "ElementType": "MET_UCHAR", "ElementNumberOfChannels": "1", "UltrasoundImageOrientation": "MFA",
                "UltrasoundImageType": "BRIGHTNESS", "ElementDataFile": "LOCAL", "Kinds": "domain domain list"}
    assert {key: fields[key] for key in expected} == expected, fields
    columns, rows, count = map(int, fields["DimSize"].split())
    pixels = np.frombuffer(data, np.uint8, offset=at)
    assert pixels.size >= count * rows * columns, (pixels.size, fields["DimSize"])
    assert set(range(count)) <= set(frames) and len(frames) <= count + 1
    return fields, frames, pixels[:count * rows * columns].reshape(count, rows, columns), pixels.size


def matrix(frame, name):
    assert frame[name + "TransformStatus"] == "OK"
    return np.array(frame[name + "Transform"].split(), float).reshape(4, 4)


# The size changes with the depth, and a frozen picture is not recorded.
REPLAY = """width 200
lines 48
planes 1
frame
slide 2 1
gain 4
""" + 15 * "advance 1\nframe\n" + "depth 45\nframe\n" + 15 * "tilt 0.5\nframe\n" + "freeze\nframe\nunfreeze\n"


def test_complete(program):
    received = []
    pathlib.Path("replay.txt").write_text(REPLAY)
    with Server(program, "--replay", "replay.txt", "--record", "sequence.igs.mha", "--frames", "40", "--fps", "8") as server:
        client = Connection(server.port)
        try:
            while True:
                message = client.until("IMAGE")
                received.append((message["time"], read_image(message["body"])))
        except ConnectionError:
            pass
        assert server.end() == 0
    sequences = [read_sequence(name) for name in ("sequence.igs.mha", "sequence-2.igs.mha")]  # the depth changes
    recorded = []
    for fields, frames, pixels, _ in sequences:
        spacing = np.array(fields["ElementSpacing"].split(), float)
        for number, picture in enumerate(pixels):
            frame = frames[number]
            assert frame["ImageStatus"] == "OK"
            to_probe, to_world = matrix(frame, "ImageToProbe"), matrix(frame, "ProbeToReference")
            assert np.allclose(np.linalg.norm(to_probe[:3, :2], axis=0), spacing[:2], rtol=1e-5)
            matrix(frame, "NeedleTipToReference")
            recorded.append((int(frame["FrameNumber"]), float(frame["Timestamp"]), picture, to_world @ to_probe))
    assert [one[0] for one in recorded] == list(range(len(recorded)))
    compared, furthest = 0, 0
    used = 0
    for _, (size, numbers, gray) in received:
        picture = np.frombuffer(gray, np.uint8).reshape(size[1], size[0])
        match = next((i for i in range(used, len(recorded)) if np.array_equal(recorded[i][2], picture)), None)
        if match is None:
            continue  # a frozen picture, which is not recorded
        used = match + 1
        axes = np.reshape(numbers, (4, 3))
        for column, row in ((0, 0), (size[0] - 1, size[1] - 1)):
            streamed = axes[3] + axes[0] * (column - (size[0] - 1) / 2) + axes[1] * (row - (size[1] - 1) / 2)
            stored = recorded[match][3] @ [column, row, 0, 1]
            furthest = max(furthest, np.abs(streamed - stored[:3]).max())
        compared += 1
    print(f"{len(recorded)} frames recorded, {len(received)} received, {compared} equal in every pixel")
    print(f"pixels in the world, recorded and sent: within {furthest:.5f} mm, expected 0.001")
    assert compared >= 20 and furthest < 0.001
    for fields, frames, pixels, size in sequences:
        assert size == pixels.size and pixels.std() > 10
        stamps = [float(frames[i]["Timestamp"]) for i in range(len(pixels))]
        assert stamps[0] == 0 and all(a < b for a, b in zip(stamps, stamps[1:]))


def test_killed(program):
    server = Server(program, "--record", "killed.igs.mha", "--fps", "10")
    path = pathlib.Path("killed.igs.mha")
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        time.sleep(0.2)
        if path.exists() and path.stat().st_size > 0 and len(read_sequence(path)[2]) >= 3:
            break
    server.end(signal.SIGKILL)
    _, _, pixels, _ = read_sequence(path)
    print(f"a killed server leaves {len(pixels)} complete frames, expected 3 or more")
    assert len(pixels) >= 3 and all(picture.std() > 10 for picture in pixels)


for old in pathlib.Path().glob("*.igs.mha"):
    old.unlink()
test_complete(sys.argv[1])
test_killed(sys.argv[1])
