"""Files of `channels` against the rules of their formats, and the places of points in images made from them.

CHANNELS names the program."""
import os
import pathlib
import resource
import signal
import subprocess
import sys

import h5py
import numpy as np
import pytest

PROGRAM = os.environ["CHANNELS"]
sys.path.insert(0, str(pathlib.Path(__file__).parent.parent))
import beamform  # noqa: E402

SHALLOW = ["--depth", "22"]  # down to the second row of points
DASH = "\u2013"  # the unit of what has none


def run(folder, *options, check=True, **how):
    done = subprocess.run([PROGRAM, *options], cwd=folder, capture_output=True, text=True, timeout=300, **how)
    assert not check or done.returncode == 0, done.stderr
    return done


def made(folder, *options):
    run(folder, "--phantom", "points", *SHALLOW, *options)
    return h5py.File(folder / "channels.hdf5")


SCAN = {  # unit, shape, range, whether it is required
    "sampling_frequency": ("Hz", [()], (1, np.inf), True),
    "center_frequency": ("Hz", [(), ("n_tx",)], (0, np.inf), True),
    "demodulation_frequency": ("Hz", [(), ("n_tx",)], (0, np.inf), True),
    "initial_times": ("s", [("n_tx",)], (-1, 1), True),
    "t0_delays": ("s", [("n_tx", "n_el")], (0, 1), True),
    "tx_apodizations": (DASH, [("n_tx", "n_el")], (-1, 1), True),
    "focus_distances": ("m", [("n_tx",)], (-1, np.inf), True),
    "transmit_origins": ("m", [("n_tx", 3)], (-1, 1), True),
    "polar_angles": ("rad", [("n_tx",)], (-np.pi, np.pi), True),
    "azimuth_angles": ("rad", [("n_tx",)], (-np.pi, np.pi), False),
    "sound_speed": ("m/s", [()], (1, np.inf), False),
    "waveforms_two_way": ("V", [("n_tx", "n")], (-1, 1), False),
}
PROBE = {
    "probe_geometry": ("m", [("n_el", 3)], (-1, 1), True),
    "probe_center_frequency": ("Hz", [()], (1, np.inf), False),
    "probe_bandwidth_percent": ("%", [()], (1, 200), False),
    "element_width": ("m", [()], (1e-6, 1e-2), False),
    "element_height": ("m", [()], (1e-6, 1e-1), False),
}
MAPS = {  # unit, labels of the last axis, axes of space and frames
    "sos_map": ("m/s", None, 3),
    "attenuation_map": ("dB/m/Hz", None, 3),
    "segmentation": (DASH, [], 4),
    "displacement": ("m", ["x", "z"], 3),
    "strain": (DASH, ["lateral", "axial", "shear"], 3),
}


