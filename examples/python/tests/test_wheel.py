"""A wheel, built of the module and installed into a fresh environment without a network."""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

FOLDER = pathlib.Path(__file__).resolve().parent.parent


def test_a_wheel_is_built_and_installed_into_a_fresh_environment(tmp_path):
    if "INSONIFY_PYTHON_BUILD" not in os.environ:
        pytest.skip("INSONIFY_PYTHON_BUILD is not set")
    for needed in ("pip", "venv", "wheel", "setuptools"):
        if importlib.util.find_spec(needed) is None:
            pytest.skip(f"needs python3-{needed}")
    alone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def run(*command):
        subprocess.run(command, cwd=tmp_path, env=alone, check=True)

    source = tmp_path / "source"  # setuptools writes beside its sources
    source.mkdir()
    for name in ("pyproject.toml", "setup.py"):
        shutil.copy(FOLDER / name, source)
    run(sys.executable, "-m", "pip", "wheel", "--no-index", "--no-build-isolation", "--no-deps", "-w", tmp_path, source)
    (wheel,) = tmp_path.glob("insonify-*.whl")
    run(sys.executable, "-m", "venv", "--system-site-packages", tmp_path / "fresh")  # numpy is that of the system
    python = tmp_path / "fresh/bin/python"
    run(python, "-m", "pip", "install", "--no-index", "--no-deps", wheel)
    run(python, "-c", "import insonify, pathlib, sys; assert pathlib.Path(sys.prefix) in pathlib.Path(insonify.__file__).parents")
    run(python, FOLDER / "ten_lines.py")
    assert (tmp_path / "ten_lines.png").stat().st_size > 1000
