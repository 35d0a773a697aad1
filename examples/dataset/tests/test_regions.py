"""Regions of the body: their views, parameters and needles; and what the summary says about them."""
import hashlib
import json
import re

import numpy as np
import pytest
from helpers import PLAIN, STRAIGHT, TINY, label_names, labels_of, run, whole_of, write_balls

SKETCH = ["--size", "48", "--lines", "32", "--planes", "1", "--parameter", "resolution=0.4"]


def texts(file, name):
    return [text.decode() for text in file["insonify"][name][:]]


def parameters_of(file, row):
    return {name: value for name, value in zip(texts(file, "parameter_names"), file["insonify/parameters"][row]) if not np.isnan(value)}


@pytest.fixture(scope="module")
def regions(tmp_path_factory):
    """Two cycles of all views."""
    folder = tmp_path_factory.mktemp("regions")
    run(folder, *SKETCH, "--samples", "40")
    return folder


def test_every_view_of_every_region_occurs_as_often(regions):
    with whole_of(regions) as file:
        views, found = texts(file, "views"), file["insonify/view"][:].astype(int)
        assert texts(file, "anatomies") == ["neck", "leg", "right_upper_quadrant", "lumbar", "nerve_block"]
        assert len(views) == 20 and len(set(views)) == 20
        for cycle in (found[:20], found[20:]):
            assert sorted(cycle) == list(range(20))
        of = {views[view]: int(anatomy) for view, anatomy in zip(found, file["insonify/anatomy"][:])}
        assert of["thyroid"] == 0 and of["calf_transverse"] == 1 and of["morison"] == 2 and of["transverse_spinous"] == 3
        images = file["data/image/values"][:]
        assert (images.reshape(40, -1).std(axis=1) > 5).all()
        assert (file["insonify/on_surface"][:] == 1).all()


def test_samples_of_a_body_follow_each_other_and_share_its_parameters(regions):
    with whole_of(regions) as file:
        seeds, anatomies = file["insonify/body_seed"][:], file["insonify/anatomy"][:]
        starts = np.flatnonzero(np.concatenate([[True], seeds[1:] != seeds[:-1]]))
        assert len(starts) == len(np.unique(seeds)) == 10 and (seeds < 1_000_000_000).all()
        for start, end in zip(starts, [*starts[1:], 40]):
            assert len(set(file["insonify/view"][start:end])) == end - start  # other views of one body
            first = parameters_of(file, start)
            assert all(parameters_of(file, row) == first for row in range(start, end))
            for name in ("bend_wave", "media", "gauge", "scale"):
                values = file["insonify"][name][start:end]
                assert (values == values[0]).all()
        for name, low, high in (("fat", 0.0015, 0.008), ("carotid", 0.0052, 0.0075), ("roots", 0.8, 1.2)):
            values = [parameters_of(file, row)[name] for row in np.flatnonzero(anatomies == 0)]
            assert low - 1e-6 <= min(values) and max(values) <= high + 1e-6 and len(set(values)) == 2
        assert len(np.unique(file["insonify/gain"][:])) == 40 and len(np.unique(file["insonify/image_depth"][:])) == 40


def test_left_and_right_bodies_take_turns(regions):
    with whole_of(regions) as file:
        side, anatomy = file["insonify/side"][:], file["insonify/anatomy"][:]
        for region, views in ((0, 5), (1, 6), (3, 3)):  # neck, leg and lumbar spine: one of the two bodies is left, one right
            assert sorted(side[anatomy == region]) == [0] * views + [1] * views
        assert np.isnan(side[anatomy == 2]).all()


def test_needles_come_from_the_left_and_from_the_right(tmp_path):
    """Of each view in turn; the label of the needle lies on that side of its tip."""
    run(tmp_path, *PLAIN, "--anatomy", "nerve_block", "--samples", "16", "--size", "128", "--lines", "96", "--planes", "1", "--needle", "1", "--gauge", "18",
        "--needle-lateral", "0", *STRAIGHT)
    with whole_of(tmp_path) as file:
        about, needle = file["insonify"], label_names(file).index("needle")
        side, angle, depth, lateral = (about[name][:] for name in ("needle_side", "needle_angle", "needle_depth", "needle_lateral"))
        assert side.sum() == 8 and (side[1:] != side[:-1]).all()
        assert (np.abs(lateral) < 0.01).all() and (np.abs(depth - 15.3) <= 5.01).all() and (np.abs(angle - 22) <= 10.01).all()  # the phantom's path
        points = file["data/image/coordinates"][:]
        for row, labels in enumerate(labels_of(file)):
            x, z = 1e3 * points[row][labels == needle][:, 0], 1e3 * points[row][labels == needle][:, 2]
            away = -x if side[row] == 0 else x  # from the tip to the shaft
            assert len(x) > 20 and away.min() > -3 and away.max() > 10
            np.testing.assert_allclose(z, depth[row] - away * np.tan(np.radians(angle[row])), atol=1.5)


