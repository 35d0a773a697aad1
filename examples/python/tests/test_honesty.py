"""Nothing fails in silence: what would change nothing, or lose numbers, is an error; what is held stays in use."""
import copy
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import insonify as us
from insonify import MHz, mm, tissue


def slab():
    body = us.scene(tissue.fat)
    ball = body.add(us.make_sphere((0, 0, 15 * mm), 5 * mm), tissue.blood)
    return body.build(), ball


def picture(body):
    return us.b_mode(body, us.linear_array(lines=32), us.pose(), us.b_mode_settings(depth=30 * mm, size=(48, 48), planes=1))


def test_positions_that_are_held_move_the_scene_at_every_update():
    held, ball = slab()
    asked, _ = slab()
    vertices = held.positions(ball)
    lateral = held.positions(ball)[:, 0]  # a part of an array that nobody else holds
    for frame in range(4):
        vertices[:, 2] += 1 * mm
        lateral += 0.5 * mm
        held.update()
        fresh = asked.positions(ball)
        fresh += np.float32([0.5 * mm, 0, 1 * mm])
        del fresh
        asked.update()
        assert picture(held) == picture(asked), frame
        assert held.box(ball)[0][2] == pytest.approx((11 + frame) * mm, abs=1e-6)


def test_an_array_that_is_read_only_is_not_written():
    body, ball = slab()
    rest = body.rest_positions(ball)
    body.update()
    with pytest.raises(ValueError):
        rest[0] = 0


def test_sequences_of_settings_refuse_changes_that_would_be_lost():
    how = us.b_mode_settings()
    with pytest.raises(TypeError):
        how.time_gain.sliders[0] = 5
    with pytest.raises(AttributeError):
        how.time_gain.curve.append(us.tgc_point(depth=1 * mm, gain_db=3))
    how.time_gain.sliders = [5, 0, 0, 0, 0, 0, 0, 0]
    how.time_gain.curve = [us.tgc_point(depth=1 * mm, gain_db=3)]
    assert how.time_gain.sliders == (5, 0, 0, 0, 0, 0, 0, 0)
    with pytest.raises(AttributeError, match="make another one"):
        how.time_gain.curve[0].gain_db = 7
    body, ball = slab()
    for read_only in (body.names, body.media):
        with pytest.raises(TypeError):
            read_only[ball] = "heart"
    assert body.media[ball] == tissue.blood


def test_constants_refuse_changes():
    with pytest.raises(AttributeError, match="copy.copy"):
        tissue.muscle.structure.wave = 3
    with pytest.raises(AttributeError, match="copy.copy"):
        tissue.muscle.structure.sheets.level_db = 3
    with pytest.raises(AttributeError, match="copy.copy"):
        tissue.muscle.attenuation = 3
    with pytest.raises(AttributeError, match="copy.copy"):
        us.presets.l11_5v.lines = 3
    mine = copy.copy(tissue.muscle)
    mine.structure.sheets.level_db = 30
    assert mine != tissue.muscle and tissue.muscle == tissue.find("muscle")


@pytest.mark.parametrize("wrong", [lambda: us.mesh(np.zeros((3, 3)), [(0, 1, 2.5)]), lambda: us.mesh(np.zeros((3, 3)) * 1j, [(0, 1, 2)]),
                                   lambda: us.pose(np.eye(4) * (1 + 0j)), lambda: us.scan_lines(np.ones((2, 2)) * 1j, depth=1),
                                   lambda: us.label_lines([[0.5]], depth=1), lambda: us.label_lines([[-1]], depth=1),
                                   lambda: us.image(np.full((2, 2), np.nan)), lambda: us.colour_image(np.full((2, 2, 3), np.inf)),
                                   lambda: us.write_png("nan.png", np.full((2, 2), np.nan)),
                                   lambda: us.make_sphere((0, 0, 0), 1 * mm) and us.breathing()(np.zeros((2, 3)) * 1j)])
