"""Every option with a typical and an extreme value, and what is refused."""
import json
import pathlib
import re
import subprocess

import numpy as np
import pytest
from helpers import PLAIN, PROGRAM, STRAIGHT, TINY, label_names, labels_of, run, whole_of, write_balls

RANGES = [  # option, what it is called in the file, a typical range, the extremes
    ("--scale", "scale", "0.8..1.25", "0.1", "10"),
    ("--bend", "bend", "0..3", "0", "20"),
    ("--media", "media", "0.8..1.25", "0.1", "10"),
    ("--spread", "spread", "0..20", "0", "180"),
    ("--along", "along", "-5..5", "-500", "500"),
    ("--across", "across", "-5..5", "-500", "500"),
    ("--tilt", "tilt", "-3..3", "-60", "60"),
    ("--rock", "rock", "-3..3", "-60", "60"),
    ("--turn", "turn", "-90..90", "-180", "180"),
    ("--standoff", "standoff", "0..2", "0", "50"),
    ("--pressure", "pressure", "0..4", "0", "20"),
    ("--frequency", "frequency", "5..9", "0.5", "50"),
    ("--depth", "image_depth", "30..50", "5", "300"),
    ("--focus", "focus", "10..30", "1", "300"),
    ("--gain", "gain", "-6..6", "-60", "60"),
    ("--dynamic-range", "dynamic_range", "60..90", "20", "120"),
    ("--noise", "noise", "-130..-110", "-300", "0"),
    ("--gauge", "gauge", "18..22", "18", "25"),
    ("--needle-angle", "needle_angle", "20..40", "0", "85"),
    ("--needle-depth", "needle_depth", "10..20", "1", "200"),
]


@pytest.mark.parametrize("option, name, typical, least, most", RANGES, ids=[row[0] for row in RANGES])
def test_ranges(tmp_path, option, name, typical, least, most):
    images = []
    for value in (typical, least, most):
        run(tmp_path, *TINY, "--needle", "1", option, value, output="out" + value)
        with whole_of(tmp_path, "out" + value) as file:
            stored = file["insonify"][name][:]
            ends = np.float32([float(end) for end in value.split("..")])
            assert (stored[np.isfinite(stored)] >= ends[0]).all() and (stored[np.isfinite(stored)] <= ends[-1]).all()
            if len(ends) == 2:
                assert name == "gauge" or len(np.unique(stored)) > 1
            images.append(file["data/image/values"][:])
            assert (file["insonify/present"][:] == 1).all()
    other = 0 if name == "turn" else 1  # -180 and 180 degrees are the same pose
    assert not np.array_equal(images[other], images[2]) or name == "focus"
    below, above = float(least) - abs(float(least)) / 2 - 0.01, float(most) + abs(float(most)) / 2 + 0.01
    for value in (below, above):
        done = run(tmp_path, *TINY, f"{option}={value}", check=False)
        assert done.returncode == 1 and f"{option}: " in done.stderr and f"it must be from {least} to {most}" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "option, name, typical, extremes, refused",
    [
        ("--samples", None, "3", ["1"], ["0", "1000000001", "4294967296", "-1"]),
        ("--seed", None, "7", ["0", "18446744073709551615"], ["-1", "18446744073709551616", "one"]),
        ("--size", None, "64", ["16", "1024"], ["15", "4097"]),
        ("--part", None, "3", ["1", "8192"], ["0", "8193", "4294967295"]),
        ("--lines", "lines", "48", ["8", "1024"], ["0", "7", "1025", "100000"]),
        ("--planes", "planes", "3", ["1", "7"], ["0", "2", "9"]),
        ("--looks", "looks", "3", ["1", "2", "31"], ["0", "32", "33"]),
        ("--bend-length", None, "40", ["5", "10000"], ["4", "0", "nan"]),
        ("--needle", "needle", "0.5", ["0", "1"], ["2", "-0.1", "nan"]),
    ],
)
def test_numbers(tmp_path, option, name, typical, extremes, refused):
    for value in (typical, *extremes):
        run(tmp_path, *TINY, "--bend", "1", f"{option}={value}", output="out" + value)
        with whole_of(tmp_path, "out" + value) as file:
            images = file["data/image/values"]
            if option == "--samples":
                assert len(images) == int(value)
            if option == "--size":
                assert images.shape[1:] == (int(value), int(value))
            if name not in (None, "needle"):
                assert (file["insonify"][name][:] == int(value)).all()
            assert (file["insonify/present"][:] == 1).all() and images[:].std() > 1
    for value in refused:
        done = run(tmp_path, *TINY, f"{option}={value}", check=False)
        assert done.returncode != 0 and option in done.stderr, value
    assert not (tmp_path / "out").exists()


