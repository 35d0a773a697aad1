"""A figure with matplotlib: the image, its labels, and the share of sound that returns from each place."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import insonify as us
from insonify import mm, tissue

# A vessel whose wall is modulated along its axis: any closed surface of numpy arrays will do.
angle, along = np.meshgrid(np.linspace(0, 2 * np.pi, 64, endpoint=False), np.linspace(-30, 30, 61) * mm)
radius = 4 * mm * (1 + 0.15 * np.sin(2 * np.pi * along / (20 * mm)))
rings = np.stack([radius * np.cos(angle) - 8 * mm, along, radius * np.sin(angle) + 18 * mm], axis=-1)
ends = rings[[0, -1]].mean(axis=1)
positions = np.concatenate([rings.reshape(-1, 3), ends])
ring, step = np.meshgrid(np.arange(60), np.arange(64), indexing="ij")
a, b = (64 * ring + step).ravel(), (64 * ring + (step + 1) % 64).ravel()
around = np.arange(64)
after, last = (around + 1) % 64, 60 * 64
caps = [np.stack([np.full(64, len(positions) - 2), after, around], 1),
        np.stack([np.full(64, len(positions) - 1), last + around, last + after], 1)]
faces = np.concatenate([np.stack([a, b, b + 64], 1), np.stack([a, b + 64, a + 64], 1), *caps])
vessel = us.mesh(positions, faces)
if us.validate(vessel):
    vessel = us.mesh(positions, faces[:, ::-1])  # turned inside out

body = us.scene(tissue.muscle)
body.add(vessel, tissue.blood, name="vessel")
body.add(us.make_sphere((10 * mm, 0, 30 * mm), 8 * mm), tissue.bone, name="bone")
body.build()
probe, settings = us.presets.nerve_block
settings.depth = 45 * mm
picture = us.b_mode(body, probe, us.pose(), settings)
truth = us.ground_truth(body, probe, us.pose(), us.label_settings(depth=settings.depth, grid="displayed"))
grid = us.make_scan_map(probe, us.acquisition(depth=settings.depth, samples=truth.label.samples))
labels = us.scan_convert(truth.label, grid).pixels
shadow = us.scan_convert(truth.transmitted, grid).pixels

width, height = 1e3 * grid.pitch[0] * grid.size[0], 1e3 * grid.pitch[1] * grid.size[1]
extent = (-width / 2, width / 2, height, 0)
figure, axes = plt.subplots(1, 3, figsize=(11, 4.2), constrained_layout=True)
axes[0].imshow(picture.pixels, cmap="gray", vmin=0, vmax=1, extent=extent)
axes[0].set_title("B-mode")
axes[1].imshow(np.where(labels == us.background_label, np.nan, labels), cmap="tab10", vmin=0, vmax=9, extent=extent)
axes[1].set_title("labels: " + ", ".join(f"{i} {name}" for i, name in body.names.items()))
axes[2].imshow(20 * np.log10(np.maximum(shadow, 1e-4)), cmap="magma", vmin=-80, vmax=0, extent=extent)
axes[2].set_title("sound that returns, dB")
for each in axes:
    each.set_xlabel("mm")
figure.savefig("figure.png", dpi=110)
