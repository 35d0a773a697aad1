"""Motion: maps of rest to now, and the probe that presses."""
import gc

import numpy as np
import pytest

import insonify as us
from insonify import mm, tissue


def test_pictures_of_motion_equal_those_of_cpp_bit_for_bit(phantom, equals_cpp):
    body, probe, pictures = phantom(), us.linear_array(lines=96), []

    def draw():
        pictures.append(us.b_mode(body, probe, us.pose(), us.b_mode_settings(depth=50 * mm, size=(160, 0))).pixels)

    artery = us.pulsation(from_=(-9 * mm, 0, 17 * mm), to=(-9 * mm, 1, 17 * mm), radius=4 * mm, amplitude=0.5 * mm, time=0.1)
    body.deform(us.compose(artery, us.breathing(amplitude=3 * mm, time=1)))
    draw()
    body.deform(us.indentation(depth=3 * mm))
    draw()
    shift = np.zeros((4, 4, 4, 3))
    shift[..., 2] = np.float32(mm) * np.arange(4, dtype=np.float32)
    body.deform(us.displacement_grid(shift, origin=(-30 * mm, -30 * mm, 0), spacing=3 * [20 * mm]))
    draw()
    whole = us.tetrahedra([(-90 * mm, -90 * mm, -90 * mm), (250 * mm, 0, 0), (0, 250 * mm, 0), (0, 0, 250 * mm)], [[0, 1, 2, 3]])
    whole.nodes[3, 2] = 255 * mm
    body.deform(whole)
    draw()
    body = us.scene(tissue.air)
    body.add(us.make_cylinder((0, -60 * mm, 40 * mm), (0, 60 * mm, 40 * mm), 40 * mm, 256, 64), tissue.muscle)
    body.build()
    at = us.pose([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2 * mm], [0, 0, 0, 1]])
    body.deform(us.press(body, probe, at).deformation)
    pictures.append(us.b_mode(body, probe, at, us.b_mode_settings(depth=50 * mm, size=(160, 0))).pixels)
    equals_cpp("motion", pictures)


def test_vertices_follow_and_return(phantom):
    body = phantom()
    vein, before = body.find("vein"), body.positions(body.find("vein")).copy()
    body.deform(us.pulsation(from_=(-9 * mm, 0, 17 * mm), to=(-9 * mm, 1, 17 * mm), radius=4 * mm, amplitude=0.5 * mm, rate=1, time=0.15))
    now = body.positions(vein)
    axis_distance = np.hypot(now[:, 0] + 9 * mm, now[:, 2] - 17 * mm)
    assert axis_distance[np.hypot(before[:, 0] + 9 * mm, before[:, 2] - 17 * mm) > 3 * mm] == pytest.approx(4.5 * mm, abs=1e-6)  # systole
    assert np.array_equal(body.rest_positions(vein), before)
    with pytest.raises(ValueError):
        body.rest_positions(vein)[:] = 0
    assert body.rest_of((-4.5 * mm, 0, 17 * mm), vein) == pytest.approx((-5 * mm, 0, 17 * mm), abs=1e-6)
    body.deform(us.compose())
    assert np.allclose(body.positions(vein), before, atol=1e-7)


def test_a_function_is_sampled():
    def stretch(rest):
        assert rest.shape == (27, 3) and rest.dtype == np.float32
        return rest * [1, 1, 1.1]

    grid = us.sample_map(stretch, (0, 0, 0), (20 * mm, 20 * mm, 20 * mm), spacing=10 * mm)
    assert grid.size == (3, 3, 3) and grid.displacements.shape == (3, 3, 3, 3)
    points = np.random.default_rng(1).uniform(0, 20 * mm, (5, 7, 3))
    assert grid(points).shape == (5, 7, 3) and np.allclose(grid(points), points * [1, 1, 1.1], atol=1e-7)
    with pytest.raises(us.usage_error, match="given 27 x 3 points, and returned 2 x 3"):
        us.sample_map(lambda rest: rest[:2], (0, 0, 0), (20 * mm, 20 * mm, 20 * mm), spacing=10 * mm)
    with pytest.raises(us.usage_error, match="`lower` must be below `upper`"):
        us.sample_map(stretch, (0, 0, 0), (-20 * mm, 20 * mm, 20 * mm), spacing=10 * mm)
    with pytest.raises(TypeError, match="deform.sample_map.function, lower, upper, spacing"):
        us.scene().build().deform(stretch)
    with pytest.raises(ZeroDivisionError):
        us.sample_map(lambda rest: 1 / 0, (0, 0, 0), (20 * mm, 20 * mm, 20 * mm), spacing=10 * mm)


