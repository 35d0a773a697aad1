"""Writes the type stubs of the module from its signatures: python3 make_stubs.py > insonify.pyi"""
import inspect
import re
import textwrap

import insonify


def annotation(text):
    text = text.replace("insonify.", "").replace("Tuple", "tuple").replace("List", "list")
    text = re.sub(r"Union\[os\.PathLike, str, bytes\]|os\.PathLike", "Path", text)
    text = re.sub(r"\bfunction\b", "Callable[[Array], Array]", text)
    text = re.sub(r"numpy\.ndarray(\[[^\]]*\])?", "Array", text)
    text = re.sub(r"\b(\w+)\[\d+\]", r"\1", text)  # float[8]: an array of eight
    text = re.sub(r"\btuple\b(?!\[)", "Vector", text)
    return text.replace("object", "Any")


def given(text):
    """The type of what is given, which may be any sequence, or anything that numpy makes an array of."""
    text = annotation(text).replace("list[", "Sequence[")
    return re.sub(r"(Callable\[.*?\], Array\])|\bArray\b", lambda found: found[1] or "ArrayLike", text)


def signature(line):
    """name(self: scene, x: float = 1) -> int, as pybind11 prints it, for a stub: defaults become `...`."""
    name, rest = re.match(r"(?:\d+\. )?(\w+)(.*)", line).groups()
    arguments, returned = rest.rsplit(" -> ", 1)
    parts, depth, start = [], 0, 0
    inner = arguments[1:-1]
    for i, letter in enumerate(inner + ","):
        depth += letter in "([{<"
        depth -= letter in ")]}>"
        if letter == "," and depth == 0:
            parts.append(inner[start:i].strip())
            start = i + 1
    shown = []
    for part in filter(None, parts):
        argument, kind = re.match(r"(\**\w*)(?:: ([^=]+?))?(?: = .*)?$", part, re.S).groups()
        if kind is None and argument.strip("*") and argument.startswith("*"):
            kind = "object"
        default = " = ..." if " = " in part and not part.endswith(" = required") else ""
        shown.append(argument if kind is None or argument == "self" else f"{argument}: {given(kind)}{default}")
    return name, f"({', '.join(shown)}) -> {annotation(returned)}"


def functions(owner, indent, static=False):
    lines = [each for each in (owner.__doc__ or "").splitlines() if re.match(r"(\d+\. )?\w+\(.*\) -> ", each)]
    lines = [each for each in lines if "*args, **kwargs" not in each]  # these only say what is wrong
    if not lines:
        return
    overloaded = len(lines) > 1
    if overloaded:
        lines = lines[1:] if not lines[0][0].isdigit() and "Overloaded" in owner.__doc__ else lines
    for line in lines:
        name, rest = signature(line)
        if overloaded and len(lines) > 1:
            yield indent + "@overload"
        if static:
            yield indent + "@staticmethod"
        yield f"{indent}def {name}{rest}: ..."


def type_of_setting(member):
    """What can be assigned to it, as pybind11 prints the setter: (self: pulse, arg0: float) -> None."""
    found = re.search(r".*arg\d: (.+)\) -> None", member.fset.__doc__ or "")
    return given(found.group(1)) if found else "Any"


def settings_of(kind):
    return {name: type_of_setting(member) for name, member in vars(kind).items() if isinstance(member, property) and member.fset}


def type_of(value):
    parts = f"[{', '.join(map(type_of, value))}]" if isinstance(value, tuple) else ""
    parts = f"[{type_of(value[0])}]" if isinstance(value, list) else parts
    return type(value).__name__ + parts


def members(kind):
    settings = "**kwargs) -> None" in (kind.__init__.__doc__ or "")
    if settings:
        listed = ", ".join(f"{name}: {what} = ..." for name, what in settings_of(kind).items())
        yield f"    def __init__(self, *, {listed}) -> None: ..."
    for name, member in sorted(vars(kind).items()):
        if isinstance(member, property) and type(member).__name__ == "pybind11_static_property":
            value = getattr(kind, name)
            yield f"    {name}: {type_of(value)}"
        elif isinstance(member, property) and member.fset:
            yield f"    {name}: {type_of_setting(member)}"
        elif isinstance(member, property):
            returned = re.search(r"-> (.+)", member.fget.__doc__ or "")
            kind = annotation(returned.group(1)) if returned else "Any"
            yield "    @property"
            yield f"    def {name}(self) -> {f'_{kind}' if kind == name else kind}: ..."  # the name hides the type
        elif isinstance(member, staticmethod):
            yield from functions(member.__func__, "    ", static=True)
        elif name == "__init__" and settings:
            continue
        elif callable(member) and (not name.startswith("_") or name in ("__init__", "__matmul__", "__call__", "__len__", "__getitem__")):
            yield from functions(member, "    ")


def class_of(name, kind):
    base = next((b.__name__ for b in kind.__bases__ if issubclass(b, Exception)), "")
    yield f"\nclass {name}{f'({base})' if base else ''}:"
    yield f'    """{(kind.__doc__ or "").strip()}"""'
    yield from members(kind)


def module_of(name, module):
    """A submodule as a class, which one file can hold."""
    yield f"\nclass {name}:"
    yield f'    """{module.__doc__.strip()}"""'
    for inner, value in vars(module).items():
        if inspect.isclass(value):
            yield textwrap.indent("\n".join(class_of(inner, value)), "    ")
    for value in vars(module).values():
        if inspect.isbuiltin(value):
            yield from functions(value, "    ", static=True)


def main():
    print("# Type stubs, written by make_stubs.py.")
    print("import os")
    print("from typing import Any, Callable, Mapping, Optional, Sequence, Union, overload\n")
    print("import numpy as np\nfrom numpy.typing import ArrayLike\n")
    print("Array = np.ndarray[Any, np.dtype[Any]]\nVector = Union[Sequence[float], Array]")
    print('Path = Union[str, "os.PathLike[str]"]')
    fields = '"poiseuille", "tube_flow", "velocity_samples"'
    print(f"velocity_field = Union[{fields}, Sequence[Union[{fields}]]]")
    print("_scene = scene")
    print("__version__: str")
    everything = vars(insonify)
    for name, value in everything.items():
        if isinstance(value, (float, int)) and not name.startswith("__"):
            print(f"{name}: {type(value).__name__}")
    for name, value in everything.items():
        if inspect.isclass(value) and not name.startswith("_"):
            print("\n".join(class_of(name, value)))
    for name, value in everything.items():
        if inspect.ismodule(value):
            print("\n".join(module_of(name, value)))
    print()
    for name, value in everything.items():
        if inspect.isbuiltin(value):
            for line in functions(value, ""):
                print(line)


main()