def test_the_largest_size(tmp_path):
    run(tmp_path, "--anatomy", "nerve_block", "--samples", "1", "--size", "4096", "--lines", "64", "--planes", "1", "--no-truth")
    with whole_of(tmp_path) as file:
        assert file["data/image/values"].shape == (1, 4096, 4096)


@pytest.mark.parametrize("value", ["linear", "convex", "phased"])
def test_probe(tmp_path, value):
    run(tmp_path, *TINY, "--probe", value)
    with whole_of(tmp_path) as file:
        assert file["probe/type"][()].decode() == value.replace("convex", "curved")
        assert (file["insonify/face_radius"][:] > 0).all() == (value == "convex")
        assert (file["insonify/field_of_view"][:] > 0).all() == (value != "linear")
    done = run(tmp_path, *TINY, "--probe", "round", check=False, output="no")
    assert done.returncode != 0 and "--probe" in done.stderr


@pytest.mark.parametrize("value", ["hdf5", "png"])
def test_format(tmp_path, value):
    run(tmp_path, *TINY, "--format", value)
    assert (tmp_path / "out" / "dataset.h5").exists() == (value == "hdf5")
    done = run(tmp_path, *TINY, "--format", "jpeg", check=False, output="no")
    assert done.returncode != 0 and "--format" in done.stderr and not (tmp_path / "no").exists()


def test_anatomy_and_place(tmp_path):
    """--anatomy, --unit, --background, --repair, --pennation, --around, --from, --lateral"""
    write_balls(tmp_path / "metres.obj", 1e-3, bone=15, blood=30)
    write_balls(tmp_path / "inches.obj", 1 / 25.4, bone=15, blood=30)
    pictures = []
    for file, unit in (("metres.obj", "1m"), ("inches.obj", "25.4"), ("metres.obj", "100cm")):
        run(tmp_path, *TINY, "--anatomy", file, "--unit", unit, "--background", "muscle", "--around", "bone", "--from", "0,-1,0", "--lateral", "0,0,1", output=file + unit)
        with whole_of(tmp_path, file + unit) as made:
            pictures.append(made["data/segmentation/values"][:])
            assert [name.decode() for name in made["data/segmentation/labels"]] == ["background", "blood", "bone", "skin", "needle"]
            assert (made["metadata/probe_pose/translation"][:, 1] < -0.010).all()  # on the side of -y
    assert (pictures[0] == pictures[1]).mean() > 0.99 and np.array_equal(pictures[0], pictures[2])
    run(tmp_path, *TINY, "--samples=12", "--anatomy", "metres.obj", "metres.obj", "--unit", "1m", "--around", "blood", "--from", "0,0,1", "--lateral=-1000,0,0")
    with whole_of(tmp_path) as made:
        assert set(made["insonify/anatomy"][:]) == {0, 1}
    for option, value, sentence in (
        ("--anatomy", "nowhere.obj", "no region and no file 'nowhere.obj'; regions are neck, leg"),
        ("--around", "knee", "no object 'knee'; it has bone, blood"),
        ("--background", "mud", "there is no tissue 'mud'"),
        ("--unit", "0", "--unit: must be from 1e-6"),
        ("--skin", "21mm", "--skin: 21 is out of range; it must be from 0 to 20"),
        ("--pennation", "91", "--pennation: 91 is out of range; it must be from -90 to 90"),
        ("--unit", "1furlong", "--unit"),
        ("--from", "0,0,0", "--from: must be a direction"),
        ("--lateral", "0,0,0", "--lateral: must be a direction"),
        ("--lateral", "0,0,-3", "--lateral: must not be parallel to --from"),
        ("--lateral", "nan,0,0", "--lateral: must be a direction"),
        ("--from", "1e9,0,0", "--from: must be a direction"),
        ("--transmits", "fsa", "--transmits: there are no channel data; choose an array, such as --channels l11_5v"),
    ):
        start = [] if option == "--anatomy" else ["--anatomy", "metres.obj"]
        done = run(tmp_path, *TINY, *start, *([] if option == "--unit" else ["--unit", "1m"]), f"{option}={value}", check=False, output="no")
        assert done.returncode != 0 and sentence in done.stderr, done.stderr
        assert not (tmp_path / "no").exists()
    done = run(tmp_path, *TINY, "--around", "knee", check=False, output="no")
    assert done.returncode != 0 and "--around is for OBJ files; in a region the probe is placed by --view" in done.stderr
    for option, value in (("--from", "0,-1,0"), ("--from", "1,0,0"), ("--lateral", "0,1,0"), ("--unit", "2mm"), ("--background", "muscle"), ("--skin", "0"), ("--pennation", "9")):
        done = run(tmp_path, *TINY, "--anatomy", "nerve_block", option, value, check=False, output="no")
        assert done.returncode != 0 and f"{option} is for OBJ files" in done.stderr