def test_only_some_objects_follow(phantom):
    body = phantom()
    before = body.box(body.find("bone"))
    body.deform(us.breathing(amplitude=5 * mm, time=2), only=[body.find("vein")])
    assert body.box(body.find("bone")) == before
    assert body.box(body.find("vein"))[0][2] > 17 * mm
    with pytest.raises(us.usage_error, match="no object has the id 77"):
        body.deform(us.breathing(), only=[77])


def test_tetrahedra_are_written_in_place():
    nodes = np.array([(-90, -90, -90), (250, 0, 0), (0, 250, 0), (0, 0, 250)]) * mm
    whole = us.tetrahedra(nodes, [[0, 1, 2, 3]])
    held = whole.nodes
    held[3, 2] += 5 * mm
    assert np.shares_memory(held, whole.nodes)
    assert np.allclose(whole(nodes), held, atol=1e-6)
    del whole
    gc.collect()
    assert held[3, 2] == pytest.approx(255 * mm)
    with pytest.raises(us.geometry_error, match="names node 4, but there are 4"):
        us.tetrahedra(nodes, [[0, 1, 2, 4]])
    body = us.scene(tissue.fat)
    body.add(us.make_sphere((0, 0, 0), 5 * mm), tissue.liver)
    body.build()
    folded = us.tetrahedra(nodes, [[0, 1, 2, 3]])
    folded.nodes[3] = (-300 * mm, -300 * mm, -300 * mm)
    with pytest.raises(us.geometry_error, match="turned inside out"):
        body.deform(folded)


def test_press():
    body = us.scene(tissue.air)
    limb = body.add(us.make_cylinder((0, -60 * mm, 40 * mm), (0, 60 * mm, 40 * mm), 40 * mm, 512, 64), tissue.muscle)
    body.build()
    probe, radius, depth = us.linear_array(lines=96), 40 * mm, 2 * mm
    at = us.pose([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, depth], [0, 0, 0, 1]])
    touch = us.press(body, probe, at, us.press_settings(stiffness=1000))
    sagitta = depth + 0.5 * mm  # lines touch up to the gel
    expected = 2 * np.sqrt(2 * radius * sagitta - sagitta**2) / (38 * mm) * 96
    print(f"{touch.touching} of 96 lines touch, expected {expected:.1f}; {touch.depth / mm:.3f} mm deep")
    assert touch.depth == pytest.approx(depth, abs=1e-5) and touch.touching == pytest.approx(expected, abs=3)
    assert touch.lines.dtype == bool and touch.lines.sum() == touch.touching and touch.lines[48] and not touch.lines[0]
    assert touch.force == pytest.approx(1000 * touch.mean_depth)
    body.deform(touch.deformation)
    assert touch.deformation([0, 0, 0]) == pytest.approx([0, 0, depth - 0.05 * mm], abs=1e-6)
    assert us.press(body, probe, at, only=[]).touching == 0 and body.find("") == limb
    with pytest.raises(us.usage_error, match="press: the face is .* mm deep in the body, more than `decay`, 20 mm"):
        us.press(body, probe, us.pose([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 25 * mm], [0, 0, 0, 1]]))