def test_a_fraction_of_the_samples_has_a_needle(tmp_path):
    for fraction, count in (("0.25", 10), ("0.5", 20)):
        run(tmp_path, *TINY, "--samples", "40", "--needle", fraction, output="out" + fraction)
        with whole_of(tmp_path, "out" + fraction) as file:
            present, side = file["insonify/needle"][:] == 1, file["insonify/needle_side"][:]
            assert abs(present.sum() - count) <= 1 and abs(side[present].sum() - count / 2) <= 1


def test_the_tip_follows_the_target_of_the_view(tmp_path):
    """Where the probe has moved along its array, the tip has moved the other way in the image."""
    for along in (-6, 6):
        run(tmp_path, *TINY, *STRAIGHT, "--along", str(along), "--needle", "1", "--needle-lateral", "0", output=f"out{along}")
        with whole_of(tmp_path, f"out{along}") as file:
            np.testing.assert_allclose(file["insonify/needle_lateral"][:], -along, atol=0.3)
    run(tmp_path, *TINY, "--needle-lateral", "-30..30", "--samples", "8", "--needle", "1")
    with whole_of(tmp_path) as file:
        assert np.ptp(file["insonify/needle_lateral"][:]) > 15
    for value in ("-100", "100"):
        run(tmp_path, *TINY, f"--needle-lateral={value}", output="out" + value)
    done = run(tmp_path, *TINY, "--needle-lateral", "101", check=False, output="no")
    assert done.returncode == 1 and "--needle-lateral: 101 is out of range; it must be from -100 to 100" in done.stderr


def test_needles_are_in_the_image(tmp_path):
    run(tmp_path, *PLAIN, "--view", "femoral_block", "--anatomy", "leg", "--needle", "1", "--samples", "64", "--size", "96", "--no-truth", "--parameter", "resolution=0.5")
    with whole_of(tmp_path) as file:
        seen = (labels_of(file) == label_names(file).index("needle")).any(axis=(1, 2))
        assert (seen == file["insonify/needle"][:]).all() and seen.sum() == 64


def test_sectors_keep_their_shape_and_have_nothing_outside(tmp_path):
    run(tmp_path, *SKETCH, "--anatomy", "lumbar", "--samples", "3", "--iq")
    with whole_of(tmp_path) as file:
        about, labels = file["insonify"], labels_of(file)
        np.testing.assert_array_equal(labels, about["label"][:])
        assert (about["probe"][:] == 1).all() and file["probe/type"][()] == b"curved"
        np.testing.assert_array_equal(about["pitch"][:, 0], about["pitch"][:, 1])
        assert (about["face_radius"][:] > 0).all()
        apex = -about["face_radius"][:] * 1.0
        for row in range(3):
            points = file["data/image/coordinates"][row]
            x, z = points[..., 0], points[..., 2] - apex[row]  # z = 0 is the middle of the face
            depth, angle = np.hypot(x, z) + apex[row], np.arctan2(x, z)
            margin = 2 * about["pitch"][row, 0]
            inside = (depth > margin) & (depth < 1e-3 * about["image_depth"][row] - margin) & (np.abs(angle) < about["field_of_view"][row] / 2 - 0.03)
            outside = (depth < -margin) | (depth > 1e-3 * about["image_depth"][row] + margin) | (np.abs(angle) > about["field_of_view"][row] / 2 + 0.03)
            assert (labels[row][inside] < 255).all() and (labels[row][outside] == 255).all() and inside.sum() > 500
            assert (file["data/image/values"][row][outside] == 0).all()
        assert (np.abs(file["insonify/image_depth"][:] / 105 - 1) < 0.151).all()


