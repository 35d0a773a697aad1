"""Validates every message of the server byte by byte: test_wire.py SERVER"""
import math
import sys
import time

import numpy as np

from openigtlink import Connection, pack, pack_command, pack_string, pack_transform, read_command, read_image, \
    read_status, read_string
from server_process import Server

QUICK = "width 160\nlines 48\nplanes 1"


def matrix(body):
    values = np.frombuffer(body, ">f4").astype(float)
    assert values.size == 12 and np.isfinite(values).all()
    columns = values.reshape(4, 3)
    assert np.allclose(columns[:3] @ columns[:3].T, np.eye(3), atol=1e-5), "not a rotation"
    assert np.linalg.det(columns[:3]) > 0
    return columns


def test_greeting(client):
    message = client.receive()
    assert message["type"] == "STATUS" and message["device"] == "insonify", message
    assert read_status(message["body"])[:2] == (1, "OK")


def test_commands(client):
    client.send(pack_command(1, "knobs", QUICK))
    reply = client.until("RTS_COMMAND")
    number, name, text, metadata = read_command(reply)
    assert (reply["version"], reply["device"], number, name) == (2, "test", 1, "knobs")
    assert metadata == {"Status": "SUCCESS", "Message": "width 160; lines 48; planes 1"}, metadata
    assert text == '<CommandReply Name="knobs" Status="SUCCESS" Message="width 160; lines 48; planes 1"></CommandReply>'
    client.send(pack_command(2, "wrong", "gian 6", version=1))
    reply = client.until("RTS_COMMAND")
    number, name, text, metadata = read_command(reply)
    assert (reply["version"], number, name, metadata) == (1, 2, "wrong", {})
    assert 'Status="FAIL"' in text and "there is no event 'gian'" in text, text
    client.send(pack_command(3, "SetUsParameter", '<Command Name="SetUsParameter" UsDeviceId="VideoDevice">'
                             '<Parameter Name="DepthMm" Value="40" /><Parameter Name="GainPercent" Value="60"/></Command>'))
    metadata = read_command(client.until("RTS_COMMAND"))[3]
    assert metadata == {"Status": "SUCCESS", "Message": "depth 40; gain 6"}, metadata
    client.send(pack_string("CMD_17", '<Command Name="gain" Value="3"/>'))
    reply = client.until("STRING")
    assert reply["device"] == "ACK_17"
    assert read_string(reply["body"]) == '<CommandReply Status="SUCCESS" Message="gain 3" />'
    client.send(pack_string("knob", "gain loud"))
    reply = client.until("STRING")
    assert reply["device"] == "ACK" and "'loud' is not a finite number" in read_string(reply["body"]), reply


def test_frame(client):
    """Probe, needle and image of one picture."""
    probe = client.until("TRANSFORM", device="ProbeToReference")
    needle = client.receive()
    image = client.receive()
    assert needle["device"] == "NeedleTipToReference" and (image["type"], image["device"]) == ("IMAGE", "Image_Reference")
    assert probe["time"] == needle["time"] == image["time"] and abs(image["time"] - time.time()) < 5
    pose, _ = matrix(probe["body"]), matrix(needle["body"])
    size, numbers, pixels = read_image(image["body"])
    axes = np.reshape(numbers, (4, 3))
    pitch = np.linalg.norm(axes[0])
    assert abs(pitch * size[0] - 38) < 0.1 and abs(pitch * size[1] - 40) < 0.2, (pitch, size)
    assert np.allclose(axes[0] / pitch, pose[0], atol=1e-5) and np.allclose(axes[1] / pitch, pose[2], atol=1e-5)
    assert np.allclose(np.cross(axes[0], axes[1]) / pitch, axes[2], atol=1e-5), "not right-handed"
    middle = pose[3] + 20 * pose[2]
    print(f"middle of the image: {axes[3]}, expected {middle} within 0.1 mm")
    assert np.abs(axes[3] - middle).max() < 0.1
    assert np.frombuffer(pixels, np.uint8).std() > 10, "the image is empty"
    return pose


def test_poses(client):
    s, c = math.sin(0.2), math.cos(0.2)
    sent = [c, s, 0, -s, c, 0, 0, 0, 1, 3, -2, 0.25]
    client.send(pack_transform("ProbeToTracker", sent))
    for _ in range(20):
        pose = test_frame(client)
        if np.allclose(pose.ravel(), sent, atol=1e-5):
            break
    else:
        raise AssertionError("the probe has not moved")
    client.send(pack_transform("NeedleToReference", sent))
    for _ in range(20):
        message = client.until("TRANSFORM", device="NeedleTipToReference")
        if np.allclose(matrix(message["body"]).ravel(), sent, atol=1e-5):
            break
    else:
        raise AssertionError("the needle has not moved")
    for wrong in ([math.nan] * 12, [0] * 12, [2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0], [-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
                  [1, 0, 0, 0, 1, 0, 0, 0, 1, math.inf, 0, 0]):
        client.send(pack_transform("ProbeToReference", wrong))
        code, _, sentence = read_status(client.until("STATUS")["body"])
        assert code == 10 and "not a rigid transform" in sentence, (code, sentence)
    client.send(pack_transform("StylusToReference", sent))
    code, _, sentence = read_status(client.until("STATUS")["body"])
    assert code == 4 and "moves nothing" in sentence, (code, sentence)


def test_queries(client):
    client.send(pack("GET_STATUS", "", b""))
    assert read_status(client.until("STATUS")["body"]) == (1, "OK", "running")
    client.send(pack("STP_IMAGE", "", b""))
    assert client.until("RTS_IMAGE")["body"] == b"\0"
    client.receive()  # at most the image of a frame that had begun
    for _ in range(6):
        assert client.receive()["type"] == "TRANSFORM"
    client.send(pack("GET_IMAGE", "Image_Reference", b""))
    client.until("IMAGE")
    client.send(pack("STT_IMAGE", "", b""))
    assert client.until("RTS_IMAGE")["body"] == b"\0"
    client.until("IMAGE")
    client.until("IMAGE")
    client.send(pack_command(4, "", "freeze"))
    assert read_command(client.until("RTS_COMMAND"))[3]["Status"] == "SUCCESS"
    first, second = (client.until("IMAGE")["body"] for _ in range(2))
    assert first == second, "the image is not frozen"
    client.send(pack("GET_STATUS", "", b""))
    assert read_status(client.until("STATUS")["body"]) == (1, "OK", "frozen")
    client.send(pack("POINT", "somebody", b"x" * 100))
    code, _, sentence = read_status(client.until("STATUS")["body"])
    assert code == 12 and sentence.startswith("POINT is not understood"), sentence


with Server(sys.argv[1]) as server:
    client = Connection(server.port)
    test_greeting(client)
    test_commands(client)
    test_frame(client)
    test_poses(client)
    test_queries(client)
    client.close()
    assert server.end() == 0
print("every message is as the protocol describes it")
