"""Tubes and sheets of arrays of points, their lines, and what flows and moves along them."""
import copy
import pickle

import numpy as np
import pytest

import insonify as us
from insonify import mm, tissue

BEND = 40 * mm  # radius of an arc


def arc(radii, count=33):
    """A quarter of a circle in the plane of x and z around the origin, with columns of radii."""
    angle = np.linspace(0, np.pi / 2, count)
    points = BEND * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    return np.column_stack([points, np.broadcast_to(radii, (count, np.size(radii)))])


def volume(mesh):
    a, b, c = np.moveaxis(mesh.positions.astype(float)[mesh.faces], 1, 0)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_a_tube_is_made_of_an_array():
    for columns, area in ((3 * mm, np.pi * (3 * mm) ** 2), ([3 * mm, 2 * mm], np.pi * 6e-6), ([3 * mm, 2 * mm, 0.4], np.pi * 6e-6)):
        tube = us.make_tube(arc(columns), segments=64, ends="flat")
        assert us.validate(tube) == ""
        assert volume(tube) == pytest.approx(area * BEND * np.pi / 2, rel=5e-3)  # Pappus
    ends = volume(us.make_tube(arc(3 * mm), segments=64)) - volume(us.make_tube(arc(3 * mm), segments=64, ends="flat"))
    assert ends == pytest.approx(4 / 3 * np.pi * (3 * mm) ** 3, rel=2e-2)
    flat = us.make_tube([(0, 0, 0, 2 * mm, 1 * mm), (0, 0, 9 * mm, 2 * mm, 1 * mm)], ends="flat", across=(0, 1, 0))
    assert np.ptp(flat.positions[:, 1]) == pytest.approx(4 * mm, rel=1e-3) and np.ptp(flat.positions[:, 0]) == pytest.approx(2 * mm, rel=1e-3)
    for wrong, sentence in ((np.zeros((4, 3)), "make_tube: the line must be an array of N x 4"), (np.zeros((1, 4)), "give from 2 to")):
        with pytest.raises(ValueError, match=sentence):
            us.make_tube(wrong)
    with pytest.raises(us.usage_error, match="one of round, flat"):
        us.make_tube(arc(1 * mm), ends="sharp")
    with pytest.raises(us.geometry_error, match="bends more sharply"):
        us.make_tube(arc(60 * mm))


def test_a_sheet_is_made_of_an_array():
    x, y = np.meshgrid(np.linspace(0, 30 * mm, 7), np.linspace(0, 20 * mm, 5))
    points = np.stack([x, y, 0 * x], axis=-1)
    even, tapered = us.make_sheet(points, 1 * mm), us.make_sheet(points, 0.1 * mm + x / 30)
    assert us.validate(even) == us.validate(tapered) == "" and len(even.positions) == 70
    assert volume(even) == pytest.approx(600e-6 * 1 * mm, rel=1e-5) and volume(tapered) == pytest.approx(600e-6 * 0.6 * mm, rel=1e-5)
    assert volume(us.make_sheet(points)) == pytest.approx(600e-6 * 0.5 * mm, rel=1e-5)  # the default of C++
    for points, thickness, sentence in ((points[0], 1, "rows x columns x 3"), (points, [1, 2], "one number, or an array of rows"), (points[:1], 1, "at least 2")):
        with pytest.raises(ValueError, match=sentence):
            us.make_sheet(points, thickness)


def test_places_along_a_line():
    line = us.centre_line(arc([3 * mm, 2 * mm]), across=(0, 1, 0))
    for angle in (0.1, 0.8, 1.5):
        out, along = np.array([np.sin(angle), 0, np.cos(angle)]), np.array([np.cos(angle), 0, -np.sin(angle)])
        place = line.place(tuple((BEND + 1 * mm) * out + 0.5 * mm * np.array([0, 1, 0])))
        assert np.allclose(place.centre, BEND * out, atol=0.05 * mm) and np.allclose(place.along, along, atol=0.01)
        assert abs(place.first_axis[1]) > 0.999 and abs(np.dot(place.second_axis, out)) > 0.999
        assert place.radii == pytest.approx((3 * mm, 2 * mm)) and place.area == pytest.approx(np.pi * 6e-6)
        assert place.squared(tuple(BEND * out + 3 * mm * np.array([0, 1, 0]))) == pytest.approx(1, abs=0.01)
    assert line.first.centre == pytest.approx((0, 0, BEND))
    assert line.sections.shape == (33, 6) and np.allclose(line.sections[:, :5], arc([3 * mm, 2 * mm]))
    for again in (pickle.loads(pickle.dumps(line)), copy.deepcopy(line)):
        assert again == line and repr(again) == "<centre_line of 33 sections>"
    assert us.centre_line(arc([3 * mm, 2 * mm, 0.1]), across=(0, 1, 0)) != line
    with pytest.raises(us.geometry_error, match="centre_line: the line turns back at point 1"):
        us.centre_line([(0, 0, 0, 1 * mm), (0, 0, 9 * mm, 1 * mm), (0, 0, 0, 1 * mm)])
    with pytest.raises(us.usage_error, match="there is no line yet"):
        us.tube_flow().line.place((0, 0, 0))


