"""Samples of a dataset for machine learning, as NumPy arrays. Needs h5py.

    from insonify_samples import samples
    data = samples("dataset")
    one = data[7]
    one["image"], one["label"], data.label_names

`insonify_torch.py` has them for PyTorch.
"""
import collections.abc
import os
import pathlib

import h5py
import numpy as np

OUTSIDE = 255  # label of the pixels outside the field of view


class samples(collections.abc.Sequence):
    """The samples of a folder, or of one of its HDF5 files, without those whose part is missing or damaged.

    A sample is a dictionary:

    number      of the sample in the dataset
    image       uint8, rows x columns: 0 black to 255 white
    label       uint8, rows x columns: index into `label_names`; 255 outside the field of view
    pose        float32, 4 x 4: from the frame of the probe (x lateral, y elevation, z depth) to the anatomy, metres
    anatomy     name of the region, or of the file
    view        name of the view of the region
    parameters  of the body, by name: lengths in metres
    body_seed   of these parameters: samples of one body have the same, and belong in the same half of a split
    numbers     what varied, and all else in the group `insonify`, by name
    with truth  incidence, transmitted, depth: float32, rows x columns
    with iq     complex64, samples x lines
    with channels   raw_data: float32, transmits x samples x elements
    with tissue     sos_map, attenuation_map: float32, rows x columns of the slice of that array; displacement, ... x 2: x, z;
                    strain, ... x 3: lateral, axial, shear

    Files are opened in each process by itself, so that the workers of a loader may share a `samples`.
    """

    def __init__(self, folder, truth=False, iq=False, channels=False, tissue=False):
        path = pathlib.Path(folder)
        self.path = path / "dataset.h5" if path.is_dir() else path
        self.maps = ["incidence", "transmitted", "depth"] if truth else []
        self.maps += ["sos_map", "attenuation_map", "displacement", "strain"] if tissue else []
        self.iq = iq
        self.channels = channels
        self._file, self._process = None, None
        with h5py.File(self.path) as file:
            present = file["insonify/present"][:] == 1
            self.rows = np.flatnonzero(present)
            self.missing = len(present) - len(self.rows)
            self.label_names = [name.decode() for name in file["data/segmentation/labels"][:]]
            names = {name: [text.decode() for text in array[:]] for name, array in file["insonify"].items() if array.dtype.kind == "O"}
            self.anatomies, self.views, self.parameter_names = (names.get(name, []) for name in ("anatomies", "views", "parameter_names"))
            needed = self.maps + (["beamformed_data"] if iq else []) + (["raw_data"] if channels else [])
            lacking = [name for name in needed if name not in file["data"]]
            if lacking:
                raise ValueError(f"{self.path} has no {', '.join(lacking)}: it was made with --no-truth, or without --iq or --channels")
            self._numbers = [name for name, array in file["insonify"].items() if array.shape[:1] == present.shape and array.dtype.kind == "f" and name not in ("label_media", "parameters")]

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, index):
        row, file = self.rows[index], self._open()
        data = file["data"]
        about = file["insonify"]
        values = about["parameters"][row] if self.parameter_names else []
        found = {
            "number": int(about["number"][row]),
            "image": data["image/values"][row],
            "label": about["label"][row],
            "pose": pose(file["metadata/probe_pose/translation"][row], file["metadata/probe_pose/rotation"][row]),
            "anatomy": self.anatomies[int(about["anatomy"][row])],
            "view": self.views[int(about["view"][row])],
            "parameters": {name: value for name, value in zip(self.parameter_names, values) if not np.isnan(value)},
            "body_seed": int(about["body_seed"][row]),
            "numbers": {name: about[name][row] for name in self._numbers},
        }
        for name in self.maps:
            found[name] = data[name]["values"][row]
        if self.iq:
            found["iq"] = np.ascontiguousarray(data["beamformed_data/values"][row]).view(np.complex64)[..., 0]
        if self.channels:
            found["raw_data"] = data["raw_data"][row][..., 0]
        return found

    def batches(self, size, seed=None):
        """Dictionaries of `size` samples each: arrays are stacked, numbers too, parameters are a list. With a seed in another order
        each time."""
        order = np.arange(len(self)) if seed is None else np.random.default_rng(seed).permutation(len(self))
        for first in range(0, len(order), size):
            group = [self[i] for i in np.sort(order[first : first + size])]
            numbers = {name: np.stack([one["numbers"][name] for one in group]) for name in self._numbers}
            stacked = {name: np.stack([one[name] for one in group]) for name in group[0] if name not in ("numbers", "parameters")}
            yield stacked | {"numbers": numbers, "parameters": [one["parameters"] for one in group]}

    def __getstate__(self):
        return self.__dict__ | {"_file": None, "_process": None}

    def _open(self):
        if self._process != os.getpid():
            self._file, self._process = h5py.File(self.path), os.getpid()
        return self._file


def pose(translation, rotation):
    """A 4 x 4 matrix from a translation and a quaternion w, x, y, z."""
    w, x, y, z = np.asarray(rotation, np.float64) / np.linalg.norm(rotation)
    made = np.eye(4, dtype=np.float32)
    made[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    made[:3, 3] = translation
    return made