def check_zea(file):
    raw = file["tracks/track_0/data/raw_data"]
    assert raw.dtype == np.float32 and raw.ndim == 5 and np.isfinite(raw[:]).all() and raw[:].any()
    sizes = dict(zip(("n_frames", "n_tx", "n_ax", "n_el", "n_ch"), raw.shape))
    for group, rules in (("tracks/track_0/scan", SCAN), ("probe", PROBE)):
        for name, (unit, shapes, (low, high), required) in rules.items():
            assert name in file[group] or not required, name
            field = file[group][name]
            assert field.dtype == np.float32 and field.attrs["unit"] == unit, name
            assert any(
                field.ndim == len(shape) and all(sizes.get(axis, axis) in (size, "n") for size, axis in zip(field.shape, shape))
                for shape in shapes
            ), (name, field.shape)
            assert (field[()] >= low).all() and (field[()] <= high).all(), name
        assert {*file[group]} <= {*rules, "name", "type"}
    assert (file["tracks/track_0/scan/t0_delays"][:].min(axis=1) == 0).all()
    assert file["probe/type"].asstr()[()] in ("linear", "phased", "curved") and file["probe/name"].asstr()[()]
    pose = file["metadata/probe_pose"]
    assert pose["translation"].shape == (sizes["n_frames"], 3) and pose["rotation"].shape == (sizes["n_frames"], 4)
    assert pose["rotation_representation"].asstr()[()] == "quaternion_wxyz"
    np.testing.assert_allclose(np.linalg.norm(pose["rotation"], axis=1), 1, atol=1e-5)
    for name, (unit, labels, axes) in MAPS.items():
        group = file["tracks/track_0/data"][name]
        values, places = group["values"], group["coordinates"]
        fields = {"values", "coordinates", "unit", "description"} | ({"labels"} if labels is not None else set()) | ({"gamma"} if name == "attenuation_map" else set())
        assert set(group) == fields, name
        assert group["unit"].asstr()[()] == unit and values.attrs["unit"] == unit and group["description"].asstr()[()]
        assert values.shape[0] == sizes["n_frames"] and np.isfinite(values[:]).all()
        assert places.dtype == np.float32 and np.abs(places[:]).max() < 1
        spatial = values.shape if labels is None else values.shape[:-1]
        assert places.shape == (*spatial, 3) and len(spatial) == axes
        assert values.dtype == (bool if name == "segmentation" else np.float32)
        if labels is not None:
            assert group["labels"].shape == values.shape[-1:] and (not labels or [*group["labels"].asstr()[:]] == labels)
        rows, columns = places[0, :, 0, ..., 2].ravel(), places[0, 0, :, ..., 0].ravel()
        assert abs(rows[0] - file["probe/probe_geometry"][:, 2].min()) < 1e-6 and (np.diff(rows) > 0).all() and (np.diff(columns) > 0).all()
    masks = file["tracks/track_0/data/segmentation"]
    assert (masks["values"][:].sum(axis=-1) == 1).all()
    assert (file["tracks/track_0/data/sos_map/values"][:] > 300).all()
    assert file["tracks/track_0/data/attenuation_map/gamma"].shape == ()
    assert file.attrs["zea_version"]
    assert {*file} <= {"tracks", "probe", "metadata", "custom"}

    def check_leaf(name, node):
        if isinstance(node, h5py.Dataset):
            assert isinstance(node.attrs["unit"], str) and node.attrs["unit"], name
            assert isinstance(node.attrs["description"], str) and node.attrs["description"], name

    file.visititems(check_leaf)
    return sizes


def peak_near(point, image_of):
    """Where the image has its maximum within 1 mm of a point."""
    x, z = point[0] + np.linspace(-1e-3, 1e-3, 41), point[2] + np.linspace(-1e-3, 1e-3, 81)
    row, column = np.unravel_index(np.argmax(np.abs(image_of(x, z))), (len(z), len(x)))
    return x[column], z[row]


@pytest.mark.parametrize(
    "array, transmits, kind, options",
    [
        ("l11_5v", "plane:3:20", "linear", []),
        ("l11_5v", "plane:1:0", "linear", ["--iq"]),
        ("l12_3v", "focused:5:20mm", "linear", ["--sampling-frequency", "40"]),
        ("c5_2v", "fsa", "curved", ["--iq"]),
        ("c5_2v", "focused:5:40mm:40", "curved", []),
        ("p4_2v", "diverging:3:30:15mm", "phased", ["--wave-fronts", "--frames", "2", "--noise", "-70"]),
    ],
)
def test_zea(tmp_path, array, transmits, kind, options):
    with made(tmp_path, "--array", array, "--transmits", transmits, *options) as file:
        sizes = check_zea(file)
        elements = {"l11_5v": 128, "l12_3v": 192, "c5_2v": 128, "p4_2v": 64}[array]
        count = elements if transmits == "fsa" else int(transmits.split(":")[1])
        assert sizes["n_tx"] == count and sizes["n_el"] == elements
        assert sizes["n_ch"] == (2 if "--iq" in options else 1) and sizes["n_frames"] == (2 if "--frames" in options else 1)
        assert file["probe/type"].asstr()[()] == kind
        raw = file["tracks/track_0/data/raw_data"]
        assert sizes["n_frames"] == 1 or not np.array_equal(raw[0], raw[1])  # noise
        rate = file["tracks/track_0/scan/sampling_frequency"][()]
        assert "40" not in options or rate == 40e6
        focus = file["tracks/track_0/scan/focus_distances"][:]
        assert {"plane": np.isinf(focus), "focused": focus > 0, "diverging": focus < 0, "fsa": focus == 0}[transmits.split(":")[0]].all()
        for point in [(0, 0, 20e-3)] if array != "l11_5v" else [(0, 0, 10e-3), (0, 0, 20e-3), (10e-3, 0, 20e-3)]:
            assert min(np.linalg.norm(file["custom/point_scatterers"][:] - point, axis=1)) < 1e-6
            found = peak_near(point, lambda x, z: beamform.beamform(file, x, z))
            wavelength = 1540 / file["tracks/track_0/scan/center_frequency"][()]
            assert abs(found[0] - point[0]) < wavelength / 2 and abs(found[1] - point[2]) < wavelength / 4, found


