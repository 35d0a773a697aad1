"""What the tests share. INSONIFY_REFERENCE names the program that draws the same pictures in C++."""
import os
import pathlib
import subprocess

import numpy as np
import pytest

import insonify as us
from insonify import mm, tissue


@pytest.fixture
def phantom():
    """Makes a bone and a vessel in muscle."""

    def make():
        body = us.scene(tissue.muscle)
        body.add(us.make_sphere((6 * mm, 0, 30 * mm), 8 * mm), tissue.bone, name="bone")
        body.add(us.make_cylinder((-9 * mm, -30 * mm, 17 * mm), (-9 * mm, 30 * mm, 17 * mm), 4 * mm), tissue.blood, name="vein")
        return body.build()

    return make


@pytest.fixture
def equals_cpp(tmp_path):
    """Compares numbers with those of a part of the program in C++, bit for bit."""

    def compare(part, numbers):
        program = os.environ.get("INSONIFY_REFERENCE")
        if not program:
            pytest.skip("INSONIFY_REFERENCE is not set")
        subprocess.run([program, part, tmp_path / part], check=True)
        drawn = np.concatenate([np.ascontiguousarray(each).ravel().view(np.float32) for each in numbers])
        assert np.array_equal(drawn.view(np.uint32), np.fromfile(tmp_path / part, np.uint32))

    return compare


@pytest.fixture
def resident():
    """Memory of this process, bytes."""
    if not pathlib.Path("/proc/self/statm").exists():
        pytest.skip("reads /proc")
    return lambda: int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
