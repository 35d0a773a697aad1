"""The loaders of the README."""
import json
import multiprocessing
import pathlib
import pickle

import numpy as np
import pytest
from helpers import SMALL, label_names, labels_of, run, whole_of

from insonify_samples import samples


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("loader")
    run(made, *SMALL, "--iq", "--samples=10")
    return made


def test_samples_are_those_of_the_file(folder):
    data = samples(folder / "out", truth=True, iq=True)
    with whole_of(folder) as file:
        assert len(data) == 10 and data.missing == 0 and data.label_names == label_names(file)
        for i in (0, 4, 9):
            one = data[i]
            np.testing.assert_array_equal(one["image"], file["data/image/values"][i])
            np.testing.assert_array_equal(one["label"], labels_of(file)[i])
            np.testing.assert_array_equal(one["depth"], file["data/depth/values"][i])
            np.testing.assert_array_equal(one["iq"].real, file["data/beamformed_data/values"][i][..., 0])
            np.testing.assert_array_equal(one["iq"].imag, file["data/beamformed_data/values"][i][..., 1])
            assert one["numbers"]["focus"] == file["insonify/focus"][i] and one["number"] == i
            rotation = one["pose"][:3, :3]
            np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
            assert np.linalg.det(rotation) > 0
            np.testing.assert_array_equal(one["pose"][:3, 3], file["metadata/probe_pose/translation"][i])
        with pytest.raises(IndexError):
            data[10]


def test_batches(folder):
    data = samples(folder / "out")
    plain = list(data.batches(4))
    assert [len(each["image"]) for each in plain] == [4, 4, 2] and plain[0]["image"].shape == (4, 64, 64)
    mixed = [set(each["number"]) for each in data.batches(4, seed=1)]
    assert set().union(*mixed) == set(range(10)) and mixed[0] != {0, 1, 2, 3}
    assert plain[1]["numbers"]["frequency"].shape == (4,)


def sum_of(job):
    data, i = job
    return int(data[i]["image"].sum())


def test_workers_share_it(folder):
    data = samples(folder / "out")
    expected = [int(one["image"].sum()) for one in data]
    for method in ("fork", "spawn"):
        with multiprocessing.get_context(method).Pool(2) as pool:
            assert pool.map(sum_of, [(data, i) for i in range(10)]) == expected
    assert int(pickle.loads(pickle.dumps(data))[3]["image"].sum()) == expected[3]


def test_what_is_not_there_is_said(tmp_path):
    run(tmp_path, *SMALL, "--no-truth", "--samples=4")
    assert samples(tmp_path / "out")[0]["label"].max() < 255
    with pytest.raises(ValueError, match="has no incidence, transmitted, depth, beamformed_data"):
        samples(tmp_path / "out", truth=True, iq=True)


def test_torch(folder):
    torch = pytest.importorskip("torch")
    from insonify_torch import torch_samples

    loader = torch.utils.data.DataLoader(torch_samples(folder / "out"), batch_size=4, num_workers=2)
    images, labels = next(iter(loader))
    assert images.shape == (4, 1, 64, 64) and images.dtype == torch.float32 and images.max() <= 1
    assert labels.shape == (4, 64, 64) and labels.dtype == torch.int64
    loss = torch.nn.CrossEntropyLoss(ignore_index=255)(torch.zeros(4, 30, 64, 64), labels)
    assert torch.isfinite(loss)


def test_the_code_of_the_readme_runs(folder):
    """Blocks of Python in the README, in the folder of a dataset."""
    text = (pathlib.Path(__file__).parent.parent / "README.md").read_text()
    blocks = [block.split("```")[0] for block in text.split("```python\n")[1:]]
    assert blocks
    for block in blocks:
        if "torch" in block:
            pytest.importorskip("torch")
        exec(block.replace('"dataset"', repr(str(folder / "out"))).replace('"dataset/', '"' + str(folder / "out") + "/"), {})
