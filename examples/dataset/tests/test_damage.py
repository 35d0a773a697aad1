"""Parts that are lost, cut or damaged; runs that go on, grow, or meet a full disk."""
import filecmp
import resource
import shutil
import subprocess
import time

import h5py
import numpy as np
import pytest
from helpers import PROGRAM, QUICK, SMALL, TINY, run, whole_of, write_balls

from insonify_samples import samples


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(folder, *SMALL)
    return folder


@pytest.fixture
def copy(whole, tmp_path):
    shutil.copytree(whole / "out", tmp_path / "out")
    return tmp_path


def same_files(one, other):
    names = sorted(path.name for path in (one / "out").glob("*.h5"))
    assert names == sorted(path.name for path in (other / "out").glob("*.h5"))
    return all(filecmp.cmp(one / "out" / name, other / "out" / name, shallow=False) for name in names)


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def empty(path):
    path.write_bytes(b"")


def flip(path):  # a bit of the last image
    with h5py.File(path) as file:
        array = file["data/image/values"]
        place = array.id.get_chunk_info(3)
    with open(path, "r+b") as file:
        file.seek(place.byte_offset + place.size // 2)
        byte = file.read(1)[0]
        file.seek(-1, 1)
        file.write(bytes([byte ^ 4]))


def flip_number(path):
    with h5py.File(path) as file:
        place = file["insonify/frequency"].id.get_chunk_info(0)
    with open(path, "r+b") as file:
        file.seek(place.byte_offset + 1)
        file.write(b"\x42")


def other_dataset(path):
    with h5py.File(path, "r+") as file:
        file["insonify"].attrs["options"] = "seed = 7\n"


def os_remove(path):
    path.unlink()


@pytest.mark.parametrize("damage", [os_remove, cut, empty])
def test_the_whole_file_says_which_samples_exist(copy, damage):
    damage(copy / "out" / "part-000002.h5")
    expected = np.ones(24)
    expected[8:12] = 0
    with whole_of(copy) as file:
        np.testing.assert_array_equal(file["insonify/present"], expected)
        for name in ("data/depth/values", "data/incidence/values", "data/image/coordinates", "metadata/probe_pose/rotation", "insonify/frequency", "insonify/needle"):
            assert np.isnan(file[name][8:12]).all() and not np.isnan(file[name][12:]).any(), name
        assert (file["insonify/number"][8:12] == 2**32 - 1).all()
        assert (file["data/image/values"][8:12] == 255).all()
        assert not file["data/segmentation/values"][8:12].any()  # no label, not even the background
        assert file["data/segmentation/values"][:8].any(axis=-1).all()
    data = samples(copy / "out")
    assert len(data) == 20 and data.missing == 4 and [one["number"] for one in data][8] == 12


@pytest.mark.parametrize("damage", [os_remove, cut, empty, flip, flip_number, other_dataset])
def test_damage_is_found_and_mended(whole, copy, damage):
    damage(copy / "out" / "part-000002.h5")
    before = sorted(path.name for path in (copy / "out").iterdir())
    told = run(copy, *SMALL, "--verify", check=False)
    assert told.returncode == 1 and "part-000002.h5: " in told.stdout and "5 of 6 parts in 'out' are whole; the same command without --verify" in told.stdout
    assert before == sorted(path.name for path in (copy / "out").iterdir())
    run(copy, *SMALL)
    assert same_files(whole, copy)
    assert "6 of 6 parts in 'out' are whole\n" in run(copy, *SMALL, "--verify").stdout


def flip_at(path, place):
    with open(path, "r+b") as file:
        file.seek(place)
        byte = file.read(1)[0]
        file.seek(place)
        file.write(bytes([byte ^ 255]))


def test_no_byte_of_a_part_is_damaged_unseen(copy):
    """Also those of texts, attributes and the places of arrays."""
    chance = np.random.default_rng(1)
    parts = sorted((copy / "out").glob("part-*.h5"))
    for _ in range(10):
        places = [int(chance.integers(path.stat().st_size)) for path in parts]
        for path, place in zip(parts, places):
            flip_at(path, place)
        assert "0 of 6 parts in 'out' are whole" in run(copy, *SMALL, "--verify", check=False).stdout, places
        for path, place in zip(parts, places):
            flip_at(path, place)
    assert "6 of 6 parts in 'out' are whole\n" in run(copy, *SMALL, "--verify").stdout


def flip_middle(path):
    flip_at(path, path.stat().st_size // 2)


def test_verify_sees_every_part(copy):
    for part in range(1, 6):
        (copy / "out" / f"part-{part:06}.h5").unlink()
    cut(copy / "out" / "part-000000.h5")
    told = run(copy, *SMALL, "--verify", check=False)
    assert told.returncode == 1 and told.stdout.count("is missing") == 5 and "part-000000.h5: is cut short" in told.stdout


def test_png_files_are_verified(tmp_path):
    options = [*SMALL, "--samples=6", "--format", "png", "--iq"]
    run(tmp_path, *options)
    part = tmp_path / "out" / "part-000001"
    contents = {path.name: path.read_bytes() for path in part.iterdir()}
    damages = [("00000004.png", cut), ("00000005_label.png", empty), ("00000004.json", cut), ("00000005_iq.npy", os_remove)]
    damages += [(name, flip_middle) for name in contents]
    for name, damage in damages:
        damage(part / name)
        told = run(tmp_path, *options, "--verify", check=False)
        assert told.returncode == 1 and name in told.stdout
        run(tmp_path, *options)
        assert contents == {path.name: path.read_bytes() for path in part.iterdir()}


@pytest.mark.parametrize("form", ["hdf5", "png"])
def test_more_samples_of_the_same_description(tmp_path, form):
    (tmp_path / "few").mkdir()
    (tmp_path / "many").mkdir()
    run(tmp_path / "few", *QUICK, "--format", form, "--samples", "6")
    first = (tmp_path / "few" / "out" / ("part-000000.h5" if form == "hdf5" else "part-000000/00000000.png")).stat().st_mtime_ns
    run(tmp_path / "few", *QUICK, "--format", form, "--samples", "13")
    run(tmp_path / "many", *QUICK, "--format", form, "--samples", "13")
    assert first == (tmp_path / "few" / "out" / ("part-000000.h5" if form == "hdf5" else "part-000000/00000000.png")).stat().st_mtime_ns
    few, many = ({path.relative_to(tmp_path / name): path.read_bytes() for path in (tmp_path / name).rglob("*") if path.is_file()} for name in ("few", "many"))
    assert few == many
    done = run(tmp_path / "few", *QUICK, "--format", form, "--samples", "5", check=False)
    assert done.returncode == 1 and "--samples: 'out' has 13 samples already; ask for as many or more" in done.stderr


def test_a_folder_that_was_moved_is_the_same(whole, copy):
    (copy / "elsewhere").mkdir()
    (copy / "out").rename(copy / "elsewhere" / "renamed")
    run(copy, *SMALL, output="elsewhere/renamed")
    (copy / "elsewhere" / "renamed").rename(copy / "out")
    assert same_files(whole, copy)


def test_a_description_is_read_by_config(tmp_path):
    write_balls(tmp_path / "two balls.obj", bone=15, blood=30)
    (tmp_path / "elsewhere").mkdir()
    run(tmp_path, *TINY, "--anatomy", "two balls.obj", "--around", "blood", "--from", "0,-1,0.1", "--lateral", "1,0,0", "--unit", "1mm", "--frequency", "5..9", "--iq")
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    run(tmp_path / "elsewhere", "--config", "../out/description.ini", output="../out")  # from another folder
    run(tmp_path / "elsewhere", "--config", "../out/description.ini", output="../again")
    for name in ("out", "again"):
        assert before == {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}


@pytest.mark.parametrize("changed", ["balls.obj", "balls.mtl"])
def test_an_anatomy_that_changed_is_another_description(tmp_path, changed):
    write_balls(tmp_path / "balls.obj", bone=15)
    (tmp_path / "balls.obj").write_text("mtllib balls.mtl\n" + (tmp_path / "balls.obj").read_text().replace("usemtl bone", "usemtl mine"))
    (tmp_path / "balls.mtl").write_text("newmtl mine\ndensity 1900\nsound_speed 3500\nattenuation 5\n")
    options = [*TINY, "--anatomy", "balls.obj", "--around", "bone"]
    run(tmp_path, *options)
    run(tmp_path, *options, "--samples=3")
    text = (tmp_path / changed).read_text()
    (tmp_path / changed).write_text(text.replace("1900", "1800") if "mtl" in changed else text + "# one line more\n")
    done = run(tmp_path, *options, "--samples=4", check=False)
    assert done.returncode == 1 and "another description" in done.stderr and "content of anatomy 0" in done.stderr


def test_another_description_is_refused_and_named(whole):
    done = run(whole, *SMALL, "--seed", "2", check=False)
    assert done.returncode == 1 and "'out' holds samples of another description: 'seed' is 1 there, and 2 here" in done.stderr
    done = run(whole, *SMALL, "--gain", "3", "--verify", check=False)
    assert done.returncode == 1 and "'gain' is 0 there, and 3 here" in done.stderr


def test_files_of_others_stay(tmp_path):
    """The name of the folder, and other files in it, may contain the word draft."""
    folder = tmp_path / "my.draft"
    folder.mkdir()
    for name in ("thesis.draft", "part-one.draft1.txt", "part-000001.h5.draft7", "dataset.h5.draft"):
        (folder / name).write_text("text")
    run(tmp_path, *TINY, output="my.draft")
    run(tmp_path, *TINY, output="my.draft")
    assert (folder / "thesis.draft").exists() and (folder / "part-one.draft1.txt").exists() and (folder / "part-000000.h5").exists()
    assert not (folder / "part-000001.h5.draft7").exists() and not (folder / "dataset.h5.draft").exists()


def check_clean_end(done, folder):
    assert done.returncode == 1, done.stderr[-2000:]  # and no signal
    told = [line for line in done.stderr.splitlines() if line.strip() and "samples/s" not in line]
    assert len(told) == 1 and told[0].startswith("dataset: ") and "HDF5" not in told[0]
    assert not list(folder.rglob("*draft*"))


@pytest.mark.parametrize("form, ranks", [("hdf5", 1), ("png", 1), ("hdf5", 2)])
def test_a_full_disk_leaves_nothing_half_written(tmp_path, form, ranks):
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=900k", "tmpfs", tmp_path], capture_output=True)
    if mounted.returncode != 0:
        pytest.skip("mounting needs root")
    try:
        done = run(tmp_path, *QUICK, "--samples", "400", "--format", form, check=False, ranks=ranks)
        assert "is the disk full" in done.stderr or "check the free space on the disk" in done.stderr
        if ranks == 1:
            check_clean_end(done, tmp_path / "out")
        assert done.returncode == 1 and "HDF5" not in done.stderr
        assert list((tmp_path / "out").glob("part-*"))
        for part in (tmp_path / "out").glob("part-*.h5"):
            with h5py.File(part) as file:
                assert file["data/image/values"][:].shape[0] == 4
    finally:
        subprocess.run(["umount", tmp_path], check=True)


def test_a_limit_of_the_file_size_is_as_a_full_disk(tmp_path):
    running = subprocess.Popen([PROGRAM, "--output", "out", *QUICK, "--samples", "400"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "out" / "description.ini").exists() and running.poll() is None:
        time.sleep(0.01)
    resource.prlimit(running.pid, resource.RLIMIT_FSIZE, (20000, resource.RLIM_INFINITY))  # MPI has its files by now
    _, told = running.communicate(timeout=300)
    check_clean_end(subprocess.CompletedProcess([], running.returncode, "", told), tmp_path / "out")
    assert "cannot write out/part-" in told and "is the disk full" in told


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "out").write_text("a file")
    done = run(tmp_path, *SMALL, check=False)
    assert done.returncode != 0 and "--output: cannot create 'out'" in done.stderr


def test_one_rank_tells_what_is_wrong(tmp_path):
    done = run(tmp_path, *SMALL, "--lines", "0", ranks=3, check=False)
    assert done.returncode != 0 and done.stderr.count("--lines: 0 is out of range") == 1
