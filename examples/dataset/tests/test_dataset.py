"""The generator as its users run it. DATASET names the program, MPIEXEC the launcher."""
import hashlib
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

PROGRAM = os.environ["DATASET"]
MPIEXEC = os.environ.get("MPIEXEC", "mpiexec")
QUICK = ["--size", "64", "--lines", "48", "--planes", "1", "--part", "4", "--needle", "0.5", "--bend", "0..2", "--pressure", "0..3"]
SMALL = [*QUICK, "--samples", "24"]


def run(folder, *options, ranks=1, check=True):
    launcher = [] if ranks == 1 else [MPIEXEC, "--oversubscribe", "-n", str(ranks)]
    done = subprocess.run([*launcher, PROGRAM, "--output", "out", *options], cwd=folder, capture_output=True, text=True, timeout=300)
    if check:
        assert done.returncode == 0, done.stderr
    return done


def hashes(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted((folder / "out").glob("*.h5"))}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(folder, *SMALL)
    return folder


def test_one_file_stands_for_all_parts(whole):
    with h5py.File(whole / "out" / "dataset.h5") as file:
        assert file["data/image_sc"].shape == (24, 64, 64) and file["data/image_sc"].dtype == np.uint8
        assert list(file["insonify/number"]) == list(range(24))
        images = file["data/image_sc"][:]
        assert (images.reshape(24, -1).std(axis=1) > 5).all()  # no image is empty
        names = file.attrs["label_names"].split("\n")
        assert names[0] == "background" and "needle" in names and len(set(names)) == len(names)
        labels = file["insonify/label"][:]
        assert set(np.unique(labels)) <= set(range(len(names))) | {255}
        for name in ("data/image_sc", "insonify/incidence", "insonify/frequency"):
            assert file[name].attrs["unit"] and file[name].attrs["description"]
        needles = file["insonify/needle"][:] == 1
        assert 0 < needles.sum() < 24
        assert not (labels[~needles] == names.index("needle")).any()
    with h5py.File(whole / "out" / "part-000000.h5") as file:
        for name in ("n_frames", "n_tx", "n_el", "n_ax", "n_ch", "center_frequency", "sampling_frequency", "probe_geometry", "initial_times"):
            assert name in file["scan"]
        assert file["scan/n_frames"][()] == 4 and file["scan/center_frequency"][()] == 7.5e6


@pytest.mark.parametrize("ranks", [2, 4])
def test_the_number_of_ranks_changes_no_bit(whole, tmp_path, ranks):
    run(tmp_path, *SMALL, ranks=ranks)
    assert hashes(tmp_path) == hashes(whole)


def test_killed_at_any_time_it_goes_on_where_it_was(whole, tmp_path):
    chance = random.Random(1)
    for _ in range(10):
        running = subprocess.Popen([PROGRAM, "--output", "out", *SMALL], cwd=tmp_path, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.05, 0.8))
        running.send_signal(signal.SIGKILL)
        running.wait()
        for part in (tmp_path / "out").glob("part-*.h5"):
            with h5py.File(part) as file:  # a part that is there is whole
                assert file["data/image_sc"].shape[0] == 4
    run(tmp_path, *SMALL)
    assert hashes(tmp_path) == hashes(whole)
    assert not list((tmp_path / "out").glob("*draft*"))


def write_balls(path, factor=1, /, **radii):
    """Balls of a tissue each, in millimetres times a factor, around a point 40 mm below the origin."""
    rings, around, text, written = 48, 96, [], 0
    theta, phi = np.meshgrid(np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(around) / around, indexing="ij")
    for name, radius in radii.items():
        points = radius * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
        points = np.concatenate([points, [[0, 0, radius], [0, 0, -radius]]]) + [0, 0, 40]
        faces = []
        for i in range(around):
            j = (i + 1) % around
            faces.append((len(points) - 2, i, j))
            faces.append((len(points) - 1, (rings - 2) * around + j, (rings - 2) * around + i))
            for ring in range(rings - 2):
                a, b = ring * around + i, ring * around + j
                faces += [(a, a + around, b + around), (a, b + around, b)]
        text += ["o " + name, "usemtl " + name] + ["v %.9g %.9g %.9g" % tuple(factor * p) for p in points]
        text += ["f %d %d %d" % tuple(v + 1 + written for v in f) for f in faces]
        written += len(points)
    path.write_text("\n".join(text) + "\n")


