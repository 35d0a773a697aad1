"""What the files contain, by the rules of zea's layout; and whether it is true."""
import json

import h5py
import numpy as np
import pytest
from helpers import PLAIN, SMALL, STRAIGHT, TINY, labels_of, run, whole_of, write_balls

from insonify_samples import pose, samples

TEXT = h5py.string_dtype()


def is_text(leaf):
    return h5py.check_string_dtype(leaf.dtype) is not None and h5py.check_string_dtype(leaf.dtype).encoding == "utf-8"


def check_map(name, group, frames):
    """A map gives each point of space a value: values, their coordinates, and labels of what has an axis of channels."""
    values, points = group["values"], group["coordinates"]
    channels = {"segmentation": 1, "beamformed_data": 1, "displacement": 1, "strain": 1}.get(name, 0)
    assert values.shape[0] == frames
    assert points.dtype == np.float32 and points.shape == (*values.shape[: values.ndim - channels], 3), name
    assert np.isfinite(points[:]).all() and np.abs(points[:]).max() < 1  # metres
    for key in ("unit", "description"):
        assert is_text(group[key]) and group[key].shape == ()
    if channels:
        assert is_text(group["labels"]) and group["labels"].shape == values.shape[-1:]
    else:
        assert "labels" not in group
    if name == "image":
        assert values.dtype == np.uint8 and values.ndim in (3, 4)
    elif name == "segmentation":
        assert values.dtype == np.bool_ and values.ndim == 5  # frames, z, x, y, labels
    elif channels:
        assert values.dtype == np.float32 and values.ndim in (4, 5)
        assert [each.decode() for each in group["labels"]] == {"beamformed_data": ["I", "Q"], "displacement": ["x", "z"], "strain": ["lateral", "axial", "shear"]}[name]
    else:
        assert values.dtype == np.float32 and values.ndim in (3, 4)
    assert set(group) <= {"values", "coordinates", "labels", "unit", "description", "min", "max"} | ({"gamma"} if name == "attenuation_map" else set())


def check_layout(file):
    assert isinstance(file.attrs["zea_version"], str) and file.attrs["zea_version"]
    for key in ("us_machine", "description"):
        assert isinstance(file.attrs[key], str)

    def check_leaf(path, leaf):
        if isinstance(leaf, h5py.Dataset):
            assert isinstance(leaf.attrs["unit"], str) and isinstance(leaf.attrs["description"], str), path
            assert leaf.attrs["unit"] and leaf.attrs["description"], path
            assert leaf.dtype in (np.float32, np.uint8, np.uint32, np.bool_) or is_text(leaf), path

    file.visititems(check_leaf)
    assert set(file) <= {"tracks", "probe", "metadata", "metrics", "custom", "data", "insonify"}
    assert list(file["tracks"]) == ["track_0"]
    track = file["tracks/track_0"]
    assert list(track) == ["data"]  # a scan belongs to channel data alone
    frames = track["data/image/values"].shape[0]
    for name, group in track["data"].items():
        check_map(name, group, frames)
    at = file["metadata/probe_pose"]
    assert at["translation"].shape == (frames, 3) and at["translation"].dtype == np.float32
    width = {"euler_xyz": 3, "quaternion_wxyz": 4, "quaternion_xyzw": 4}[at["rotation_representation"][()].decode()]
    assert at["rotation"].shape == (frames, width) and at["rotation"].dtype == np.float32
    for key in ("start_time_offset", "sampling_frequency"):
        assert at[key].shape == () and at[key].dtype == np.float32
    assert at["sampling_frequency"][()] > 0
    if "probe" in file:  # one for all samples
        assert set(file["probe"]) == {"name", "type"} and file["probe/type"][()].decode() in ("linear", "phased", "curved")
    assert file["data"] == track["data"]  # the short name


@pytest.mark.parametrize("options", [[], ["--iq", "--looks", "2"], ["--no-truth"], ["--iq", "--probe", "convex", "--depth", "60..90"], ["--probe", "phased", "--iq", "--no-truth"]], ids=" ".join)
def test_files_have_the_layout_of_zea(tmp_path, options):
    run(tmp_path, *SMALL, "--samples=6", *options, "--pressure", "0")
    for name in ("part-000000.h5", "part-000001.h5", "dataset.h5"):
        with h5py.File(tmp_path / "out" / name) as file:
            check_layout(file)
            maps = {"image", "segmentation"}
            maps |= set() if "--no-truth" in options else {"incidence", "transmitted", "depth"}
            maps |= {"beamformed_data", "envelope_data"} if "--iq" in options else set()
            assert set(file["data"]) == maps
    with whole_of(tmp_path) as whole, h5py.File(tmp_path / "out" / "part-000001.h5") as part:
        assert list(whole["insonify/number"]) == list(range(6))

        def check_rows(path, leaf):
            if isinstance(leaf, h5py.Dataset) and leaf.is_virtual:
                np.testing.assert_array_equal(leaf[4:], part[path][:])

        whole.visititems(check_rows)