def test_files_are_repaired_and_get_fibres(tmp_path):
    """--repair, --pennation"""
    write_balls(tmp_path / "balls.obj", bone=15, muscle=30)
    whole = (tmp_path / "balls.obj").read_text().splitlines()
    last = max(i for i, line in enumerate(whole) if line.startswith("f "))
    (tmp_path / "holed.obj").write_text("\n".join(whole[:last] + whole[last + 1 :]) + "\n")
    done = run(tmp_path, *TINY, "--anatomy", "holed.obj", check=False, output="no")
    assert done.returncode != 0 and "Or --repair may close it" in done.stderr
    done = run(tmp_path, *TINY, "--anatomy", "nerve_block", "--repair", check=False, output="no")
    assert done.returncode != 0 and "--repair is for OBJ files" in done.stderr
    seen = {}
    for angle in ("0", "40"):
        told = run(tmp_path, *TINY, "--anatomy", "holed.obj", "--repair", "--pennation", angle, output=angle)
        assert "object 'muscle': Closed 1 hole along 3 edges" in told.stderr
        with whole_of(tmp_path, angle) as made:
            seen[angle] = made["data/segmentation/values"][:], made["data/image/values"][:]
    assert np.array_equal(seen["0"][0], seen["40"][0]) and not np.array_equal(seen["0"][1], seen["40"][1])


@pytest.mark.parametrize("skin, thickness", [(None, 1.5), ("3mm", 3), ("20", 20), ("0", 0)])
def test_skin_of_files(tmp_path, skin, thickness):
    """--skin: below the surface of the ball that encloses the other one, on which the probe stands"""
    write_balls(tmp_path / "balls.obj", muscle=30, bone=5)
    chosen = [] if skin is None else ["--skin", skin]
    run(tmp_path, *PLAIN, *STRAIGHT, "--anatomy", "balls.obj", "--around", "muscle", "--size", "256", "--samples", "1", "--planes", "1", *chosen)
    with whole_of(tmp_path) as made:
        names, label, depth = label_names(made), labels_of(made)[0][:, 128], 1e3 * made["data/depth/values"][0][:, 128]
    assert ("skin" in names) == (thickness > 0)
    if thickness > 0:
        first = np.flatnonzero(label == names.index("skin"))[0]
        end = first + np.flatnonzero(label[first:] != names.index("skin"))[0]
        assert depth[first] < 0.5 and depth[end] == pytest.approx(thickness, rel=0.25)  # it is uneven
    assert (label == names.index("bone")).any() and (label == names.index("muscle")).any()


def test_plan_of_the_largest_dataset(tmp_path):
    told = run(tmp_path, *TINY, "--samples=1000000000", "--part=1", "--plan", "--format", "png").stdout
    assert "1000000000 samples of 32 x 32 pixels in 1000000000 parts" in told
    assert not list(tmp_path.iterdir())


def test_verify_before_there_is_anything(tmp_path):
    done = run(tmp_path, *TINY, "--verify", check=False)
    assert done.returncode == 1 and "part-000000.h5: is missing" in done.stdout and not list(tmp_path.iterdir())


def test_iq_and_no_truth_are_flags(tmp_path):
    run(tmp_path, *TINY, "--iq", "--no-truth")
    with whole_of(tmp_path) as file:
        assert set(file["data"]) == {"image", "segmentation", "beamformed_data", "envelope_data"}


def test_no_option_is_without_a_test():
    text = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
    assert "A..B=18..25" in text  # with defaults
    options = set(re.findall(r"^  (?:-\w,)?(--[a-z-]+)", text, re.MULTILINE))
    assert len(options) > 35
    tests = "".join(path.read_text() for path in pathlib.Path(__file__).parent.glob("*.py"))
    assert {option for option in options if not re.search(f'"{option}[="]', tests)} == set()


def test_what_a_file_may_contain(tmp_path):
    (tmp_path / "what.ini").write_text("""\ufeff# a comment
; another one

samples = 2   # two
size=32
lines = 16
frequency = "5..9"
planes = 1
anatomy = 'nerve_block'
iq = true
from = 0,0,-1
""")
    run(tmp_path, "--config", "what.ini", "--frequency", "6")  # the command line has precedence
    with whole_of(tmp_path) as file:
        assert file["data/image/values"].shape == (2, 32, 32) and (file["insonify/frequency"][:] == 6).all() and "beamformed_data" in file["data"]