def test_bone_stays_under_a_probe_that_presses():
    body = us.scene(tissue.air)
    skin = body.add(us.make_box((-60 * mm, -40 * mm, 0), (60 * mm, 40 * mm, 60 * mm), 5), tissue.muscle)
    bone = body.add(us.make_box((-50 * mm, -30 * mm, 15 * mm), (50 * mm, 30 * mm, 25 * mm), 5), tissue.bone)
    body.build()
    at, how = us.pose(translation=(0, 0, 3 * mm)), us.press_settings(decay=20 * mm)
    soft, touch = (us.press(body, us.linear_array(), at, how, is_stiff=stiff).deformation for stiff in ([], [bone]))
    assert touch.stop.shape == (17, 45) and np.allclose(touch.stop, np.exp(-15 / 20), rtol=1e-4) and not soft.stop.any()
    assert np.shares_memory(touch.stop, touch.stop)
    body.deform(soft)
    assert np.abs(body.positions(bone) - body.rest_positions(bone)).max() > 1 * mm
    body.deform(touch)
    assert np.allclose(body.positions(bone), body.rest_positions(bone), atol=0.01 * mm)  # skin lies 0.05 mm behind the face
    assert (body.positions(skin) - body.rest_positions(skin))[:, 2].max() == pytest.approx(3 * mm, abs=0.06 * mm)
    with pytest.raises(us.usage_error, match="the tissue gives way above what is stiff 15 mm below the skin"):
        us.press(body, us.linear_array(), us.pose(translation=(0, 0, 12 * mm)), is_stiff=[bone])


def test_a_vein_collapses_under_the_pressure_of_the_probe():
    body = us.scene(tissue.air)
    body.add(us.make_box((-60 * mm, -40 * mm, 0), (60 * mm, 40 * mm, 60 * mm), 5), tissue.muscle)
    vein = body.add(us.make_cylinder((0, -30 * mm, 17 * mm), (0, 30 * mm, 17 * mm), 4.5 * mm, 64, 16), tissue.blood)
    body.build()
    before = body.positions(vein).copy()
    probe = us.linear_array()
    touch = us.press(body, probe, us.pose(translation=(0, 0, 2 * mm)), us.press_settings(stiffness=110))
    assert touch.pressure == pytest.approx(110 * 2 * mm / (probe.width * probe.elevation_height), rel=1e-3)
    closed = us.collapse(from_=(0, 0, 17 * mm), to=(0, 1, 17 * mm), radius=4.5 * mm, outside=touch.pressure, inside=8 * us.mmHg)
    opening = (1 + (touch.pressure - 8 * us.mmHg) / closed.stiffness) ** (-2 / 3)  # Shapiro 1977
    print(f"{touch.pressure / us.mmHg:.1f} mmHg: the vein is {9 * opening:.1f} of 9 mm high")
    assert 0.1 < opening < 0.9 and closed.opening == pytest.approx(opening, rel=1e-4)
    body.deform(us.compose(closed))
    now = body.positions(vein)
    assert np.ptp(now[:, 2]) == pytest.approx(opening * np.ptp(before[:, 2]), rel=1e-3) and np.ptp(now[:, 0]) == pytest.approx(9 * mm, rel=1e-3)
    body.deform(us.compose(closed, touch.deformation))
    assert body.rest_of(tuple(body.positions(vein)[3]), vein) == pytest.approx(tuple(before[3]), abs=2e-6)


def test_an_object_that_is_inside_out_is_found(phantom):
    body = phantom()
    bone = body.find("bone")
    body.positions(bone)[:, 0] *= -1
    body.update()
    assert body.is_inside_out(bone) and not body.is_inside_out(body.find("vein"))


def test_errors_keep_their_sentences(phantom):
    body = phantom()
    with pytest.raises(us.usage_error, match="pulsation: `from` and `to`"):
        body.deform(us.pulsation(amplitude=1))
    with pytest.raises(us.geometry_error, match="folds over"):
        body.deform(us.sample_map(lambda rest: -rest, (-20 * mm, -20 * mm, 0), (20 * mm, 20 * mm, 40 * mm), spacing=10 * mm))
    with pytest.raises(TypeError, match="compose: not a map: 3"):
        us.compose(us.breathing(), 3)
    with pytest.raises(us.usage_error, match="nodes along z, y and x"):
        us.displacement_grid(np.zeros((2, 3)), origin=(0, 0, 0), spacing=(1, 1, 1))


def test_memory_does_not_grow_where_a_body_moves(phantom, resident):
    body, machine = phantom(), us.scanner(us.linear_array(lines=8), us.b_mode_settings(depth=10 * mm, size=(16, 0), planes=1))
    for frame in range(400):
        body.deform(us.compose(us.breathing(time=0.01 * frame), us.pulsation(time=0.01 * frame)))
        body.positions(0), body.rest_positions(0)
        machine.scan(body, us.pose(), policy="unseq")
        if frame == 100:
            before = resident()
    assert resident() - before < 4 << 20
