"""Writes the type stubs of the module from its signatures: python3 make_stubs.py > insonify.pyi"""
import inspect
import re

import insonify


def annotation(text):
    text = text.replace("insonify.", "").replace("Tuple", "tuple").replace("List", "list")
    text = re.sub(r"Union\[os\.PathLike, str, bytes\]|os\.PathLike", "Path", text)
    text = re.sub(r"\bfunction\b", "Callable[[np.ndarray], np.ndarray]", text)
    text = re.sub(r"numpy\.ndarray(\[[^\]]*\])?", "np.ndarray", text)
    text = re.sub(r"\btuple\b(?!\[)", "Vector", text)
    return text.replace("object", "Any")


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
        given = re.match(r"(\**\w*)(?:: ([^=]+?))?(?: = .*)?$", part, re.S)
        argument, kind = given.groups()
        default = " = ..." if " = " in part and not part.endswith(" = required") else ""
        shown.append(argument if kind is None or argument == "self" else f"{argument}: {annotation(kind)}{default}")
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


def settings_of(kind):
    return [name for name, member in vars(kind).items() if isinstance(member, property) and member.fset]


def type_of(value):
    parts = f"[{', '.join(map(type_of, value))}]" if isinstance(value, tuple) else ""
    parts = f"[{type_of(value[0])}]" if isinstance(value, list) else parts
    return type(value).__name__ + parts


def members(kind):
    settings = "**kwargs) -> None" in (kind.__init__.__doc__ or "")
    if settings:
        yield f"    def __init__(self, *, {', '.join(f'{name}: Any = ...' for name in settings_of(kind))}) -> None: ..."
    for name, member in sorted(vars(kind).items()):
        if isinstance(member, property) and type(member).__name__ == "pybind11_static_property":
            value = getattr(kind, name)
            yield f"    {name}: {type_of(value)}"
        elif isinstance(member, property):
            returned = re.search(r"-> (.+)", member.fget.__doc__ or "")
            yield f"    {name}: {annotation(returned.group(1)) if returned else 'Any'}"
        elif isinstance(member, staticmethod):
            yield from functions(member.__func__, "    ", static=True)
        elif name == "__init__" and settings:
            continue
        elif callable(member) and (not name.startswith("_") or name in ("__init__", "__matmul__", "__call__", "__len__", "__getitem__")):
            yield from functions(member, "    ")


def main():
    print("# Type stubs, written by make_stubs.py.")
    print("import os")
    print("from typing import Any, Callable, Optional, Sequence, Union, overload\n\nimport numpy as np\n\nVector = Sequence[float]")
    print('Path = Union[str, "os.PathLike[str]"]')
    print('velocity_field = Union["poiseuille", "velocity_samples", Sequence[Union["poiseuille", "velocity_samples"]]]')
    print("__version__: str")
    everything = vars(insonify)
    for name, value in everything.items():
        if isinstance(value, (float, int)) and not name.startswith("__"):
            print(f"{name}: {type(value).__name__}")
    for name, value in everything.items():
        if inspect.isclass(value):
            base = next((b.__name__ for b in value.__bases__ if issubclass(b, Exception)), "")
            print(f"\nclass {name}{f'({base})' if base else ''}:")
            print(f'    """{(value.__doc__ or "").strip()}"""')
            for line in members(value):
                print(line)
    print()
    for name, value in everything.items():
        if inspect.isbuiltin(value):
            for line in functions(value, ""):
                print(line)


main()
