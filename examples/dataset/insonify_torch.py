"""Samples of a dataset for PyTorch.

    from insonify_torch import torch_samples
    loader = torch.utils.data.DataLoader(torch_samples("dataset"), batch_size=16, shuffle=True, num_workers=4)
    loss = torch.nn.CrossEntropyLoss(ignore_index=255)
    for image, label in loader: ...
"""
import torch

from insonify_samples import samples


class torch_samples(torch.utils.data.Dataset):
    """Pairs of an image, float32, 1 x rows x columns, 0 to 1, and its labels, int64, rows x columns, 255 outside the field of
    view; or what `select` makes of a sample of `samples`."""

    def __init__(self, folder, select=None, **options):
        self.samples = samples(folder, **options)
        self.select = select or image_and_label

    def __len__(self):
        return len(self.samples)

    def __getitem__(self, index):
        return self.select(self.samples[index])


def image_and_label(sample):
    return torch.from_numpy(sample["image"]).float()[None] / 255, torch.from_numpy(sample["label"]).long()