@pytest.mark.parametrize("plan", [[], ["--plan"]], ids=["run", "plan"])
@pytest.mark.parametrize(
    "factor, unit, sentence",
    [
        (1e-3, "1mm", "the body is 0.03 mm large; is the file in metres? --unit 1m"),
        (1, "1m", "the body is 3e+04 mm large; is the file in millimetres? --unit 1mm"),
        (0.11, "1m", "the body is 3300 mm large; is the file in centimetres? --unit 1cm"),
        (1e-6, "1mm", "the body is 3e-05 mm large; give the unit of the file, such as --unit 1mm"),
    ],
)
def test_a_body_of_unlikely_size_is_refused(tmp_path, factor, unit, sentence, plan):
    write_balls(tmp_path / "balls.obj", factor, bone=15)
    done = run(tmp_path, "--anatomy", "balls.obj", "--unit", unit, "--samples", "1", *plan, check=False)
    assert done.returncode != 0 and "balls.obj: " + sentence in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("plan", [[], ["--plan"]], ids=["run", "plan"])
def test_an_open_mesh_is_refused(tmp_path, plan):
    write_balls(tmp_path / "balls.obj", bone=15)
    text = (tmp_path / "balls.obj").read_text().splitlines()
    (tmp_path / "balls.obj").write_text("\n".join(text[:-7]) + "\n")
    done = run(tmp_path, "--anatomy", "balls.obj", "--samples", "1", *plan, check=False)
    assert done.returncode != 0 and "balls.obj: object 'bone': The surface is open along" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("options", [[], ["--bend", "0..3", "--pressure", "0..4"]], ids=["default", "bent and pressed"])
def test_the_sides_of_the_phantom_are_outside_of_the_images(tmp_path, options):
    """Within the field of view there is no background, and gel and skin only near the face."""
    run(tmp_path, "--samples", "100", "--part", "100", "--size", "128", "--lines", "64", "--planes", "1", *options)
    with h5py.File(tmp_path / "out" / "part-000000.h5") as file:
        names = file.attrs["label_names"].split("\n")
        labels, depths = file["insonify/label"][:], 1e3 * file["insonify/depth"][:]
    for name, deepest in (("background", 0), ("gel", 4), ("skin", 6)):  # mm
        below = (labels == names.index(name)) & (depths > deepest)
        seen = np.flatnonzero(below.any(axis=(1, 2)))
        assert not len(seen), f"{name} deeper than {deepest} mm in the samples {seen}"


@pytest.mark.parametrize("pressed", [False, True])
def test_labels_overlay_the_image(tmp_path, pressed):
    """The edge of bone lies within 1 pixel of the label's border, at normal incidence."""
    if pressed:
        write_balls(tmp_path / "balls.obj", blood=45, bone=20)
        place = ["--around", "blood", "--pressure", "2..6", "--along", "-4..4", "--across", "-4..4"]
    else:
        write_balls(tmp_path / "balls.obj", bone=15)
        place = ["--around", "bone", "--standoff", "10..20"]
    run(tmp_path, "--anatomy", "balls.obj", "--background", "water", *place, "--size", "256", "--samples", "8", "--part", "8",
        "--spread", "0..10", "--turn", "-90..90", "--gain", "-30", "--planes", "1")
    with h5py.File(tmp_path / "out" / "part-000000.h5") as file:
        bone = file.attrs["label_names"].split("\n").index("bone")
        off = []
        for image, label, incidence in zip(file["data/image_sc"], file["insonify/label"], file["insonify/incidence"]):
            for column in np.flatnonzero((label == bone).any(axis=0)):
                top = np.flatnonzero(label[:, column] == bone)[0]
                if 0 < incidence[max(0, top - 2) : top + 3, column].max() < 0.1:  # rad; 0: no surface in these pixels
                    bright = image[:, column].astype(float)
                    bright[: max(0, top - 20)] = 0  # above it is the echo of skin
                    rows = np.flatnonzero(bright >= bright.max())  # the pulse is symmetric: its middle is the surface
                    off.append(rows.mean() + 0.5 - top)  # top is the upper edge of the label's first row
        print(f"{len(off)} columns, the edge is {np.mean(off):.2f} pixels below the border, rms {np.std(off):.2f}, at most {np.abs(off).max():.2f}")
        assert len(off) > 50 and np.abs(off).max() <= 1


