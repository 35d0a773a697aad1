"""The generator as its users run it. DATASET names the program, MPIEXEC the launcher."""
import os
import pathlib
import subprocess
import sys

import h5py
import numpy as np

PROGRAM = os.environ["DATASET"]
MPIEXEC = os.environ.get("MPIEXEC", "mpiexec")


def merged(options):
    """The options, without those that are given again later."""
    groups = {}
    for word in options:
        if word.startswith("--"):
            name = word.split("=")[0]
            groups.pop(name, None)
            groups[name] = []
        groups[name].append(word)
    return [word for group in groups.values() for word in group]


PLAIN = ["--frequency", "7.5", "--depth", "40", "--focus", "15..25", "--bend", "0", "--media", "1", "--gain", "0", "--needle", "0"]  # of a known probe
QUICK = merged([*PLAIN, "--anatomy", "nerve_block", "--size", "64", "--lines", "48", "--planes", "1", "--part", "4", "--needle", "0.5", "--bend", "0..2", "--pressure", "0..3"])
SMALL = [*QUICK, "--samples", "24"]
TINY = [*PLAIN, "--anatomy", "nerve_block", "--size", "32", "--lines", "16", "--planes", "1", "--samples", "2"]
STRAIGHT = [f"--{name}=0" for name in ("spread", "along", "across", "tilt", "rock", "turn", "standoff")]

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent))


def run(folder, *options, ranks=1, check=True, output="out"):
    launcher = [] if ranks == 1 else [MPIEXEC, "--oversubscribe", "-n", str(ranks)]
    done = subprocess.run([*launcher, PROGRAM, "--output", output, *merged(options)], cwd=folder, capture_output=True, text=True, timeout=300)
    if check:
        assert done.returncode == 0, done.stderr
    return done


def whole_of(folder, output="out"):
    return h5py.File(folder / output / "dataset.h5")


def labels_of(file):
    """Index of the label of each pixel; 255 where there is none."""
    masks = file["data/segmentation/values"][:, :, :, 0]
    return np.where(masks.any(-1), masks.argmax(-1), 255).astype(np.uint8)


def label_names(file):
    return [name.decode() for name in file["data/segmentation/labels"]]


def write_balls(path, factor=1, /, **radii):
    """Balls of a tissue each, in millimetres times a factor, around a point 40 mm below the origin."""
    rings, around, text, written = 48, 96, [], 0
    theta, phi = np.meshgrid(np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(around) / around, indexing="ij")
    for name, radius in radii.items():
        points = radius * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
        points = np.concatenate([points, [[0, 0, radius], [0, 0, -radius]]]) + [0, 0, 40]
        faces = []
        for i in range(around):
            j = (i + 1) % around
            faces.append((len(points) - 2, i, j))
            faces.append((len(points) - 1, (rings - 2) * around + j, (rings - 2) * around + i))
            for ring in range(rings - 2):
                a, b = ring * around + i, ring * around + j
                faces += [(a, a + around, b + around), (a, b + around, b)]
        text += ["o " + name, "usemtl " + name] + ["v %.9g %.9g %.9g" % tuple(factor * p) for p in points]
        text += ["f %d %d %d" % tuple(v + 1 + written for v in f) for f in faces]
        written += len(points)
    path.write_text("\n".join(text) + "\n")
