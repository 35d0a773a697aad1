"""What lies along the lines: find_layers, scanner.layers."""
import gc

import numpy as np
import pytest

import insonify as us
from insonify import MHz, mm, tissue

PLACE = us.pose(translation=(2 * mm, 0, 1 * mm))
SCAN = us.acquisition(depth=50 * mm, planes=3)


def numbers(found):
    """Of all layers, as the program in C++ writes them."""
    for line in range(found.lines):
        for plane in range(found.planes):
            for one in found(line, plane):
                yield np.concatenate([np.ravel(one[name]) for name in ("begin", "end", "cosine", "slope", "curvature", "roughness")])
                yield np.array([one["medium"], one["object"]], np.uint32)


def test_layers_equal_those_of_cpp_bit_for_bit(phantom, equals_cpp):
    body = phantom()
    machine = us.scanner(us.linear_array(lines=96), us.b_mode_settings(depth=50 * mm, size=(160, 0)))
    machine.scan(body, PLACE)
    found = [us.find_layers(body, us.linear_array(lines=24), PLACE, SCAN), us.find_layers(body, us.radial_array(lines=24), PLACE, SCAN), machine.layers]
    equals_cpp("layers", [part for each in found for part in numbers(each)])


@pytest.mark.parametrize("probe", [us.linear_array(lines=65), us.convex_array(lines=65), us.phased_array(lines=65)], ids=lambda probe: type(probe).__name__)
def test_chords_of_a_sphere(probe):
    """How long each line is within a sphere: 2 sqrt(r^2 - d^2), with d from its centre to the line."""
    body, centre, radius = us.scene(tissue.muscle), np.array([3 * mm, 0, 30 * mm]), 8 * mm
    ball = body.add(us.make_sphere(centre, radius, 6), tissue.bone)
    body.build()
    found = us.find_layers(body, probe, us.pose(), us.acquisition(depth=80 * mm, planes=1))
    assert (found.lines, found.planes) == (65, 1) and found.media == (tissue.muscle, tissue.bone)
    for line in range(found.lines):
        along, frame = found(line), found.frame(line)
        origin, direction = np.array(frame.origin), np.array(frame.along)
        assert np.allclose((origin, direction), probe.beam(line), atol=1e-6)
        away = np.linalg.norm(np.cross(centre - origin, direction))
        inside = along["object"] == ball
        chord = (along["end"] - along["begin"])[inside].sum()
        assert chord == pytest.approx(2 * np.sqrt(max(radius**2 - away**2, 0)), abs=0.4 * mm if away > 0.97 * radius else 0.03 * mm)
        assert (along["medium"][inside] == 1).all() and (along["medium"][~inside] == 0).all() and (along["object"][~inside] == us.background_label).all()
        assert along["begin"][0] == 0 and np.array_equal(along["begin"][1:], along["end"][:-1]) and along["end"][-1] == pytest.approx(80 * mm)
        if inside.any():
            on_surface = frame.at(along["begin"][inside][0])
            assert np.linalg.norm(np.array(on_surface) - centre) == pytest.approx(radius, abs=0.02 * mm)


def test_planes_tilt_to_both_sides(phantom):
    found = us.find_layers(phantom(), us.linear_array(lines=8), us.pose(), SCAN)
    tilts = [found.frame(3, plane).tilt for plane in range(found.planes)]
    assert tilts[0] == 0 and tilts[1] == -tilts[2] != 0
    frame = found.frame(3, 1)
    assert np.allclose(frame.path, np.array(frame.along) + frame.tilt * np.array(frame.elevation))


def test_layers_are_views_and_keep_their_owner(phantom):
    body = phantom()
    found = us.find_layers(body, us.linear_array(lines=24), us.pose(), SCAN)
    along = found(12)
    assert np.shares_memory(along, found(12)) and along.dtype.names[:4] == ("begin", "end", "medium", "object")
    with pytest.raises(ValueError):
        along["begin"] = 1
    before = along.copy()
    del found, body
    gc.collect()
    assert np.array_equal(along, before)


def test_layers_of_a_scanner(phantom):
    body, machine = phantom(), us.scanner(us.linear_array(lines=96), us.b_mode_settings(depth=50 * mm))
    with pytest.raises(us.usage_error, match="there is no picture yet"):
        machine.layers
    machine.scan(body, us.pose())
    found = machine.layers
    count, beams = found.lines, machine.echo_beams
    assert found.planes == machine.settings.planes and count == len(beams)
    assert np.allclose([found.frame(line).origin for line in range(count)], beams[:, 0], atol=1e-6)
    first = found(0).copy()
    body.place(body.find("bone"), us.pose(translation=(-20 * mm, 0, 0)))
    body.update()
    machine.scan(body, us.pose())
    assert np.array_equal(found(0), first) and len(machine.layers(0)) > len(first)  # a copy
    straight = us.scanner(us.linear_array(lines=32), us.b_mode_settings(depth=30 * mm), us.physical(), us.paths())
    straight.scan(body, us.pose())
    assert straight.layers.lines == 0


def test_places_out_of_range_are_refused(phantom):
    found = us.find_layers(phantom(), us.linear_array(lines=24, frequency=5 * MHz), us.pose(), SCAN)
    for call in (found, found.frame):
        with pytest.raises(IndexError, match="line 24 is not one of the 24, counted from 0"):
            call(24)
        with pytest.raises(IndexError, match="plane 3 is not one of the 3, counted from 0"):
            call(0, 3)
        with pytest.raises(TypeError):
            call(-1)
    with pytest.raises(us.usage_error, match="did you mean"):
        us.find_layers(phantom(), us.linear_array(), us.pose(), us.acquisition(depth=50))
    with pytest.raises(us.usage_error, match="call build"):
        us.find_layers(us.scene(), us.linear_array(), us.pose(), SCAN)
