"""Runs, and what their samples show."""
import hashlib
import random
import re
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest
from helpers import PLAIN, PROGRAM, QUICK, SMALL, STRAIGHT, TINY, label_names, labels_of, run, whole_of, write_balls


def hashes(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted((folder / "out").glob("*.h5"))}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(folder, *SMALL)
    return folder


def test_one_file_stands_for_all_parts(whole):
    with whole_of(whole) as file:
        assert file["data/image/values"].shape == (24, 64, 64) and file["data/image/values"].dtype == np.uint8
        assert list(file["insonify/number"]) == list(range(24))
        images = file["data/image/values"][:]
        assert (images.reshape(24, -1).std(axis=1) > 5).all()  # no image is empty
        names = label_names(file)
        assert names[0] == "background" and "needle" in names and len(set(names)) == len(names)
        labels = labels_of(file)
        assert set(np.unique(labels)) <= set(range(len(names))) | {255}
        for name in ("data/image/values", "data/incidence/values", "insonify/frequency"):
            assert file[name].attrs["unit"] and file[name].attrs["description"]
        needles = file["insonify/needle"][:] == 1
        assert 0 < needles.sum() < 24
        assert not (labels[~needles] == names.index("needle")).any()


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
                assert file["data/image/values"].shape[0] == 4
    run(tmp_path, *SMALL)
    assert hashes(tmp_path) == hashes(whole)
    assert not list((tmp_path / "out").glob("*draft*"))


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


@pytest.mark.parametrize("ranks", [1, 2])
def test_what_was_read_is_told_once(tmp_path, ranks):
    write_balls(tmp_path / "balls.obj", bone=15, liver=20)
    text = (tmp_path / "balls.obj").read_text().replace("o liver", "o bone")
    (tmp_path / "balls.obj").write_text(text)
    done = run(tmp_path, *TINY, "--anatomy", "balls.obj", "--plan", ranks=ranks)
    assert done.stderr.count("balls.obj: 2 objects, 40 x 40 x 40 mm, where 1 in the file is 1 mm (--unit)\n") == 1
    assert done.stderr.count("there are several objects of the name 'bone'; this one is called 'bone.2'") == 1


@pytest.mark.parametrize("options", [[], ["--bend", "0..3", "--pressure", "0..4"]], ids=["default", "bent and pressed"])
def test_the_sides_of_the_phantom_are_outside_of_the_images(tmp_path, options):
    """Within the field of view there is no background, and gel and skin only near the face."""
    run(tmp_path, "--anatomy", "nerve_block", "--needle", "0", "--samples", "100", "--part", "100", "--size", "128", "--lines", "64", "--planes", "1", *options)
    with h5py.File(tmp_path / "out" / "part-000000.h5") as file:
        names = label_names(file)
        labels, depths = labels_of(file), 1e3 * file["data/depth/values"][:]
    for name, deepest in (("background", 0), ("gel", 4), ("skin", 6)):  # mm
        below = (labels == names.index(name)) & (depths > deepest)
        seen = np.flatnonzero(below.any(axis=(1, 2)))
        assert not len(seen), f"{name} deeper than {deepest} mm in the samples {seen}"


@pytest.mark.parametrize("pressed", [False, True])
def test_labels_overlay_the_image(tmp_path, pressed):
    """The edge of bone lies within 1 pixel of the label's border, at normal incidence."""
    if pressed:
        write_balls(tmp_path / "balls.obj", blood=45, bone=20)
        place = ["--around", "blood", "--skin", "0", "--pressure", "2..6", "--along", "-4..4", "--across", "-4..4"]
    else:
        write_balls(tmp_path / "balls.obj", bone=15)
        place = ["--around", "bone", "--standoff", "10..20"]
    run(tmp_path, *PLAIN, "--anatomy", "balls.obj", "--background", "water", *place, "--size", "256", "--samples", "16", "--part", "16",
        "--spread", "0..10", "--turn", "-90..90", "--gain", "-30", "--planes", "1")
    with h5py.File(tmp_path / "out" / "part-000000.h5") as file:
        bone = label_names(file).index("bone")
        off = []
        for image, label, incidence in zip(file["data/image/values"], labels_of(file), file["data/incidence/values"]):
            for column in np.flatnonzero((label == bone).any(axis=0)):
                top = np.flatnonzero(label[:, column] == bone)[0]
                if 0 < incidence[max(0, top - 2) : top + 3, column].max() < 0.1:  # rad; 0: no surface in these pixels
                    bright = image[:, column].astype(float)
                    bright[: max(0, top - 20)] = 0  # above it is the echo of skin
                    rows = np.flatnonzero(bright >= bright.max())  # the pulse is symmetric: its middle is the surface
                    off.append(rows.mean() + 0.5 - top)  # top is the upper edge of the label's first row
        print(f"{len(off)} columns, the edge is {np.mean(off):.2f} pixels below the border, rms {np.std(off):.2f}, at most {np.abs(off).max():.2f}")
        assert len(off) > 50 and np.abs(off).max() <= 1


