"""The module as its users see it: meshes, pictures, stages, settings."""
import ast
import copy
import gc
import pathlib
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import insonify as us
from insonify import MHz, mm, tissue

FOLDER = pathlib.Path(__file__).resolve().parent.parent


def settings(**changed):
    return us.b_mode_settings(depth=50 * mm, size=(160, 0), **changed)


PROBES = [us.linear_array(lines=96), us.convex_array(lines=96), us.phased_array(lines=96)]


def test_pictures_equal_those_of_cpp_bit_for_bit(phantom, equals_cpp):
    probes = [*PROBES, us.radial_array(lines=96, frequency=5 * MHz)]
    equals_cpp("pictures", [us.b_mode(phantom(), probe, us.pose(), settings()).pixels for probe in probes])


@pytest.mark.parametrize("probe", PROBES, ids=lambda probe: type(probe).__name__)
def test_the_picture_shows_bone_and_its_shadow(probe, phantom):
    body, how = phantom(), settings()
    picture = us.b_mode(body, probe, us.pose(), how)
    grid = us.make_scan_map(probe, us.acquisition(depth=how.depth), us.scan_convert_settings(size=how.size))
    assert picture.pixels.shape == (grid.size[1], grid.size[0])
    top, shadow = (grid.pixel((6 * mm, z)) for z in (22 * mm, 45 * mm))
    around = lambda at: picture.pixels[int(at[1]) - 3 : int(at[1]) + 3, int(at[0]) - 3 : int(at[0]) + 3]
    assert around(top).max() > 0.7 and around(shadow).mean() < 0.2
    assert grid.point(grid.pixel((3 * mm, 20 * mm))) == pytest.approx((3 * mm, 20 * mm), abs=1e-6)


def test_examinations_are_pairs_of_a_probe_and_its_settings(phantom):
    for probe, how in (us.presets.nerve_block, us.presets.abdomen, us.presets.heart):
        assert how.grey == us.presets.clinical_grey
        how.depth, how.size, how.planes = 50 * mm, (160, 0), 1
        assert us.b_mode(phantom(), probe, us.pose(), how).pixels.max() > 0.8
    assert us.presets.heart[1].planes == 5  # copies: what was changed above was not the preset


def test_the_stages_give_the_picture(phantom):
    body, probe, how = phantom(), us.linear_array(lines=96), settings(tgc=50, noise=us.noise_level(level_db=us.no_level_db))
    scan = us.acquisition(depth=how.depth, planes=how.planes)
    echoes = us.trace(body, probe, us.pose(), us.physical(), scan)
    assert echoes.values.dtype == np.complex64 and echoes.values.shape == (96, echoes.samples)
    lines = us.envelope(us.convolve(echoes, probe))
    assert np.allclose(lines.values, np.abs(us.convolve(echoes, probe).values), rtol=1e-5)
    lines = us.log_compress(us.tgc(lines, probe.frequency))
    grid = us.make_scan_map(probe, scan, us.scan_convert_settings(size=how.size))
    assert us.scan_convert(lines, grid).pixels.shape == us.b_mode(body, probe, us.pose(), how).pixels.shape


def test_arrays_are_views_and_keep_their_owner(phantom):
    picture = us.b_mode(phantom(), PROBES[0], us.pose(), settings())
    pixels = picture.pixels
    assert np.shares_memory(pixels, picture.pixels) and np.shares_memory(pixels, np.asarray(picture))
    before = pixels.copy()
    del picture
    gc.collect()
    assert np.array_equal(pixels, before)


def test_lines_are_made_of_arrays():
    values = np.random.default_rng(1).normal(size=(4, 64)).astype(np.float32)
    lines = us.scan_lines(values, depth=40 * mm)
    assert np.array_equal(lines.values, values) and not np.shares_memory(lines.values, values)
    with pytest.raises(us.usage_error, match="a row for each line"):
        us.scan_lines(values[0], depth=40 * mm)


def test_vertices_are_written_in_place(phantom):
    body = phantom()
    first = us.b_mode(body, PROBES[0], us.pose(), settings()).pixels.copy()
    bone = body.find("bone")
    body.positions(bone)[:, 2] += 3 * mm
    body.update()
    moved = us.b_mode(body, PROBES[0], us.pose(), settings()).pixels
    column = 160 * 25 // 38
    assert moved[:, column].argmax() - first[:, column].argmax() == pytest.approx(3 / 38 * 160, abs=1.5)
    held = body.positions(bone)[:10]
    with pytest.raises(us.usage_error, match="still in use"):
        body.remove(bone)
    assert np.isfinite(held).all()
    del held
    gc.collect()
    body.remove(bone)
    assert list(body.build().names.values()) == ["vein"]


def test_meshes_of_arrays():
    sphere = us.make_sphere((0, 0, 0), 1 * mm)
    again = us.mesh(sphere.positions.astype(np.float64), sphere.faces.astype(np.int32))
    assert np.array_equal(again.faces, sphere.faces) and np.allclose(again.positions, sphere.positions)
    assert us.validate(again) == ""
    assert us.validate(us.mesh(sphere.positions, sphere.faces[1:])) != ""
    with pytest.raises(us.geometry_error, match="names vertex 7, but the mesh has 3"):
        us.mesh(np.zeros((3, 3)), [[0, 1, 7]])
    with pytest.raises(us.usage_error, match="N x 3 positions"):
        us.mesh(np.zeros((3, 2)), [[0, 1, 2]])