def object_at(group):
    """An object of USTB as a dictionary, as its reader has it: axes in MATLAB's order."""
    assert {"class", "name"} <= {*group.attrs} and group.attrs["name"] == group.name.split("/")[-1]
    if isinstance(group, h5py.Dataset):
        assert group.dtype == np.float32 and {"imaginary", "complex"} <= {*group.attrs} and group.attrs["complex"] == 0
        values = group[()].T
        return "".join(map(chr, values.ravel().astype(int))) if group.attrs["class"] == "char" else values
    if "complex" in group.attrs:
        assert group.attrs["complex"] == 1 and group["imag"].attrs["imaginary"] == 1 and group["real"].attrs["imaginary"] == 0
        return group["real"][()].T + 1j * group["imag"][()].T
    assert group.attrs["class"].startswith("uff.") and tuple(group.attrs["size"]) == (1, len(group) if group.attrs["array"] else 1)
    if group.attrs["array"]:
        assert [*group] == ["%s_%04d" % (group.attrs["name"], i + 1) for i in range(len(group))]
        return [object_at(one) for one in group.values()]
    return {name: object_at(one) for name, one in group.items()}


def scalar(value):
    assert value.shape == (1, 1)
    return float(value[0, 0])


def beamform_uff(data, x, z):
    """As USTB does it: process/das.m."""
    rate, carrier = scalar(data["sampling_frequency"]), scalar(data["modulation_frequency"])
    centre, speed = scalar(data["pulse"]["center_frequency"]), scalar(data["sound_speed"])
    geometry, samples = data["probe"]["geometry"], data["data"]
    x, z = np.meshgrid(x, z)
    image = np.zeros(x.shape, complex)
    for t, wave in enumerate(data["sequence"]):
        distance, azimuth = scalar(wave["source"]["distance"]), scalar(wave["source"]["azimuth"])
        if scalar(wave["wavefront"]) == 0:
            assert np.isinf(distance)
            sent = z * np.cos(azimuth) + x * np.sin(azimuth)
        else:
            at = distance * np.array([np.sin(azimuth), np.cos(azimuth)])
            sent = np.where(z < at[1], -1, 1) * np.hypot(x - at[0], z - at[1]) + (-distance if at[1] < -1e-3 else distance)
        sent = sent / scalar(wave["sound_speed"]) - scalar(wave["delay"])
        raw = samples[:, :, t, 0]
        raw = np.stack([raw.real, raw.imag], -1) if carrier else raw[..., None]
        signals = beamform.baseband(raw, rate, centre, scalar(data["pulse"]["fractional_bandwidth"]))
        for e, place in enumerate(geometry):
            time = sent + np.hypot(x - place[0], z - place[2]) / speed - scalar(data["initial_time"])
            signal = np.interp(4 * rate * time, np.arange(len(signals)), signals[:, e])
            image += (np.abs(x - place[0]) <= z / 3) * signal * np.exp(2j * np.pi * centre * time)
    return image


@pytest.mark.parametrize(
    "array, transmits, options",
    [
        ("l11_5v", "plane:3:20", ["--frames", "2", "--noise", "-90"]),
        ("l11_5v", "fsa", ["--iq"]),
        ("c5_2v", "fsa", []),
        ("l12_3v", "focused:5:20mm", ["--iq"]),
        ("p4_2v", "diverging:3:30:15mm", []),
    ],
)
def test_uff(tmp_path, array, transmits, options):
    with made(tmp_path, "--format", "uff", "--array", array, "--transmits", transmits, *options) as file:
        assert file.attrs["version"] in ("v1.0.0", "v1.0.1", "v1.1.0", "v1.1.1", "v1.2.0")
        assert file["channel_data"].attrs["class"] == "uff.channel_data"
        data = object_at(file["channel_data"])
    elements = len(data["probe"]["geometry"])
    assert data["probe"]["geometry"].shape == (elements, 7) and data["data"].shape[1] == elements
    assert data["data"].shape[2] == len(data["sequence"]) and data["data"].shape[3] == (2 if "--frames" in options else 1)
    assert np.iscomplexobj(data["data"]) == ("--iq" in options) == (scalar(data["modulation_frequency"]) > 0)
    assert data["phantom"]["points"].shape == (9, 4) and data["name"] == "nine point scatterers in a fluid of 1540 m/s"
    found = peak_near((0, 0, 20e-3), lambda x, z: beamform_uff(data, x, z))
    wavelength = 1540 / scalar(data["pulse"]["center_frequency"])
    assert abs(found[0]) < wavelength / 2 and abs(found[1] - 20e-3) < wavelength / 4, found


