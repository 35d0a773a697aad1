"""The scanner: clips, freeze and cine loop, places, callipers, M-mode."""
import gc

import numpy as np
import pytest

import insonify as us
from insonify import mm, tissue


def machine_of(probe=None, **settings):
    return us.scanner(probe or us.linear_array(lines=96), us.b_mode_settings(depth=50 * mm, size=(160, 0), **settings))


def test_a_clip_equals_that_of_cpp_bit_for_bit(phantom, equals_cpp):
    body, machine = phantom(), machine_of(persistence=0.5)
    machine.cine_length = 3
    pictures = []
    for machine.settings.frame in range(3):
        pictures.append(machine.scan(body, us.pose()))
    lines, echoes = machine.lines, machine.echoes
    machine.freeze()
    machine.settings.gain_db = 6
    equals_cpp("clip", [each.pixels for each in pictures] + [lines.values, echoes.values, machine.show(2).pixels])


@pytest.mark.parametrize("probe", [us.linear_array(lines=48), us.convex_array(lines=48), us.phased_array(lines=48), us.radial_array(lines=48)], ids=lambda probe: type(probe).__name__)
def test_a_frame_is_that_of_b_mode(phantom, probe):
    body, machine = phantom(), machine_of(probe)
    machine.probe.focus = 20 * mm
    machine.settings.gain_db = 3
    picture = machine.scan(body, us.pose())
    assert picture == us.b_mode(body, machine.probe, us.pose(), machine.settings) and machine.picture == picture
    assert machine.probe.focus == pytest.approx(20 * mm) and probe.focus == 0
    with pytest.raises(TypeError, match="make another scanner for another array"):
        machine.probe = us.pose()


def test_pictures_stay_when_the_next_is_drawn(phantom):
    body, machine = phantom(), machine_of()
    pixels = machine.scan(body, us.pose()).pixels
    before = pixels.copy()
    machine.settings.size = (900, 0)
    machine.settings.gain_db = 9
    assert machine.scan(body, us.pose()).size[0] == 900
    assert np.array_equal(pixels, before)
    how = machine.settings
    del machine
    gc.collect()
    assert how.gain_db == 9  # keeps its scanner


@pytest.mark.parametrize("angles", [1, 2, 3])
def test_echoes_say_where_their_lines_lie(angles):
    water = us.medium(density=1000, sound_speed=1540)
    body, target = us.scene(water), np.array([-6 * mm, 0, 22 * mm])
    body.add(us.make_sphere(tuple(target), 0.3 * mm, 3), tissue.steel)
    body.build()
    machine = machine_of(us.linear_array(lines=64), compound=us.compound_settings(angles=angles))
    with pytest.raises(us.usage_error, match="there is no picture yet"):
        machine.echo_beams
    machine.scan(body, us.pose())
    echoes, beams = np.abs(np.asarray(machine.echoes.values)), machine.echo_beams
    assert beams.shape == (machine.echoes.count, 2, 3) and machine.echoes.count > 64
    line, sample = np.unravel_index(echoes.argmax(), echoes.shape)
    place = beams[line, 0] + beams[line, 1] * (sample + 0.5) * machine.echoes.depth / machine.echoes.samples
    assert np.linalg.norm(place - target) < 0.6 * mm  # the radius of the ball, and a line


def test_freeze_and_cine_loop(phantom):
    body, machine = phantom(), machine_of()
    machine.cine_length = 4
    for frame in range(6):
        machine.scan(body, us.pose())
        machine.time += 0.04
    assert len(machine.cine) == 4 and [frame.time for frame in machine.cine] == pytest.approx([0.2, 0.16, 0.12, 0.08])
    assert machine.cine[-1].amplitudes.values.shape == machine.lines.values.shape
    machine.freeze()
    times = machine.times
    assert machine.frozen and times.total >= times.trace > 0
    machine.settings.gain_db = 6
    machine.scan(body, us.pose())
    assert machine.times.trace == 0 and len(machine.cine) == 4  # nothing was acquired
    machine.unfreeze()
    assert not machine.frozen
    with pytest.raises(us.usage_error, match="`back` is 4, and 4 frames are stored; `cine_length`"):
        machine.show(4)
    with pytest.raises(IndexError, match="4 frames are stored"):
        machine.cine[4]
    with pytest.raises(us.usage_error, match="there is no picture yet"):
        machine_of().labels(body)


