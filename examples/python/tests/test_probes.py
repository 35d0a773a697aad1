"""A probe of a rotating transducer, and sound that does not travel straight."""
import numpy as np
import pytest

import insonify as us
from insonify import MHz, deg, kHz, mm, tissue


@pytest.fixture(scope="module")
def artery():
    """A vessel of 4 mm in bone, along y."""
    body = us.scene(tissue.bone)
    body.add(us.make_cylinder((0, -20 * mm, 0), (0, 20 * mm, 0), 2 * mm, 256), tissue.blood, name="lumen")
    return body.build()


def test_a_radial_array_sees_a_vessel_from_inside(artery):
    probe, how = us.presets.intravascular
    assert us.presets.settings_for(probe) == how and type(probe) is us.radial_array and us.presets.heart[1] == us.presets.settings_for(us.phased_array())
    how.size = (400, 400)
    machine = us.scanner(probe, how)
    picture = machine.scan(artery, us.pose())
    assert picture == us.b_mode(artery, probe, us.pose(), how)
    edge = probe.radius + (2 * mm - probe.radius) * 1540 / tissue.blood.sound_speed
    radius = np.linspace(edge - 0.7 * mm, edge + 0.7 * mm, 141)
    for angle in np.arange(0, 360, 30) * deg:
        at = [machine.map.pixel((r * np.sin(angle), r * np.cos(angle))) for r in radius]
        seen = [picture.pixels[int(y), int(x)] for x, y in at]
        wall = radius[np.argmax(seen)]
        assert wall == pytest.approx(edge, abs=0.08 * mm), angle
    labels = machine.labels(artery).pixels
    x, y = machine.map.pixel((0, 1 * mm))
    assert labels[int(y), int(x)] == artery.find("lumen") and set(np.unique(labels)) == {0, us.background_label}


def test_stages_and_truth_of_a_radial_array(artery):
    probe, scan = us.radial_array(lines=64), us.acquisition(depth=4 * mm)
    echoes = us.convolve(us.trace(artery, probe, us.pose(), us.physical(), scan), probe)
    grid = us.make_scan_map(probe, scan, us.scan_convert_settings(size=(100, 100)))
    assert us.scan_convert(us.log_compress(us.envelope(echoes)), grid).size == (100, 100)
    assert grid.point(grid.pixel((-1 * mm, -3 * mm))) == pytest.approx((-1 * mm, -3 * mm), abs=1e-6)
    truth = us.ground_truth(artery, probe, us.pose(), us.label_settings(depth=4 * mm, samples=400))
    inside = (truth.label.values == artery.find("lumen")).sum(axis=1) * 4 * mm / 400
    assert np.allclose(inside, 1.5 * mm, atol=0.02 * mm)
    assert us.diagnose(artery, probe, us.pose(), scan) == ""
    origin, direction = probe.beam(47.5)  # lines 0 to 63 go around once, from behind by way of +x
    assert np.allclose(origin, (probe.radius, 0, 0), atol=1e-8) and np.allclose(direction, (1, 0, 0), atol=1e-6)
    with pytest.raises(TypeError):
        us.press(artery, probe, us.pose())


def test_a_radial_array_measures_flow():
    body = us.scene(tissue.muscle)
    ends = (-40 * mm, 0, 8 * mm), (40 * mm, 0, 8 * mm)
    vessel = body.add(us.make_cylinder(*ends, 3 * mm), tissue.blood)
    body.build()
    stream = us.poiseuille(object=vessel, from_=ends[0], to=ends[1], radius=3 * mm, peak_velocity=0.3)
    probe = us.radial_array(lines=64, frequency=6 * MHz)
    seen = us.colour_doppler(body, probe, us.pose(), stream, us.doppler_settings(depth=16 * mm, prf=8 * kHz))
    for angle in (-40 * deg, 40 * deg):
        line, depth = probe.locate((8 * mm * np.tan(angle), 8 * mm))
        middle, around = int(depth / seen.depth * seen.samples), int(0.5 * mm / seen.depth * seen.samples)
        found = np.mean(seen.velocity[int(line + 0.5), middle - around : middle + around])
        expected = -0.3 * np.sin(angle)  # towards the probe is above 0
        print(f"{found:.3f} m/s on the axis, expected {expected:.3f}")
        assert found == pytest.approx(expected, rel=0.2)
    assert us.doppler_picture(seen, probe).pixels.any()


def test_paths_equal_those_of_cpp_bit_for_bit(phantom, equals_cpp):
    body, probe, scan = phantom(), us.linear_array(lines=96), us.acquisition(depth=50 * mm)
    how = us.b_mode_settings(depth=50 * mm, size=(160, 0))
    rays = us.straight_lines(search="rays", directions=1)
    equals_cpp("paths", [us.trace(body, probe, us.pose(), us.physical(), scan, us.paths()).values, us.b_mode(body, probe, us.pose(), how, how=us.paths()).pixels,
                         us.b_mode(body, us.radial_array(lines=96), us.pose(), how, how=rays).pixels])


def test_paths_show_the_reverberations_of_a_plate():
    """Sound reverberates between two faces: echoes r, (1 - r^2) r, (1 - r^2) r^3, each 2 d later."""
    plate = us.medium(density=1000, sound_speed=3080)
    body = us.scene(us.medium(density=1000, sound_speed=1540))
    body.add(us.make_box((-60 * mm, -60 * mm, 10 * mm), (60 * mm, 60 * mm, 16 * mm)), plate, crease_angle=0)
    body.build()
    probe, scan, model = us.linear_array(lines=16, width=4 * mm), us.acquisition(depth=25 * mm, samples=2500), us.physical(min_ringing=1)
    r = 1 / 3  # twice the impedance
    level = {}
    for name, how in (("straight", us.straight_lines()), ("paths", us.paths())):
        lines = np.abs(us.trace(body, probe, us.pose(), model, scan, how).values[8])
        level[name] = [lines[int(depth * 100) - 30 : int(depth * 100) + 30].max() for depth in (10, 13, 16, 19)]  # 6 mm look like 3
    print({name: np.round(found, 4) for name, found in level.items()})
    expected = np.array([1, 1 - r**2, (1 - r**2) * r**2, (1 - r**2) * r**4])
    assert np.array(level["paths"]) / level["paths"][0] == pytest.approx(expected, rel=0.02)
    assert level["straight"][2] < 0.01 * level["straight"][0] < level["straight"][1]


def test_a_scanner_keeps_its_tracer(phantom):
    body, probe, settings = phantom(), us.linear_array(lines=32), us.b_mode_settings(depth=40 * mm, size=(64, 64), planes=1)
    machine = us.scanner(probe, settings, how=us.paths())
    assert machine.scan(body, us.pose()) == us.b_mode(body, probe, us.pose(), settings, how=us.paths()) != us.b_mode(body, probe, us.pose(), settings)
    machine.how.settings.bounces = 1
    assert machine.how == us.paths(settings=us.path_settings(bounces=1))
    machine.how = us.paths()
    with pytest.raises(TypeError, match="`how` stays of the type paths; make another scanner for another tracer"):
        machine.how = us.straight_lines()
    with pytest.raises(TypeError, match="`probe` stays of the type linear_array"):
        machine.probe = us.radial_array()
    with pytest.raises(us.usage_error, match="one of best, rays, slices"):
        us.straight_lines(search="lines")
    with pytest.raises(us.usage_error, match="min_amplitude"):
        us.b_mode(body, probe, us.pose(), settings, how=us.paths(settings=us.path_settings(min_amplitude=0)))
