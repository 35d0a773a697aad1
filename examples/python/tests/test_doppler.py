"""Doppler: velocity fields, colour, power and spectra."""
import gc

import numpy as np
import pytest

import insonify as us
from insonify import Hz, MHz, kHz, mm, m_per_s, tissue

FROM, TO = (-30 * mm, 0, 5 * mm), (30 * mm, 0, 40 * mm)
PROBE = us.linear_array(lines=48, width=38 * mm, frequency=6 * MHz)


@pytest.fixture(scope="module")
def vessel():
    """A scene, and the blood that flows in it."""
    body = us.scene(tissue.muscle)
    artery = body.add(us.make_cylinder(FROM, TO, 4 * mm, 64), tissue.blood)
    body.build()
    wave = us.pulsatile(heart_rate=1.2 * Hz)
    return body, us.poiseuille(object=artery, from_=FROM, to=TO, radius=4 * mm, peak_velocity=0.4 * m_per_s, waveform=wave)


def colour(vessel, **changed):
    body, stream = vessel
    return us.colour_doppler(body, PROBE, us.pose(), stream, us.doppler_settings(depth=40 * mm, prf=6 * kHz, ensemble=6, time=0.125, **changed))


def test_flow_equals_that_of_cpp_bit_for_bit(vessel, equals_cpp):
    body, stream = vessel
    seen = colour(vessel)
    grey = us.b_mode(body, PROBE, us.pose(), us.b_mode_settings(depth=40 * mm, size=(160, 0)))
    catheter = us.radial_array(lines=48, frequency=6 * MHz)
    around = us.colour_doppler(body, catheter, us.pose(), stream, us.doppler_settings(depth=40 * mm, prf=6 * kHz, ensemble=6, time=0.125))
    spectrum = us.pulsed_doppler(body, PROBE, us.pose(), stream, us.pulsed_doppler_settings(line=24, gate=22 * mm, prf=6 * kHz, duration=0.05))
    echoes = us.doppler_ensemble(body, PROBE, us.pose(), stream, us.ensemble_settings(depth=40 * mm, pulses=3))
    machine = us.scanner(PROBE, us.b_mode_settings(depth=30 * mm, size=(160, 0)))
    machine.scan(body, us.pose())
    of_picture = machine.colour(body, stream, us.doppler_settings(prf=6 * kHz, ensemble=6, time=0.125))
    its_spectrum = machine.spectrum(body, stream, us.pulsed_doppler_settings(line=24, gate=22 * mm, prf=6 * kHz, duration=0.05))
    equals_cpp("flow", [seen.velocity, seen.power, seen.variance, us.doppler_picture(seen, PROBE).pixels,
                        us.doppler_picture(around, catheter).pixels, us.colour_overlay(grey, seen, PROBE).pixels, spectrum.power, *[pulse.values for pulse in echoes.pulses],
                        us.doppler_picture(of_picture, PROBE).pixels, its_spectrum.power])


@pytest.mark.parametrize("how", [us.straight_lines(), us.paths()], ids=lambda how: type(how).__name__)
def test_a_scanner_measures_flow_in_its_picture(vessel, how):
    body, stream = vessel
    at = us.pose(translation=(1 * mm, 0, 0))
    machine = us.scanner(PROBE, us.b_mode_settings(depth=40 * mm), us.physical(seed=7), how)
    with pytest.raises(us.usage_error, match="there is no picture yet"):
        machine.colour(body, stream)
    machine.scan(body, at)
    here = us.doppler_settings(prf=6 * kHz, ensemble=6, time=0.125)
    seen = machine.colour(body, stream, here)
    here.depth = 40 * mm
    alone = us.colour_doppler(body, PROBE, at, stream, here, model=us.physical(seed=7))
    assert seen.depth == alone.depth and np.array_equal(seen.velocity, alone.velocity) and seen.velocity.any()
    gate = us.pulsed_doppler_settings(line=20, gate=20 * mm, duration=0.03)
    spectrum = machine.spectrum(body, [stream], gate)
    gate.depth = 40 * mm
    assert np.array_equal(spectrum.power, us.pulsed_doppler(body, PROBE, at, stream, gate, model=us.physical(seed=7)).power)