def test_flow_in_a_tube():
    tube = us.tube_flow(object=3, line=arc([3 * mm, 2 * mm]), peak_velocity=0.4, waveform=us.pulsatile(heart_rate=1))
    assert tube.volume_flow(0.15) == pytest.approx(0.5 * np.pi * 6e-6 * 0.4)  # systole
    assert tube.line == us.centre_line(arc([3 * mm, 2 * mm])) and us.tube_flow(line=tube.line).line == tube.line
    again = pickle.loads(pickle.dumps(tube))
    assert again == tube and repr(again) == repr(tube) and again.volume_flow(0.15) == tube.volume_flow(0.15)
    assert pickle.loads(pickle.dumps(us.tube_flow())) == us.tube_flow()
    with pytest.raises(us.usage_error, match="tube_flow: `line` is empty"):
        us.tube_flow(peak_velocity=0.4).volume_flow(0)
    with pytest.raises(us.usage_error, match="centre_line: the sections must be an array of N x 4"):
        tube.line = np.zeros((3, 3))
    with pytest.raises(TypeError, match="`line` of tube_flow cannot be 'straight'"):
        tube.line = "straight"


def test_flow_in_a_straight_tube_is_that_of_poiseuille():
    body = us.scene(tissue.muscle)
    start, end = (-30 * mm, 0, 5 * mm), (30 * mm, 0, 40 * mm)
    artery = body.add(us.make_cylinder(start, end, 4 * mm, 64), tissue.blood)
    body.build()
    how = us.doppler_settings(depth=40 * mm, ensemble=4)
    probe = us.linear_array(lines=32)
    straight = us.poiseuille(object=artery, from_=start, to=end, radius=4 * mm, peak_velocity=0.3)
    bending = us.tube_flow(object=artery, line=[(*start, 4 * mm), (*end, 4 * mm)], peak_velocity=0.3)
    one, other = (us.colour_doppler(body, probe, us.pose(), field, how) for field in (straight, [bending]))
    assert one.power.max() > 0 and np.allclose(one.velocity, other.velocity, atol=2e-3 * one.max_velocity)
    with pytest.raises(us.usage_error, match="tube_flow: `line` is empty"):
        us.colour_doppler(body, probe, us.pose(), us.tube_flow(object=artery), how)


@pytest.mark.parametrize("vessel", [us.pulsation(radius=4 * mm, amplitude=0.4 * mm, rate=1, time=0.15), us.collapse(radius=4 * mm, outside=1200)],
                         ids=["pulsation", "collapse"])
def test_a_map_along_a_straight_line_is_that_of_a_straight_vessel(vessel):
    straight = copy.copy(vessel)
    straight.from_, straight.to = (0, -20 * mm, 15 * mm), (0, 20 * mm, 15 * mm)
    along = us.bent([(0, -20 * mm, 15 * mm, 4 * mm), (0, 20 * mm, 15 * mm, 4 * mm)], vessel)
    points = np.random.default_rng(1).uniform([-9 * mm, -15 * mm, 6 * mm], [9 * mm, 15 * mm, 24 * mm], (200, 3))
    assert np.abs(straight(points) - points).max() > 0.1 * mm and np.allclose(along(points), straight(points), atol=1e-6)


def test_an_artery_that_bends_pulses():
    body = us.scene(tissue.muscle)
    artery = body.add(us.make_tube(arc([3 * mm, 2 * mm]), ends="flat"), tissue.blood)
    body.build()
    pulse = us.bent(arc([3 * mm, 2 * mm]), us.pulsation(radius=3 * mm, amplitude=0.3 * mm, rate=1, time=0.15))
    before = volume(us.mesh(body.positions(artery), us.make_tube(arc([3 * mm, 2 * mm]), ends="flat").faces))
    body.deform(pulse)
    after = volume(us.mesh(body.positions(artery), us.make_tube(arc([3 * mm, 2 * mm]), ends="flat").faces))
    assert after == pytest.approx(1.1**2 * before, rel=1e-3)  # systole: a tenth wider everywhere
    wall = tuple(body.positions(artery)[70])
    assert body.rest_of(wall, artery) == pytest.approx(tuple(body.rest_positions(artery)[70]), abs=2e-6)
    pulse.vessel.time = 1  # a whole beat: at rest
    body.deform(us.compose(pulse, us.breathing(amplitude=0)))
    assert np.allclose(body.positions(artery), body.rest_positions(artery), atol=1e-7)
    again = pickle.loads(pickle.dumps(pulse))
    assert type(again) is us.bent_pulsation and again == pulse and again.vessel.time == 1 and again.line == pulse.line
    with pytest.raises(us.usage_error, match="bent: `line` is empty"):
        body.deform(us.bent_collapse())
    with pytest.raises(us.usage_error, match="pulsation: `from` and `to`|radius"):
        body.deform(us.bent(pulse.line, us.pulsation(amplitude=1)))