def test_probes_of_several_kinds(regions, tmp_path):
    with whole_of(regions) as file:
        assert "probe" not in file and set(file["insonify/probe"][:]) == {0, 1, 2}
    run(tmp_path, *SKETCH, "--anatomy", "lumbar", "--probe", "phased", "--samples", "3")
    with whole_of(tmp_path) as file:
        assert file["probe/type"][()] == b"phased" and (file["insonify/probe"][:] == 2).all()


def hashes(folder, output="out"):
    return [hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted((folder / output).glob("*.h5"))]


def test_parts_that_divide_a_body_are_the_same_on_any_number_of_ranks(tmp_path):
    """Parts of 3 samples: a body of 4 views is made by two ranks."""
    options = [*SKETCH, "--anatomy", "nerve_block", "neck", "--samples", "13", "--part", "3"]
    run(tmp_path, *options)
    run(tmp_path, *options, ranks=3, output="ranks")
    assert hashes(tmp_path) == hashes(tmp_path, "ranks")
    run(tmp_path, *options, "--samples", "7", output="fewer")
    run(tmp_path, *options, output="fewer")  # goes on
    assert hashes(tmp_path) == hashes(tmp_path, "fewer")
    run(tmp_path, *options, "--part", "13", output="whole")
    with whole_of(tmp_path) as parts, whole_of(tmp_path, "whole") as whole:
        for name in ("data/image/values", "insonify/label", "insonify/parameters", "insonify/needle_depth"):
            np.testing.assert_array_equal(parts[name][:], whole[name][:])


def test_views_and_parameters_are_chosen(tmp_path):
    run(tmp_path, *SKETCH, "--view", "thyroid", "calf_transverse", "--parameter", "fat=0.3..0.5cm", "side=1", "resolution=0.4", "thigh_pennation=10deg", "calf_pennation=14..25", "--samples", "8", "--no-truth")
    with whole_of(tmp_path) as file:
        assert texts(file, "anatomies") == ["neck", "leg"] and texts(file, "views") == ["thyroid", "calf_transverse"]
        assert (file["insonify/side"][:] == 1).all()
        fat = np.array([parameters_of(file, row)["fat"] for row in range(8)])
        assert (fat >= 0.003).all() and (fat <= 0.005).all() and len(np.unique(fat)) == 8
        assert all(parameters_of(file, row)["resolution"] == np.float32(0.4) for row in range(8))
    description = (tmp_path / "out" / "description.ini").read_text()
    assert "view = thyroid calf_transverse\n" in description and "\"fat=0.3..0.5cm\"" in description
    before = hashes(tmp_path)
    run(tmp_path, "--config", "out/description.ini")
    assert hashes(tmp_path) == before


@pytest.mark.parametrize(
    "options, sentence",
    [
        (["--anatomy", "tail"], "--anatomy: there is no region and no file 'tail'; regions are neck, leg, right_upper_quadrant, lumbar, nerve_block"),
        (["--view", "toe"], "--view: there is no view 'toe'; known are carotid_transverse"),
        (["--anatomy", "leg", "--view", "thyroid"], "--view: leg has none of these views; known are femoral_block"),
        (["--parameter", "flavour=1..2"], "--parameter: there is no parameter 'flavour'; known are side"),
        (["--parameter", "fat=3..99"], "--parameter: fat=3..99: neck: `fat` is 99 mm; it must be from 1.5 mm to 8 mm: thickness"),
        (["--parameter", "fat=5..3"], "--parameter: fat=5..3 runs backwards"),
        (["--parameter", "side=0..0.5"], "--parameter: side=0..0.5: neck: `side` is 0.5; it must be a whole number from 0 to 1"),
        (["--parameter", "fat=thick"], "--parameter: fat: 'thick' is neither a number nor a range"),
        (["--parameter", "fat=3..4deg"], "--parameter: fat: '3..4deg' is neither a number nor a range; a range is written with two dots, such as 5..9; without a unit it is in mm"),
        (["--parameter", "fat=5", "fat=6"], "--parameter: `fat` is given twice"),
        (["--anatomy", "nerve_block", "--parameter", "fat=3"], "--parameter: there is no parameter 'fat'; the regions that were chosen have none"),
        (["--parameter", "fat"], "--parameter: 'fat' is not a name and a range, such as fat=3..5"),
    ],
)
def test_what_no_region_has_is_refused(tmp_path, options, sentence):
    done = run(tmp_path, *options, "--samples", "1", check=False)
    assert done.returncode == 1 and sentence in done.stderr and done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_named_like_a_region(tmp_path):
    write_balls(tmp_path / "lumbar", bone=15)
    options = [*TINY, "--samples", "1"]
    run(tmp_path, *options, "--anatomy", "./lumbar")
    with whole_of(tmp_path) as file:
        assert label_names(file) == ["background", "bone", "needle"] and texts(file, "views") == [""]
    run(tmp_path, "--config", "out/description.ini", "--samples", "2")  # it is still the file
    run(tmp_path, *options, "--anatomy", "lumbar", output="region")
    with whole_of(tmp_path, "region") as file:
        assert "dura mater" in label_names(file)