def test_velocities_are_views_and_keep_their_owner(vessel):
    seen = colour(vessel, box=us.colour_box(from_=15 * mm, to=30 * mm))
    velocity, shape = seen.velocity, (seen.count, seen.samples)
    assert velocity.shape == shape and seen.power.shape == shape and np.shares_memory(velocity, seen.velocity)
    assert seen.max_velocity == pytest.approx(1540 * 6000 / (4 * 6e6))
    assert not velocity[:, : seen.samples // 4].any() and velocity.any()  # nothing above the box
    before = velocity.copy()
    del seen
    gc.collect()
    assert np.array_equal(velocity, before)


def test_velocity_on_the_axis(vessel):
    body, stream = vessel
    cosine = (TO[2] - FROM[2]) / np.hypot(TO[0] - FROM[0], TO[2] - FROM[2])
    found = us.pulsed_doppler(body, PROBE, us.pose(), us.poiseuille(object=stream.object, from_=FROM, to=TO, radius=4 * mm, peak_velocity=0.4),
                              us.pulsed_doppler_settings(line=24, gate=22 * mm, prf=6 * kHz, duration=0.1, spectrum=us.spectrum_settings(angle=float(np.arccos(cosine)))))
    assert found.power.shape == (found.windows, found.bins)
    mean = np.mean([found.mean_velocity(window) for window in range(found.windows)])
    by_hand = (found.power * [found.velocity(bin) for bin in range(found.bins)]).sum() / found.power.sum()
    expected = -0.4 * 1540 / tissue.blood.sound_speed  # away from the probe
    print(f"mean velocity {mean:.3f} m/s, by numpy {by_hand:.3f}, on the axis {expected:.3f}")
    assert mean == pytest.approx(expected, rel=0.12) and by_hand == pytest.approx(mean, rel=0.05)
    with pytest.raises(IndexError, match="counted from 0"):
        found.mean_velocity(found.windows)


def test_tissue_moves_with_velocities_of_an_array():
    body = us.scene(tissue.muscle).build()
    still = np.zeros((2, 2, 2, 3))
    still[..., 2] = -0.02  # towards the probe
    field = us.velocity_samples(still, object=us.background_object, lower=3 * [-0.1], spacing=3 * [0.2])
    assert field.velocities.shape == (1, 2, 2, 2, 3)
    seen = us.colour_doppler(body, us.linear_array(lines=32), us.pose(), [field],
                             us.doppler_settings(depth=30 * mm, prf=1 * kHz, wall=us.wall_filter(type="none")))
    expected = 0.02 * 1540 / tissue.muscle.sound_speed
    print(f"median velocity {np.median(seen.velocity[:, 4:-4]):.4f} m/s, expected {expected:.4f}")
    assert np.median(seen.velocity[:, 4:-4]) == pytest.approx(expected, rel=0.02)


def test_pictures(vessel, tmp_path):
    seen = colour(vessel)
    grey = us.b_mode(vessel[0], PROBE, us.pose(), us.b_mode_settings(depth=40 * mm, size=(160, 0)))
    duplex = us.colour_overlay(grey, seen, PROBE)
    assert duplex.pixels.shape == (*grey.pixels.shape, 3) and np.shares_memory(duplex.pixels, np.asarray(duplex))
    red, green, blue = np.moveaxis(duplex.pixels, -1, 0)
    flow = us.doppler_picture(seen, PROBE, us.doppler_picture_settings(size=grey.size)).pixels
    assert (flow[blue > red] < 0).all() and (blue > red).sum() > 500  # blood flows away
    power = us.colour_overlay(grey, seen, PROBE, us.colour_overlay_settings(map="power"))
    assert (power.pixels[..., 0] >= power.pixels[..., 2]).all()
    us.write_png(str(tmp_path / "duplex.png"), duplex)
    assert (tmp_path / "duplex.png").read_bytes()[25] == 2  # colour


def test_the_ensemble_gives_what_colour_doppler_does(vessel):
    body, stream = vessel
    echoes = us.doppler_ensemble(body, PROBE, us.pose(), stream, us.ensemble_settings(depth=40 * mm, prf=6 * kHz, pulses=8, time=0.125))
    filtered = us.filter_walls(echoes, us.wall_filter(order=1))
    pulses = np.stack([pulse.values for pulse in filtered.pulses])
    one = filtered.pulses[0].values
    assert np.shares_memory(one, filtered.pulses[0].values)
    lag = (np.conj(pulses[:-1]) * pulses[1:]).sum(axis=0)
    velocity = np.angle(lag) / np.pi * 1540 * echoes.prf / (4 * PROBE.frequency)
    blood = np.abs(lag) > 1e-2 * np.abs(lag).max()
    seen = colour(vessel)
    strong = seen.power > 0.05 * seen.power.max()
    print(f"numpy {np.median(velocity[blood]):.3f} m/s, colour_doppler {np.median(seen.velocity[strong]):.3f}")
    assert np.median(velocity[blood]) == pytest.approx(np.median(seen.velocity[strong]), rel=0.25)


def test_pulsatile():
    wave = us.pulsatile(heart_rate=1 * Hz, resistive_index=0.7, systole=0.15)
    assert wave(0.15) == pytest.approx(1) and wave(1.0) == pytest.approx(0.3, abs=0.01)
    assert wave.mean() == pytest.approx(np.mean([wave(t) for t in np.linspace(0, 1, 1000, endpoint=False)]), rel=1e-2)
    tube = us.poiseuille(from_=(0, 0, 0), to=(1, 0, 0), radius=4 * mm, peak_velocity=0.4)
    assert tube.volume_flow(0) == pytest.approx(0.5 * np.pi * (4 * mm) ** 2 * 0.4)


def test_errors_keep_their_sentences(vessel):
    body, stream = vessel
    with pytest.raises(us.usage_error, match="wall_filter: order 7 needs at least 9 pulses"):
        colour(vessel, wall=us.wall_filter(order=7))
    with pytest.raises(us.usage_error, match="line 48 is not one of the probe"):
        us.pulsed_doppler(body, PROBE, us.pose(), stream, us.pulsed_doppler_settings(line=48))
    with pytest.raises(us.usage_error, match="poiseuille: `from` and `to`"):
        us.colour_doppler(body, PROBE, us.pose(), us.poiseuille())
    with pytest.raises(us.usage_error, match="samples along z, y and x"):
        us.velocity_samples(np.zeros((4, 3)), object=0, lower=(0, 0, 0), spacing=(1, 1, 1))
    with pytest.raises(TypeError, match="velocity_field"):
        us.colour_doppler(body, PROBE, us.pose(), lambda *_: 0)


def test_memory_does_not_grow(vessel, resident):
    for turn in range(60):
        colour(vessel, box=us.colour_box(first_line=20, lines=4)).velocity
        if turn == 20:
            before = resident()
    assert resident() - before < 4 << 20