def test_poses():
    at = us.look_at((0, -40 * mm, 0), (0, 0, 0), (1, 0, 0))
    assert np.allclose(at.matrix[:3, 2], (0, 1, 0)) and np.allclose(at.matrix[:3, 3], (0, -40 * mm, 0))
    assert us.pose(at.matrix) == at
    assert np.allclose((us.inverse(at) @ at).matrix, np.eye(4), atol=1e-6)
    with pytest.raises(us.geometry_error):
        us.pose(2 * np.eye(4))


def test_ground_truth_overlays_the_picture(phantom):
    body, probe = phantom(), us.linear_array(lines=128)
    truth = us.ground_truth(body, probe, us.pose(), us.label_settings(depth=50 * mm, grid="displayed"))
    assert set(np.unique(truth.label.values)) == {0, 1, us.background_label}
    middle = int((6 / 38 + 0.5) * 128)
    top = np.flatnonzero(truth.surface.values[middle] == body.find("bone"))[0]
    depth = (top + 0.5) / truth.label.samples * 50
    picture = us.b_mode(body, probe, us.pose(), us.b_mode_settings(depth=50 * mm, size=(380, 500))).pixels
    column = 380 * (6 + 19) // 38
    assert picture[:, column].argmax() / 10 == pytest.approx(depth, abs=0.15)  # the middle of the pulse, in mm
    assert truth.incidence.values[middle, top] < 0.1


def test_policies(phantom):
    body = phantom()
    one, two = (us.b_mode(body, PROBES[0], us.pose(), settings(), policy=name) for name in ("unseq", "par_unseq"))
    assert np.array_equal(one.pixels, two.pixels)
    with pytest.raises(us.usage_error, match="no policy 'fast'; known are seq, par"):
        us.b_mode(body, PROBES[0], us.pose(), settings(), policy="fast")


def test_errors_keep_their_sentences(phantom):
    assert issubclass(us.usage_error, ValueError) and issubclass(us.io_error, OSError)
    with pytest.raises(us.usage_error, match="call build"):
        us.b_mode(us.scene(), PROBES[0], us.pose())
    with pytest.raises(us.usage_error, match="did you mean"):
        us.b_mode(phantom(), PROBES[0], us.pose(), us.b_mode_settings(depth=50))
    with pytest.raises(us.io_error, match="nowhere.obj"):
        us.load_obj_scene("nowhere.obj", unit=mm)
    with pytest.raises(us.usage_error, match="dimensions|row"):
        us.scan_lines(np.zeros(3), depth=1 * mm)


def test_settings():
    probe = us.linear_array(lines=96, frequency=5 * MHz)
    assert eval(repr(probe), vars(us)) == probe
    other = copy.deepcopy(probe)
    other.lines = 48
    assert other != probe and probe.lines == 96
    how = us.b_mode_settings()
    how.compound.angles = 3
    how.compound.update = "one"
    assert how.compound == us.compound_settings(angles=3, update="one")
    with pytest.raises(TypeError, match="no setting 'width_mm'; it has lines"):
        us.linear_array(width_mm=38)
    with pytest.raises(AttributeError, match="no setting 'dpeth'"):
        how.dpeth = 3
    with pytest.raises(TypeError, match="`lines` of linear_array cannot be 9.5; it is of the kind of 96"):
        probe.lines = 9.5
    with pytest.raises(us.usage_error, match="one of all, one"):
        how.compound.update = "two"
    changed = copy.copy(tissue.muscle)
    changed.structure.sheets.level_db = 30
    assert changed != tissue.muscle


def test_other_threads_run_while_a_picture_is_drawn(phantom):
    body, counted, done = phantom(), [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    longest, last, begin = 0, 0, time.perf_counter()
    while time.perf_counter() < begin + 0.5:
        us.b_mode(body, us.linear_array(), us.pose(), us.b_mode_settings(depth=60 * mm, planes=7), policy="unseq")
        longest, last = max(longest, counted[0] - last), counted[0]
    done.set()
    counter.join()
    assert longest >= 3  # milliseconds of another thread within one picture


def test_memory_does_not_grow_over_10000_frames(phantom, resident):
    body, probe = phantom(), us.linear_array(lines=8)
    how = us.b_mode_settings(depth=10 * mm, size=(16, 0), planes=1)
    for frame in range(10000):
        how.frame = frame
        pixels = us.b_mode(body, probe, us.pose(), how, policy="unseq").pixels
        body.positions(0)
        body.update("seq")
        if frame == 1000:
            before = resident()
    assert pixels.size and resident() - before < 4 << 20


def test_stubs_are_fresh():
    written = subprocess.run([sys.executable, FOLDER / "make_stubs.py"], capture_output=True, text=True, check=True).stdout
    assert written == (FOLDER / "insonify.pyi").read_text(), "run make_stubs.py"
    ast.parse(written)


@pytest.mark.parametrize("script", ["ten_lines.py", "figure.py"])
def test_examples(script, tmp_path):
    if script == "figure.py":
        pytest.importorskip("matplotlib")
    subprocess.run([sys.executable, FOLDER / script], cwd=tmp_path, check=True)
    assert (tmp_path / script).with_suffix(".png").stat().st_size > 10000
