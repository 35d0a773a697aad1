"""Builds the module with CMake: pip install ./examples/python. INSONIFY_PYTHON_BUILD names a build folder that exists."""
import os
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext


class cmake_build(build_ext):
    def build_extension(self, extension):
        folder = pathlib.Path(__file__).resolve().parent
        build = os.environ.get("INSONIFY_PYTHON_BUILD")
        if not build:
            build = pathlib.Path(self.build_temp).resolve()
            options = ["-DCMAKE_BUILD_TYPE=Release", f"-DPython_EXECUTABLE={sys.executable}"]
            try:
                import pybind11

                options.append(f"-Dpybind11_DIR={pybind11.get_cmake_dir()}")
            except ImportError:
                pass  # CMake finds that of the system
            subprocess.run(["cmake", "-S", folder, "-B", build, *options], check=True)
            subprocess.run(["cmake", "--build", build, "--parallel"], check=True)
        place = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve().parent
        subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", place], check=True)


setup(ext_modules=[Extension("insonify", [])], cmdclass={"build_ext": cmake_build})