@pytest.mark.parametrize("inside", ["muscle", "bone"])
def test_pressed_tissue_yields(tmp_path, inside):
    """Muscle 25 mm below the skin gives way by exp(-25 / 20) of what the skin does, bone not at all: depth, label and image agree."""
    write_balls(tmp_path / "balls.obj", blood=45, **{inside: 20})
    for pressure in (0, 3, 6):
        folder = tmp_path / str(pressure)
        folder.mkdir()
        run(folder, *PLAIN, "--anatomy", "../balls.obj", "--background", "water", "--around", "blood", "--planes", "1", "--samples", "1",
            "--pressure", str(pressure), "--skin", "0", *STRAIGHT)
        with whole_of(folder) as file:
            assert file["insonify/pressure"][0] == pressure
            label, depth = labels_of(file)[0][:, 128], 1e3 * file["data/depth/values"][0][:, 128]
            top = np.flatnonzero(label == label_names(file).index(inside))[0]
            border = depth[top - 1] + (depth[top - 1] - depth[top - 2]) / 2  # the lower edge of the last row above
            expected = 25 - pressure + (max(0, pressure - 0.05) * np.exp(-25 / 20) if inside == "muscle" else 0)
            print(f"pressed by {pressure} mm, {inside} is {border:.2f} mm below the face, expected {expected:.2f}")
            assert border == pytest.approx(expected, abs=0.16)  # a row
            assert (label[2:100] == label_names(file).index("blood")).all()  # no gap to the skin


def test_a_probe_does_not_enter_bone(tmp_path):
    """Bone 5 mm below the skin: a face that is pressed by more stops before it."""
    write_balls(tmp_path / "balls.obj", blood=45, bone=40)
    run(tmp_path, *PLAIN, "--anatomy", "balls.obj", "--around", "blood", "--planes", "1", "--samples", "4", "--size", "64", "--pressure", "12..20", *STRAIGHT)
    with whole_of(tmp_path) as file:
        assert (labels_of(file)[:, :, 30:34] == label_names(file).index("bone")).any(axis=(1, 2)).all()
        assert (file["insonify/contact_depth"][:] < 5e-3).all() and (file["insonify/contact_depth"][:] > 3e-3).all()


def test_a_probe_that_is_not_pressed_does_not_enter_bone(tmp_path):
    """The place of the probe, on the blood, is in the bone around it: the face is raised."""
    write_balls(tmp_path / "balls.obj", bone=20, blood=15)
    run(tmp_path, *PLAIN, "--anatomy", "balls.obj", "--around", "blood", "--skin", "0", "--size", "64", "--samples", "8", "--planes", "1", "--tilt", "-10..10")
    with whole_of(tmp_path) as file:
        labels, bone = labels_of(file), label_names(file).index("bone")
        assert (labels[:, :8] == bone).any(axis=(1, 2)).all()
        assert ((labels[:, 0] == bone).sum(axis=1) < 13).all()  # of 64: where a ball that touches the face is in the first row
        assert (file["insonify/contact_depth"][:] == 0).all()


def test_needles_stay_out_of_bone(tmp_path):
    write_balls(tmp_path / "balls.obj", muscle=40, bone=22)
    run(tmp_path, *PLAIN, "--anatomy", "balls.obj", "--size", "96", "--samples", "32", "--planes", "1", "--needle", "1", "--needle-depth", "2..35", "--bend", "0")
    with whole_of(tmp_path) as file:
        labels, needle = labels_of(file), label_names(file).index("needle")
        numbers = {name: file["insonify/" + name][:] for name in ("needle", "needle_side", "needle_angle", "needle_depth", "needle_lateral")}
        places, turns = file["metadata/probe_pose/translation"][:], file["metadata/probe_pose/rotation"][:]
    assert numbers["needle"].sum() > 16
    for row in np.flatnonzero(numbers["needle"]):
        assert (labels[row] == needle).any()
        w, v = turns[row, 0], turns[row, 1:]
        world = lambda p: p + 2 * np.cross(v, np.cross(v, p) + w * p)  # turned by the quaternion
        side, angle = 1 - 2 * numbers["needle_side"][row], np.radians(numbers["needle_angle"][row])
        tip = places[row] + world(1e-3 * np.array([numbers["needle_lateral"][row], 0, numbers["needle_depth"][row]]))
        back = -world(np.array([side * np.cos(angle), 0, np.sin(angle)]))
        away = [0, 0, 0.04] - tip
        nearest = np.linalg.norm(away - max(np.dot(away, back), 0) * back)
        assert nearest > 0.0215  # of the bone, whose facets lie within its sphere


def test_plan(tmp_path):
    told = run(tmp_path, *SMALL, "--plan").stdout
    assert "24 samples of 64 x 64 pixels in 6 parts" in told and "MB on disk" in told
    assert re.search(r"pressure: 0\.\d+ to 2\.\d+ mm\n", told) and "focus: 15" in told and "frequency:" not in told
    assert not (tmp_path / "out").exists()
    # A plan is that of a folder to come, whatever the folder holds.
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "description.ini").write_text("size = 32\n")
    assert run(tmp_path, *SMALL, "--plan").stdout.splitlines()[0] == told.splitlines()[0]
    assert run(tmp_path, *SMALL, check=False).returncode != 0