def test_truth_of_a_file(tmp_path):
    text = ["o cube", "usemtl bone"]  # from -5 to 5 mm, its top 15 mm below the array
    text += ["v %d %d %d" % (x, y, z) for z in (15, 25) for y in (-5, 5) for x in (-5, 5)]
    text += ["f %d %d %d" % f for f in [(1, 3, 4), (1, 4, 2), (5, 6, 8), (5, 8, 7), (1, 2, 6), (1, 6, 5), (3, 7, 8), (3, 8, 4), (1, 5, 7), (1, 7, 3), (2, 4, 8), (2, 8, 6)]]
    (tmp_path / "cube.obj").write_text("\n".join(text) + "\n")
    told = run(tmp_path, "cube.obj", "--unit", "1mm", "--background", "water", "--from", "0,0,0", "--towards", "0,0,10", "--lateral", "0,1,0",
               "--transmits", "plane:1:0", "--depth", "20", "--output", "cube.hdf5").stdout
    assert "cube.obj: 1 object, 10 x 10 x 10 mm" in told
    with h5py.File(tmp_path / "cube.hdf5") as file:
        sizes = check_zea(file)
        masks = file["tracks/track_0/data/segmentation"]
        places = masks["coordinates"][0, :, :, 0]
        assert [*masks["labels"].asstr()[:]] == ["background", "cube"]
        inside = (np.abs(places[..., 0]) < 5e-3) & (places[..., 2] > 15e-3)
        assert (masks["values"][0, :, :, 0, 1] == inside).mean() > 0.999
        speeds = file["tracks/track_0/data/sos_map/values"][0]
        assert len(np.unique(speeds)) == 2 and (speeds[inside] > 2000).mean() > 0.999
        np.testing.assert_allclose(file["metadata/probe_pose/translation"][0], 0, atol=1e-9)
        # x of the probe is y of the body, z stays, so that its y is -x: a quarter turn about z
        np.testing.assert_allclose(np.abs(file["metadata/probe_pose/rotation"][0]), [0.5**0.5, 0, 0, 0.5**0.5], atol=1e-6)
        # The echo of the top, where its travel time is, with the sound speed of water; the height of the elements, whose ends are
        # farther away, delays it by less than half a period.
        trace = file["tracks/track_0/data/raw_data"][0, 0, :, sizes["n_el"] // 2]
        rate = file["tracks/track_0/scan/sampling_frequency"][()]
        envelope = np.abs(beamform.baseband(trace[:, None, :], rate, 7.6e6, 0.77))[:, 0]
        assert abs(np.argmax(envelope) / (4 * rate) - 2 * 15e-3 / speeds.min()) < 60e-9


def test_a_region_is_recorded_in_its_view(tmp_path):
    """The probe of the view is pressed into the skin: what it displaces is in the file, and strain is the slope of displacement."""
    told = run(tmp_path, "--anatomy", "leg", "--view", "calf_transverse", "--parameter", "resolution=0.3", "--transmits", "plane:1:0", "--wave-fronts").stdout
    assert "Leg: thigh and calf" in told
    with h5py.File(tmp_path / "channels.hdf5") as file:
        check_zea(file)
        data = file["tracks/track_0/data"]
        masks, points = data["segmentation"], data["displacement/coordinates"][0]
        names = [*masks["labels"].asstr()[:]]
        assert {"skin", "gel"} < {*names}
        moved, strain = data["displacement/values"][0].astype(float), data["strain/values"][0].astype(float)
        middle = points.shape[1] // 2
        print(f"the skin is pressed in by {1e3 * moved[:, middle, 1].max():.2f} mm")
        assert 2e-3 < moved[:, middle, 1].max() < 3e-3  # 2.5 mm, of a probe that touches a round calf
        assert np.abs(moved[-1]).max() < 0.5 * moved[:, middle, 1].max()
        # F = 1 / (1 - du/dx), of tissue that is now at x, in the plane of the slice.
        step = points[1, 0, 2] - points[0, 0, 2]
        slope = np.stack([np.gradient(moved, step, axis=1), np.gradient(moved, step, axis=0)], -1)
        stretched = np.linalg.inv(np.eye(2) - slope)
        expected = np.stack([stretched[..., 0, 0] - 1, stretched[..., 1, 1] - 1, 0.5 * (stretched[..., 0, 1] + stretched[..., 1, 0])], -1)
        tissue = ~masks["values"][0, :, :, 0, names.index("gel")]
        inside = tissue.copy()
        inside[1:-1, 1:-1] &= tissue[:-2, 1:-1] & tissue[2:, 1:-1] & tissue[1:-1, :-2] & tissue[1:-1, 2:]
        off = np.abs(strain - expected)[inside]
        print(f"largest strain {np.abs(strain).max():.3f}, differs from the slope by {np.median(off):.1e}, of one in a hundred by {np.quantile(off, 0.99):.1e}")
        assert strain[..., 1].min() < -0.02 and np.quantile(off, 0.99) < 2e-3
        assert file["probe/name"].asstr()[()] == "L11-5v"


def test_a_view_chooses_the_kind_of_array_and_the_depth(tmp_path):
    run(tmp_path, "--anatomy", "lumbar", "--parameter", "resolution=0.3", "--transmits", "plane:1:0", "--wave-fronts")
    with h5py.File(tmp_path / "channels.hdf5") as file:
        assert file["probe/type"].asstr()[()] == "curved"
        assert file["tracks/track_0/data/sos_map/coordinates"][0, -1, 0, 2] > 0.06
    run(tmp_path, "--anatomy", "lumbar", "--parameter", "resolution=0.3", "--transmits", "plane:1:0", "--wave-fronts", "--array", "c5_2v", "--depth", "30")
    with h5py.File(tmp_path / "channels.hdf5") as file:
        assert file["probe/type"].asstr()[()] == "curved"
        assert 0.029 < file["tracks/track_0/data/sos_map/coordinates"][0, -1, 0, 2] <= 0.03


def test_an_array_of_another_kind_than_the_probe_of_a_view_is_refused(tmp_path):
    coarse = ["--parameter", "resolution=0.5", "--transmits", "plane:1:0", "--wave-fronts", "--depth", "20"]
    refused = "channels: --array: {} array, but a {} probe is pressed into the skin in the view '{}'; choose {}, or another place with --from\n"
    for view, array, words in (
        (["--anatomy", "lumbar"], "p4_2v", ("p4_2v is a phased", "curved", "paramedian_oblique", "c5_2v")),
        (["--anatomy", "leg", "--view", "calf_transverse"], "c5_2v", ("c5_2v is a curved", "linear", "calf_transverse", "l11_5v or l12_3v")),
    ):
        done = run(tmp_path, *view, *coarse, "--array", array, check=False)
        assert done.returncode == 2 and done.stderr == refused.format(*words) and not [*tmp_path.iterdir()]
    # Elsewhere no probe is pressed in: every array fits, and the title is not that of a view.
    run(tmp_path, "--anatomy", "leg", "--view", "calf_transverse", *coarse, "--array", "c5_2v", "--from", "0,-30,0", "--towards", "0,0,0")
    with h5py.File(tmp_path / "channels.hdf5") as file:
        assert file["probe/type"].asstr()[()] == "curved" and file.attrs["description"] == "Leg: thigh and calf"


def test_memory_is_bounded_by_an_option(tmp_path):
    job = ["--phantom", "points", "--array", "l12_3v", "--transmits"]
    done = run(tmp_path, *job, "fsa", "--depth", "1000", check=False)
    assert done.returncode == 2 and "more than `max_memory` (4 GB); lower " in done.stderr
    done = run(tmp_path, *job, "fsa", "--depth", "60", "--memory", "0.1", check=False)
    assert done.returncode == 2 and "more than `max_memory` (0.1 GB); lower " in done.stderr
    run(tmp_path, *job, "plane:3:10", "--depth", "30", "--memory", "2")


def test_a_full_disk_leaves_nothing_half_written(tmp_path):
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))

    done = run(tmp_path, "--phantom", "points", "--depth", "15", "--transmits", "plane:1:0", check=False, preexec_fn=limit)
    assert done.returncode == 2 and "is the disk full" in done.stderr
    assert not [*tmp_path.iterdir()]


def test_the_same_command_gives_the_same_bytes(tmp_path):
    options = ["--phantom", "points", "--depth", "15", "--transmits", "plane:1:0", "--output"]
    run(tmp_path, *options, "a")
    run(tmp_path, *options, "b")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
