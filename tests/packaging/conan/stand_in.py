"""Runs the recipe without Conan, whose modules are played here as far as it imports them:

    python3 stand_in.py <source tree> <folder>

What Conan would package is in the folder afterwards.
"""
import importlib.util
import os
import pathlib
import re
import shutil
import sys
import types

source, package = (os.path.abspath(path) for path in sys.argv[1:3])
here = pathlib.Path(__file__).parent


class ConanFile:
    def __init__(self):
        self.required = []
        self.info = types.SimpleNamespace(clear=lambda: None)
        self.settings = types.SimpleNamespace(os="Linux")
        self.properties = {}
        self.cpp_info = types.SimpleNamespace(set_property=self.properties.__setitem__)

    def requires(self, reference):
        self.required.append(reference)


def copy(_, pattern, src, dst):
    for file in [found for found in pathlib.Path(src).rglob(pattern) if "build" not in found.relative_to(src).parts]:
        target = pathlib.Path(dst) / file.relative_to(src)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, target)


played = {
    "conan": {"ConanFile": ConanFile},
    "conan.tools": {},
    "conan.tools.build": {"check_min_cppstd": lambda _, least: None, "can_run": None},
    "conan.tools.cmake": {"CMake": None, "cmake_layout": None},
    "conan.tools.files": {"copy": copy, "get": None},
    "conan.tools.layout": {"basic_layout": lambda _, src_folder: None},
}
for name, content in played.items():
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(content)


def load(path, name):
    spec = importlib.util.spec_from_file_location(path.parent.name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, name)


number = int(re.search(r"INSONIFY_VERSION (\d+)", pathlib.Path(source, "include/insonify/core/version.hpp").read_text())[1])
version = f"{number // 10000}.{number // 100 % 100}.{number % 100}"
for file in ("config.yml", "all/conandata.yml"):
    if f'"{version}":' not in (here / file).read_text():
        sys.exit(f"{file} does not have version {version} of core/version.hpp")

load(here / "all/test_package/conanfile.py", "TestPackageConan")
recipe = load(here / "all/conanfile.py", "InsonifyConan")()
recipe.source_folder, recipe.package_folder = source, package
shutil.rmtree(package, ignore_errors=True)
for step in ("layout", "requirements", "validate", "package", "package_id", "package_info"):
    getattr(recipe, step)()

assert recipe.properties["cmake_target_name"] == "insonify::insonify"
for needed in ("include/insonify/insonify.hpp", "licenses/LICENSE"):
    if not os.path.exists(os.path.join(package, needed)):
        sys.exit(f"the package lacks {needed}")