def test_pressed_tissue_yields(tmp_path):
    """Bone 25 mm below the skin gives way by exp(-25 / 20) of what the skin does: depth, label and image agree on it."""
    write_balls(tmp_path / "balls.obj", blood=45, bone=20)
    straight = [f"--{name}=0" for name in ("spread", "along", "across", "tilt", "rock", "turn", "standoff")]
    for pressure in (0, 3, 6):
        folder = tmp_path / str(pressure)
        folder.mkdir()
        run(folder, "--anatomy", "../balls.obj", "--background", "water", "--around", "blood", "--planes", "1", "--samples", "1",
            "--pressure", str(pressure), *straight)
        with h5py.File(folder / "out" / "dataset.h5") as file:
            assert file["insonify/pressure"][0] == pressure
            label, depth = file["insonify/label"][0][:, 128], 1e3 * file["insonify/depth"][0][:, 128]
            top = np.flatnonzero(label == file.attrs["label_names"].split("\n").index("bone"))[0]
            border = depth[top - 1] + (depth[top - 1] - depth[top - 2]) / 2  # the lower edge of the last row above
            expected = 25 - pressure + max(0, pressure - 0.05) * np.exp(-25 / 20)
            print(f"pressed by {pressure} mm, bone is {border:.2f} mm below the face, expected {expected:.2f}")
            assert border == pytest.approx(expected, abs=0.16)  # a row
            assert (label[2:100] == file.attrs["label_names"].split("\n").index("blood")).all()  # no gap to the skin


def test_png_beside_json(tmp_path):
    run(tmp_path, *SMALL, "--format", "png")
    texts = sorted((tmp_path / "out").glob("part-*/*.json"))
    assert len(texts) == 24
    one = json.loads(texts[5].read_text())
    assert one["number"] == 5 and one["frequency"] == 7.5 and 0 <= one["pressure"] <= 3 and "needle" in one["labels"]
    assert texts[5].with_suffix(".png").read_bytes()[:4] == b"\x89PNG"


def test_options_from_a_file(tmp_path):
    (tmp_path / "what.ini").write_text("samples = 2\nsize = 32\nlines = 32\nfrequency = 5..9\nplanes = 1\n")
    run(tmp_path, "--config", "what.ini")
    with h5py.File(tmp_path / "out" / "dataset.h5") as file:
        assert file["data/image_sc"].shape == (2, 32, 32) and 5 <= file["insonify/frequency"][0] <= 9


def test_plan(tmp_path):
    told = run(tmp_path, *SMALL, "--plan").stdout
    assert "24 samples of 64 x 64 pixels in 6 parts" in told and "MB on disk" in told
    assert re.search(r"pressure: 0\.\d+ to 2\.\d+ mm\n", told) and "focus: 15" in told and "frequency:" not in told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "options, sentence",
    [
        (["--frequency", "9..5"], "runs backwards"),
        (["--frequency", "nine"], "--frequency: 'nine' is neither a number nor a range; a range is written with two dots"),
        (["--frequency", "6-9"], "--frequency: '6-9' is neither a number nor a range; a range is written 6..9"),
        (["--tilt", "-9--5"], "a range is written -9..-5"),
        (["--anatomy", "nowhere.obj"], "no file 'nowhere.obj'"),
        (["--around", "knee"], "no object 'knee'; it has"),
        (["--needle", "2"], "from 0 to 1"),
        (["--planes", "2"], "1, 3, 5 or 7"),
        (["--pressure", "6..2"], "--pressure: 6..2 runs backwards"),
        (["--pressure", "0..30"], "--pressure: must be from 0 to 20"),
        (["--config", "nowhere.ini"], "nowhere.ini"),
        (["--bogus"], "bogus"),
    ],
)
def test_bad_options_give_a_sentence(tmp_path, options, sentence):
    done = run(tmp_path, *options, check=False)
    assert done.returncode != 0 and sentence in done.stderr + done.stdout
    assert not (tmp_path / "out").exists()


def test_another_description_is_refused(whole):
    done = run(whole, *SMALL, "--seed", "2", check=False)
    assert done.returncode != 0 and "another description" in done.stderr


def test_a_full_disk_leaves_nothing_half_written(tmp_path):
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=600k", "tmpfs", tmp_path], capture_output=True)
    if mounted.returncode != 0:
        pytest.skip("mounting needs root")
    try:
        done = run(tmp_path, *QUICK, "--samples", "400", check=False)
        assert done.returncode != 0 and "disk full" in done.stderr
        assert not list((tmp_path / "out").glob("*draft*"))
        for part in (tmp_path / "out").glob("part-*.h5"):
            with h5py.File(part) as file:
                assert file["data/image_sc"][:].shape[0] == 4
    finally:
        subprocess.run(["umount", tmp_path], check=True)


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "out").write_text("a file")
    done = run(tmp_path, *SMALL, check=False)
    assert done.returncode != 0 and "--output: cannot create 'out'" in done.stderr