def test_numbers_that_would_be_lost_are_refused(wrong, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(us.usage_error):
        wrong()
    assert not list(tmp_path.iterdir())


def test_a_picture_that_was_written_into_is_checked(tmp_path):
    seen = us.image(np.zeros((2, 2)))
    seen.pixels[0, 0] = np.nan
    with pytest.raises(us.usage_error, match="finite"):
        us.write_png(tmp_path / "nan.png", seen)


def test_whole_numbers_are_not_cut():
    probe, how = us.linear_array(), us.b_mode_settings()
    for number in (64.5, np.float32(64.5), np.float64(64)):
        with pytest.raises(TypeError, match="`lines` of linear_array cannot be"):
            probe.lines = number
        with pytest.raises(TypeError):
            how.size = (number, 64)
    probe.lines, how.size = np.int32(64), np.array([64, 32])
    assert probe.lines == 64 and how.size == (64, 32)
    assert len(us.mesh(np.zeros((3, 3)), np.array([[0.0, 1.0, 2.0]])).faces) == 1  # whole, as np.loadtxt gives them


@pytest.mark.parametrize("number", [2.5, np.float32(2.5), np.float64(2), np.complex64(2), "2", None], ids=repr)
@pytest.mark.parametrize("call", [lambda number: us.make_sphere((0, 0, 0), 1 * mm, number), us.needle_diameter, lambda number: us.scene().add(us.make_sphere((0, 0, 0), 1 * mm), tissue.blood, priority=number),
                                  lambda number: slab()[0].place(number, us.pose()), lambda number: us.scanner(us.linear_array()).show(number),
                                  lambda number: us.scanner(us.linear_array()).cine[number], lambda number: setattr(us.scanner(us.linear_array()), "cine_length", number),
                                  lambda number: us.physical(seed=number), lambda number: setattr(us.b_mode_settings(), "size", (64, number)), lambda number: us.doppler_spectrum.velocity(number)])
def test_whole_arguments_are_not_cut(call, number):
    with pytest.raises(TypeError):
        call(number)


def test_whole_numbers_of_numpy_are_taken():
    for number in (np.int8(2), np.uint64(2), np.array(2), True + np.int32(1)):
        assert len(us.make_sphere((0, 0, 0), 1 * mm, number).faces) == 20 * 4**2
    assert us.needle_diameter(np.uint16(22)) == us.needle_diameter(22)
    for wrong in (-1, 2**32, 10**30):  # not of 32 bits
        with pytest.raises(TypeError):
            us.make_sphere((0, 0, 0), 1 * mm, wrong)
    assert us.electronic_noise_settings(seed=2**64 - 1).seed == 2**64 - 1


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("number", [1 + 1j, np.complex64(1 + 1j), np.complex128(1 + 1j), np.array(1 + 1j)], ids=repr)
def test_imaginary_parts_are_not_dropped(number):
    for call in (lambda: us.make_sphere((0, 0, 0), number), lambda: us.linear_array(frequency=number), lambda: us.make_sphere((0, number, 0), 1 * mm)):
        with pytest.raises(TypeError):
            call()
    assert us.linear_array(frequency=np.float64(2e6)).frequency == us.linear_array(frequency=np.array([2000000])).frequency == 2e6


def test_meshes_lines_and_pictures_are_pickled():
    ball = us.make_sphere((0, 0, 0), 1 * mm)
    again = pickle.loads(pickle.dumps(ball))
    assert np.array_equal(again.positions, ball.positions) and np.array_equal(again.faces, ball.faces)
    body, _ = slab()
    machine = us.scanner(us.linear_array(lines=32), us.b_mode_settings(depth=30 * mm, size=(40, 40)))
    machine.scan(body, us.pose())
    for one in (machine.picture, machine.labels(body), machine.lines, machine.echoes, us.colour_image(np.ones((2, 3, 3)))):
        assert pickle.loads(pickle.dumps(one)) == one


def test_threads_and_policies():
    body, _ = slab()
    probe, how = us.linear_array(lines=32), us.b_mode_settings(depth=30 * mm, size=(40, 40))
    one = us.b_mode(body, probe, us.pose(), how)
    assert us.b_mode(body, probe, us.pose(), how, policy="par_unseq.threads(2)") == one
    for wrong in ("seq.threads(2)", "par.threads(0)", "par.threads(x)", "par.threads(2", "parallel"):
        with pytest.raises(us.usage_error, match="policy"):
            us.b_mode(body, probe, us.pose(), how, policy=wrong)


def test_rf_of_echoes():
    samples = 4096
    echoes = us.iq_lines(np.ones((1, samples)), depth=20 * mm)
    rf = us.to_rf(echoes, 5 * MHz).values[0]
    depth = (np.arange(samples) + 0.5) * 20 * mm / samples
    assert np.allclose(rf, np.cos(4 * np.pi * 5e6 * depth / 1540), atol=1e-3)


def test_ctrl_c_ends_a_call():
    body = us.scene(tissue.muscle).build()
    how = us.b_mode_settings(depth=150 * mm, planes=7, compound=us.compound_settings(angles=31))
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            us.b_mode(body, us.linear_array(lines=512), us.pose(), how)
    answered = time.perf_counter() - begin - 0.5
    timer.join()
    begin = time.perf_counter()
    us.b_mode(body, us.linear_array(lines=512), us.pose(), how)  # still works, and takes longer than the answer
    assert answered < 0.5 * (time.perf_counter() - begin)


def test_quality():
    body, _ = slab()
    probe, how = us.linear_array(), us.b_mode_settings(depth=30 * mm, size=(128, 128))
    work = {}
    for how.quality in ("full", "fast", "draft"):
        traced = us.sampling_of(probe, how)
        work[how.quality] = traced.lines * traced.planes * traced.looks
        machine = us.scanner(probe, how)
        assert machine.scan(body, us.pose()) == us.b_mode(body, probe, us.pose(), how)
        assert machine.lines.count == traced.lines and machine.lines.samples == traced.samples
    assert work["full"] > 4 * work["fast"] > 8 * work["draft"]
    with pytest.raises(us.usage_error, match="one of full, fast, draft"):
        how.quality = "ultra"


FOLDER = pathlib.Path(__file__).resolve().parent.parent


def test_the_stub_is_that_of_the_module():
    written = subprocess.run([sys.executable, FOLDER / "make_stubs.py"], check=True, capture_output=True, text=True).stdout
    assert written == (FOLDER / "insonify.pyi").read_text()


def test_the_stub_and_the_examples_pass_mypy(tmp_path):
    pytest.importorskip("mypy")
    wrong = tmp_path / "wrong.py"
    lines = ['us.linear_array(frequency="high")', "us.b_mode_settings().time_gain.sliders[0] = 5", 'us.make_sphere((0, 0, 0), "1 mm")',
             "us.scanner(us.linear_array()).picture = None"]
    wrong.write_text("\n".join(["import insonify as us", *lines]))

    def check(*files):
        return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--cache-dir", tmp_path / "cache", *files], cwd=FOLDER,
                              env={**os.environ, "MYPYPATH": str(FOLDER)}, capture_output=True, text=True)

    right = check("insonify.pyi", "ten_lines.py", "figure.py")
    assert right.returncode == 0, right.stdout
    found = check(wrong).stdout
    for number in range(2, 2 + len(lines)):
        assert f"wrong.py:{number}: error" in found, found