def test_regions_beside_files(tmp_path):
    write_balls(tmp_path / "balls.obj", bone=15, blood=30)
    for option, value in (("--view", "thyroid"), ("--parameter", "fat=3")):
        done = run(tmp_path, *TINY, "--anatomy", "balls.obj", option, value, check=False)
        assert done.returncode == 1 and f"{option} is for regions; an OBJ file has one view" in done.stderr
    run(tmp_path, *TINY, "--anatomy", "nerve_block", "balls.obj", "--around", "blood", "--samples", "6")
    with whole_of(tmp_path) as file:
        assert texts(file, "anatomies") == ["nerve_block", "balls.obj"] and sorted(file["insonify/anatomy"][:]) == [0] * 3 + [1] * 3
        labels, names = labels_of(file), label_names(file)
        for row, anatomy in enumerate(file["insonify/anatomy"][:]):
            assert (labels[row] == names.index("nerve")).any() == (anatomy == 0) and (labels[row] == names.index("blood")).any() == (anatomy == 1)


@pytest.fixture(scope="module")
def pictures(regions, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")
    run(folder, *SKETCH, "--samples", "40", "--format", "png")
    return folder


def test_the_summary_counts_what_is_stored(regions):
    page = (regions / "out" / "summary.html").read_text()
    with whole_of(regions) as file:
        labels, names = file["insonify/label"][:], label_names(file)
        present = file["insonify/needle"][:] == 1
        side = file["insonify/needle_side"][:][present]
    counts = np.stack([(labels == label).sum(axis=0) for label in range(len(names))])
    right = 100 * counts.max(axis=0).sum() / counts.sum()
    assert f"is right for <b>{right:.1f} %</b> of the pixels in the field of view" in page
    never = [name for name, count in zip(names, counts.sum(axis=(1, 2))) if count == 0]
    assert f"<p>Labels that occur in no sample: {', '.join(never)}.</p>" in page
    assert "<tr><td>neck<td>10<td>25.0 %\n" in page and "<tr><td>morison<td>2<td>5.0 %\n" in page
    assert re.search(r"side of the body<th>samples<th>share\n<tr><td>left<td>14<td>50.0 %\n<tr><td>right<td>14<td>50.0 %", page)
    assert f"<tr><td>present<td>{present.sum()}<td>" in page
    assert re.search(rf"needle from the<th>samples<th>share\n<tr><td>left<td>{(side == 0).sum()}<td>.*\n<tr><td>right<td>{(side == 1).sum()}<td>", page)
    assert "gain, dB: " in page and "image_depth, mm: " in page


def test_pictures_say_the_same(regions, pictures):
    pages = [(folder / "out" / "summary.html").read_text() for folder in (regions, pictures)]
    assert pages[0] == pages[1]
    one = json.loads((pictures / "out" / "part-000000" / "00000005.json").read_text())
    with whole_of(regions) as file:
        assert one["anatomy_name"] == texts(file, "anatomies")[int(file["insonify/anatomy"][5])]
        assert one["view_name"] == texts(file, "views")[int(file["insonify/view"][5])]
        assert one["body_seed"] == file["insonify/body_seed"][5] and one["parameter_names"] == texts(file, "parameter_names")
        values = np.array([np.nan if value is None else value for value in one["parameters"]], np.float32)
        np.testing.assert_array_equal(values, file["insonify/parameters"][5])


def test_plan_of_regions(tmp_path):
    told = run(tmp_path, *SKETCH, "--anatomy", "leg", "--samples", "8", "--plan").stdout
    assert "8 samples of 48 x 48 pixels" in told and " femoral nerve" in told and re.search(r"image_depth: \d+\.\d+ to \d+\.\d+ mm\n", told)
    assert not list(tmp_path.iterdir())