@pytest.mark.parametrize(
    "text, sentence",
    [
        ("freqency = 5..9", "line 1: there is no option 'freqency'; did you mean frequency?"),
        ("size = 32\nsampels = 3", "line 2: there is no option 'sampels'; did you mean samples?"),
        ("frequency = 5..9\nfrequency = 6", "line 2: 'frequency' is given twice"),
        ("colour = red", "line 1: there is no option 'colour'; dataset --help lists all"),
        ("[section]\nsamples = 3", "line 1: '[section]' is not of the form option = value"),
        ("samples", "line 1: 'samples' is not of the form option = value"),
        ("samples =", "line 1: 'samples' has no value"),
        ("around = 'skin", "line 1: a quotation mark is not closed"),
        ("plan = true", "line 1: 'plan' is an option of the command line alone"),
        ("help = true", "line 1: 'help' is an option of the command line alone"),
        ("rock = 9..5", "runs backwards"),
        ("seed = many", "--seed: 'many' is not a whole number"),
        ("ab", "line 1: 'ab' is not of the form option = value"),
        pytest.param(bytes(np.random.default_rng(1).integers(0, 256, 20000, dtype=np.uint8)), "--config: line 1: it has control characters", id="noise"),
        pytest.param(b"samples = 3\nlook\x1b[31m = 3", "--config: line 2: it has control characters", id="escape"),
        pytest.param(b"x" * 20000, "is not of the form option = value", id="long"),
        pytest.param(b"x" * 20000 + b" = 3", "there is no option 'xxxx", id="long name"),
    ],
    ids=lambda value: None if isinstance(value, bytes) else None,
)
def test_a_file_with_mistakes_is_refused(tmp_path, text, sentence):
    (tmp_path / "what.ini").write_bytes(text if isinstance(text, bytes) else text.encode())
    done = run(tmp_path, *TINY, "--config", "what.ini", check=False)
    assert done.returncode not in (0, -6, -11) and sentence in done.stderr + done.stdout and len(done.stderr) < 400
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "options, sentence",
    [
        (["--frequency", "9..5"], "runs backwards"),
        (["--frequency", "nine"], "--frequency: 'nine' is neither a number nor a range; a range is written with two dots"),
        (["--frequency", "6-9"], "--frequency: '6-9' is neither a number nor a range; a range is written 6..9"),
        (["--tilt", "-9--5"], "a range is written -9..-5"),
        (["--planes", "2"], "1, 3, 5 or 7"),
        (["--pressure", "6..2"], "--pressure: 6..2 runs backwards"),
        (["--pressure", "0..30"], "--pressure: 0..30 is out of range; it must be from 0 to 20"),
        (["--config", "nowhere.ini"], "nowhere.ini"),
        (["--bogus"], "bogus"),
    ],
)
def test_bad_options_give_a_sentence(tmp_path, options, sentence):
    done = run(tmp_path, *options, check=False)
    assert done.returncode != 0 and sentence in done.stderr + done.stdout
    assert not (tmp_path / "out").exists()


def test_a_refused_value_leaves_no_description(tmp_path):
    for options in (["--lines", "0"], ["--looks", "33"], ["--lateral", "0,0,1"]):
        assert run(tmp_path, *TINY, *options, check=False).returncode == 1
        assert not (tmp_path / "out").exists()
    run(tmp_path, *TINY)


def test_names_of_objects_stand_in_json_and_html(tmp_path):
    """Names from a file may contain anything, and are not mistaken for the background or the needle."""
    write_balls(tmp_path / "balls.obj", bone=10, blood=15, muscle=20, fat=25, nerve=30)
    names = {b"o bone": b'o a"b\\c<i>&amp;\x01', b"o blood": b"o background", b"o muscle": b"o needle", b"o nerve": b"o Knie \xe4u\xdfen"}
    text = (tmp_path / "balls.obj").read_bytes()
    for old, new in names.items():
        text = text.replace(old + b"\n", new + b"\n")
    (tmp_path / "balls.obj").write_bytes(text)
    options = [*TINY, "--anatomy", "balls.obj", "--skin", "0", "--needle", "1", "--samples=6", "--size=64", "--needle-depth", "3..8"]
    run(tmp_path, *options)
    run(tmp_path, *options, "--format", "png", output="png")
    expected = ["background", 'a"b\\c<i>&amp;\x01', "background (object)", "fat", "needle (object)", "needle"]
    with whole_of(tmp_path) as file:
        found = [name.decode() for name in file["data/segmentation/labels"]]
        assert set(expected) < set(found) and any("äußen" in name for name in found) and len(set(found)) == len(found) == 7
        masks = file["data/segmentation/values"][:]
        assert masks[..., found.index("needle")].any() and masks[..., found.index("background (object)")].any()
    one = json.loads(next((tmp_path / "png").glob("part-*/*.json")).read_text(encoding="utf-8"))
    assert one["labels"] == found
    page = (tmp_path / "out" / "summary.html").read_text(encoding="utf-8")
    assert "<i>" not in page and "a&quot;b\\c&lt;i&gt;&amp;amp;" in page