def test_coordinates_are_those_of_the_probe(tmp_path):
    """Closed form: an array of 38 mm and an image of 40 mm."""
    run(tmp_path, *SMALL, "--samples=2", "--iq")
    with whole_of(tmp_path) as file:
        centres = (np.arange(64) + 0.5) / 64
        points = file["data/image/coordinates"][1]
        np.testing.assert_allclose(points[5, :, 0], 0.038 * (centres - 0.5), atol=1e-7)
        np.testing.assert_allclose(points[:, 5, 2], 0.040 * centres, atol=1e-7)
        assert (points[..., 1] == 0).all()
        np.testing.assert_array_equal(file["data/segmentation/coordinates"][1][:, :, 0], points)
        along = file["data/beamformed_data/coordinates"][1]
        count = len(along)
        np.testing.assert_allclose(along[7, :, 0], 0.038 * ((np.arange(48) + 0.5) / 48 - 0.5), atol=1e-7)
        np.testing.assert_allclose(along[:, 7, 2], 0.040 * (np.arange(count) + 0.5) / count, atol=1e-7)
        np.testing.assert_allclose(file["insonify/sampling_frequency"][:], 1540 / 2 * count / 0.040, rtol=1e-6)


@pytest.mark.parametrize("probe", ["linear", "convex", "phased"])
@pytest.mark.parametrize("looks", ["1", "2", "3"])
def test_iq_lies_where_its_coordinates_say(tmp_path, probe, looks):
    """The strongest echo of a ball of bone in water is on its surface, whatever the frequency and the number of looks."""
    write_balls(tmp_path / "balls.obj", bone=8)
    run(tmp_path, *PLAIN, "--anatomy", "balls.obj", "--background", "water", "--around", "bone", "--standoff", "15..20", "--samples", "6", "--part", "4",
        "--size", "96", "--lines", "64", "--planes", "1", "--frequency", "3..6", "--depth", "40..45", "--along", "-3..3", "--across", "0",
        "--spread", "0..10", "--turn", "-90..90", "--tilt", "0", "--probe", probe, "--looks", looks, "--iq", "--media", "0.8..1.25")
    with whole_of(tmp_path) as file:
        speed = file["insonify/label_media"][0, 0, 1] * file["insonify/scale"][0]
        for row in range(6):
            matrix = pose(file["metadata/probe_pose/translation"][row], file["metadata/probe_pose/rotation"][row])
            for name in ("beamformed_data", "envelope_data"):
                echo = file["data"][name]["values"][row]
                echo = np.hypot(echo[..., 0], echo[..., 1]) if name == "beamformed_data" else echo
                points = file["data"][name]["coordinates"][row]
                echo[: len(echo) // 5] = 0  # the echoes of the probe itself
                assert np.isfinite(echo).all() and (echo[-20:] > 0).any()  # to the end
                line = np.unravel_index(echo.argmax(), echo.shape)
                origin = points[0, line[1]] - 0.5 / (len(points) - 1) * (points[-1, line[1]] - points[0, line[1]])
                seen = origin + (points[line] - origin) * speed / 1540  # echoes are displayed with 1540 m/s
                place = matrix[:3, :3] @ seen + matrix[:3, 3]
                off = 1e3 * np.linalg.norm(place - [0, 0, 0.040]) - 8
                print(f"{name} of sample {row}: {off:+.2f} mm from the surface")
                assert abs(off) < 0.3


def test_iq_is_as_long_in_every_sample_and_the_picture_is_that_of_the_same_lines(tmp_path):
    run(tmp_path, *SMALL, "--samples=4", "--iq", "--frequency", "6..9", "--noise", "-300")
    with whole_of(tmp_path) as file:
        envelope, image = file["data/envelope_data/values"][:], file["data/image/values"][:]
        iq = file["data/beamformed_data/values"][:]
        np.testing.assert_allclose(envelope, np.hypot(iq[..., 0], iq[..., 1]), rtol=1e-5, atol=1e-12)
        for one, picture in zip(envelope, image):
            assert (one[-8:].max() > 0) and np.isfinite(one).all()
            rows = np.arange(64) * len(one) // 64
            level = np.log(np.maximum(one[rows][:, np.arange(64) * 48 // 64], 1e-9))
            alike = np.corrcoef(level.ravel(), picture.ravel())[0, 1]
            print(f"correlation of levels {alike:.2f}")
            assert alike > 0.6


def test_png_beside_json(tmp_path):
    run(tmp_path, *SMALL, "--format", "png", "--iq")
    run(tmp_path, *SMALL, "--iq", output="hdf5")
    texts = sorted((tmp_path / "out").glob("part-*/*.json"))
    assert len(texts) == 24
    one = json.loads(texts[5].read_text())
    assert one["number"] == 5 and one["frequency"] == 7.5 and 0 <= one["pressure"] <= 3 and "needle" in one["labels"]
    assert texts[5].with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    with h5py.File(tmp_path / "hdf5" / "dataset.h5") as file:
        np.testing.assert_array_equal(np.float32(one["translation"]), file["metadata/probe_pose/translation"][5])
        np.testing.assert_array_equal(np.float32(one["rotation"]), file["metadata/probe_pose/rotation"][5])
        np.testing.assert_array_equal(np.array(one["media"], np.float32), file["insonify/media"][5])
        for name in ("bend_wave", "contact_profile", "planes", "looks", "fnumber", "face_width", "bandwidth"):
            np.testing.assert_array_equal(np.float32(one[name]), file["insonify"][name][5])
        echoes = np.load(texts[5].with_name("00000005_iq.npy"))
        np.testing.assert_array_equal(np.stack([echoes.real, echoes.imag], -1), file["data/beamformed_data/values"][5])


def test_what_was_done_can_be_recovered(tmp_path):
    """The ball's centre is found from the label, with the pose, the bend and the scale that are stored."""
    write_balls(tmp_path / "balls.obj", bone=15)
    run(tmp_path, *PLAIN, "--anatomy", "balls.obj", "--background", "water", "--around", "bone", *STRAIGHT, "--bend", "0..3", "--scale", "0.8..1.2",
        "--samples", "6", "--size", "200", "--lines", "128", "--planes", "1", "--media", "0.5..2")
    with whole_of(tmp_path) as file:
        labels, about = labels_of(file), file["insonify"]
        media = about["media"][:]
        assert media.shape == (6, 2, 2) and (media >= 0.5).all() and (media <= 2).all() and len(np.unique(media)) == 24
        np.testing.assert_allclose(about["label_media"][0, 1, :2], [1900, 3500], rtol=0.3)
        for row in range(6):
            matrix = pose(file["metadata/probe_pose/translation"][row], file["metadata/probe_pose/rotation"][row])
            points = file["data/image/coordinates"][row]
            edge = [points[np.flatnonzero(labels[row][:, c] == 1)[0], c] for c in range(60, 140) if (labels[row][:, c] == 1).any()]
            local = np.array(edge) @ matrix[:3, :3].T + matrix[:3, 3]
            rest = local.copy()
            for _ in range(30):  # the point that the bend moved here
                wave = np.sin(rest @ about["bend_wave"][row].T + about["bend_phase"][row])
                rest = local - about["bend_amplitude"][row] * wave @ about["bend_direction"][row]
            of_file = rest / about["scale"][row]
            off = np.linalg.norm(of_file - [0, 0, 0.040], axis=1) - 0.015
            print(f"scale {about['scale'][row]:.2f}, bend {about['bend'][row]:.1f} mm: {1e3 * np.abs(off).max():.2f} mm from the surface at most")
            assert np.abs(off).max() < 0.4e-3


def test_channels_are_those_of_an_array_where_the_probe_is(tmp_path):
    channels = ["--probe", "phased", "--channels", "p4_2v", "--transmits", "plane:3:20", "--depth", "20..30"]
    run(tmp_path, *TINY, *channels)
    with whole_of(tmp_path) as file:
        track = file["tracks/track_0"]
        raw, scan, probe = track["data/raw_data"], track["scan"], file["probe"]
        frames, transmits, length, elements, parts = raw.shape
        assert raw.dtype == np.float32 and (frames, transmits, elements, parts) == (2, 3, 64, 1)
        assert raw.attrs["unit"] and raw.attrs["description"]
        for name in ("t0_delays", "tx_apodizations"):
            assert scan[name].shape == (transmits, elements), name
        for name in ("initial_times", "focus_distances", "polar_angles", "azimuth_angles"):
            assert scan[name].shape == (transmits,), name
        assert scan["transmit_origins"].shape == (transmits, 3) and probe["probe_geometry"].shape == (elements, 3)
        np.testing.assert_allclose(np.degrees(scan["polar_angles"][:]), [-10, 0, 10], atol=1e-4)
        assert probe["type"][()] == b"phased" and scan["sampling_frequency"][()] == 4 * scan["center_frequency"][()]
        # As long as the deepest image, there and back.
        assert length / scan["sampling_frequency"][()] > 2 * 0.030 / 1540
        values = raw[:]
        assert np.isfinite(values).all() and np.abs(values).max(axis=(1, 2, 3, 4)).min() > 1e-4
        assert np.abs(values[0] - values[1]).max() > 1e-4
    one = samples(tmp_path / "out", channels=True)[1]
    np.testing.assert_array_equal(one["raw_data"], values[1, ..., 0])


def test_the_tissue_of_channel_data_is_on_the_slice_of_its_array(tmp_path):
    """Closed form: strain is the slope of displacement, which is that of the probe's contact; sound speeds are those of the media."""
    options = ["--probe", "phased", "--channels", "p4_2v", "--transmits", "plane:1:0", "--depth", "20..25", "--pressure", "1..2", "--tilt", "0", "--rock", "0"]
    run(tmp_path, *TINY, *options)
    with whole_of(tmp_path) as file:
        data = file["data"]
        maps = {"sos_map": (), "attenuation_map": (), "displacement": (2,), "strain": (3,)}
        assert set(data) == {"image", "segmentation", "incidence", "transmitted", "depth", "raw_data", *maps}
        for name, last in maps.items():
            check_map(name, data[name], 2)
            assert data[name]["values"].shape[3:] == last and data[name]["unit"][()].decode() == {"sos_map": "m/s", "attenuation_map": "dB/m/Hz", "displacement": "m", "strain": "\u2013"}[name]
            np.testing.assert_array_equal(data[name]["coordinates"][:], data["sos_map/coordinates"][:])
        assert data["attenuation_map/gamma"][()] == 1
        points = data["sos_map/coordinates"][0].astype(float)
        step = points[1, 0, 2]
        assert step == pytest.approx(0.5 * 1540 / file["tracks/track_0/scan/center_frequency"][()])
        assert abs(points[-1, 0, 2] - 0.025) < step and np.allclose(np.diff(points[0, :, 0]), step, rtol=1e-4)
        speeds = file["insonify/label_media"][0, :, 1]
        for row in range(2):
            assert np.isin(data["sos_map/values"][row], speeds).all() and len(np.unique(data["sos_map/values"][row])) > 3
            moved, strain = data["displacement/values"][row].astype(float), data["strain/values"][row].astype(float)
            pressed = file["insonify/contact_depth"][row]
            print(f"pressed in by {1e3 * pressed:.2f} mm; tissue moves by up to {1e3 * moved[..., 1].max():.2f} mm")
            assert 1e-3 < pressed < 3e-3 and 0.7 * pressed < moved[..., 1].max() < 1.01 * pressed
            axial = 1 / (1 - np.gradient(moved[..., 1], step, axis=0)) - 1
            off = np.abs(strain[..., 1] - axial)
            print(f"largest strain {np.abs(strain[..., 1]).max():.3f}, differs from the slope by {np.quantile(off, 0.95):.1e} or less in 95 % of the pixels")
            assert strain[..., 1].min() < -0.02 and np.quantile(off, 0.95) < 2e-3
    one = samples(tmp_path / "out", tissue=True)[1]
    np.testing.assert_array_equal(one["strain"], strain.astype(np.float32))
    run(tmp_path, *TINY, *options, "--no-truth", output="without")
    with whole_of(tmp_path, "without") as file:
        assert set(file["data"]) == {"image", "segmentation", "raw_data"}


def test_channels_of_another_kind_or_place_are_refused(tmp_path):
    for options, sentence in {
        ("--channels", "c5_2v", "--probe", "linear"): "--channels: c5_2v is a curved array, but there are linear probes",
        ("--channels", "l11_5v", "--format", "png"): "--channels: PNG files have no place for them; use --format hdf5",
        ("--channels", "l11_5v", "--transmits", "plane:0:3"): "--transmits: 'plane:0:3': the count 0",
    }.items():
        done = run(tmp_path, *TINY, *options, check=False)
        assert done.returncode == 1 and sentence in done.stderr and not list(tmp_path.iterdir())