def test_places_and_callipers():
    body = us.scene(tissue.muscle).build()
    machine = us.scanner(us.linear_array(lines=64, width=40 * mm), us.b_mode_settings(depth=40 * mm, size=(400, 400)))
    at = us.look_at((0, 100 * mm, 0), (0, 100 * mm, 1), (1, 0, 0))
    machine.scan(body, at)
    assert machine.map.point((100, 300)) == pytest.approx((-10 * mm, 30 * mm), abs=1e-6)
    assert machine.point((100, 300)) == pytest.approx((-10 * mm, 100 * mm, 30 * mm), abs=1e-6)
    assert machine.pixel((-10 * mm, 100 * mm, 30 * mm)) == pytest.approx((100, 300), abs=1e-3)
    assert machine.at == at
    assert us.distance(machine.map, (100, 100), (130, 140)) == pytest.approx(5 * mm)
    found = us.measure_outline(machine.map, [(100, 100), (200, 100), (200, 150), (100, 150)])
    assert (found.area, found.circumference) == pytest.approx((50 * mm**2, 30 * mm)) and found.centroid == pytest.approx((150, 125))
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    circle = us.measure_outline(machine.map, 200 + 50 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    print(f"area of a circle of 5 mm: {circle.area / mm**2:.3f} mm^2, expected {25 * np.pi:.3f}")
    assert circle.area == pytest.approx(np.pi * (5 * mm) ** 2, rel=1e-3)


def test_labels_overlay_the_picture(phantom):
    body, machine = phantom(), machine_of()
    picture = machine.scan(body, us.pose())
    labels = machine.labels(body).pixels
    column = int(machine.pixel((6 * mm, 0, 0))[0])
    bone = np.flatnonzero(labels[:, column] == body.find("bone"))
    expected = machine.pixel((0, 0, 22 * mm * 1540 / tissue.muscle.sound_speed))[1]  # where it is displayed
    bright = picture.pixels[:, column].argmax()
    print(f"labels of bone begin in row {bone[0]}, the echo is in row {bright}, expected {expected:.2f}")
    assert labels.shape == picture.pixels.shape and labels[1, 1] == us.background_label
    assert abs(bone[0] - expected) <= 1 and abs(bright + 0.5 - expected) <= 1.5


def test_m_mode():
    body = us.scene(tissue.muscle)
    wall = body.add(us.make_box((-10 * mm, -10 * mm, 0), (10 * mm, 10 * mm, 5 * mm)), tissue.bone)
    body.build()
    machine = us.scanner(us.linear_array(lines=32, width=10 * mm), us.b_mode_settings(depth=30 * mm, planes=1))
    sweep = us.m_mode(us.m_mode_settings(columns=40, rows=300))
    depths = 10 + 2 * np.sin(0.3 * np.arange(40))
    for depth in depths:
        body.place(wall, us.look_at((0, 0, depth * mm), (0, 0, 1), (1, 0, 0)))
        body.update()
        machine.scan(body, us.pose())
        sweep.add(machine.lines, machine.lines.count // 2)
    seen = (sweep.picture.pixels.argmax(axis=0) + 0.5) / 10 * tissue.muscle.sound_speed / 1540
    print(f"wall at {seen.min():.2f} to {seen.max():.2f} mm, expected {depths.min():.2f} to {depths.max():.2f}")
    assert sweep.count == 40 and sweep.depth == pytest.approx(30 * mm) and np.abs(seen - depths).max() < 0.15
    with pytest.raises(us.usage_error, match="counted from 0"):
        sweep.add(machine.lines, 9999)


def test_memory_does_not_grow_over_10000_frames(phantom, resident):
    body, machine = phantom(), us.scanner(us.linear_array(lines=8), us.b_mode_settings(depth=10 * mm, size=(16, 0), planes=1))
    machine.cine_length = 5
    for machine.settings.frame in range(10000):
        machine.scan(body, us.pose(), policy="unseq").pixels
        machine.labels(body, policy="unseq")
        machine.cine[0].amplitudes.values
        if machine.settings.frame == 1000:
            before = resident()
    print(f"grown by {(resident() - before) / 2**20:.2f} MB")
    assert resident() - before < 4 << 20
