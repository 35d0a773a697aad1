#!/usr/bin/env python3
"""Whether the tests would notice: flips each comparison, sign and constant of eleven core functions, one at a time.

    python3 tests/mutants/mutants.py                 all of them, as a markdown table
    python3 tests/mutants/mutants.py pulse fresnel   those whose name has one of these words

A mutant is caught where a test of the files named beside its function fails, or where it crashes or hangs them. What does
not compile is not counted. Those that no test can catch, for they compute the same, are listed in `equivalent` with the
reason.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

project = pathlib.Path(__file__).resolve().parents[2]

# Name, header, pattern where the code begins, pattern of the line where it ends, tests.
functions = [
    ("triangle test", "geometry/triangle.hpp", r"double edge_side", r"^inline hit|^INSONIFY_FN inline hit intersect\(const ray", ["geometry/triangle"]),
    ("fresnel", "acoustics/laws.hpp", r"^struct fresnel", r"^};", ["acoustics/laws_fresnel"]),
    ("Snell", "acoustics/laws.hpp", r"float refracted_cosine", r"^struct fresnel", ["acoustics/laws_fresnel"]),
    ("medium stack", "scene/layers.hpp", r"^struct media_stack", r"^};", ["scene/layers_media_stack"]),
    ("layers of a line", "scene/layers.hpp", r"class layer_walk", r"^};", ["scene/layers", "scene/scene_layers"]),
    ("SAH split", "bvh/build_sah.hpp", r"sah_plane cheapest", r"^};", ["bvh/build_sah"]),
    ("refit", "bvh/storage.hpp", r"box_areas refit_part", r"^/// Recomputes all boxes", ["bvh/storage_refit"]),
    ("pulse", "signal/pulse.hpp", r"^struct pulse_envelope", r"^template", ["signal/pulse"]),
    ("scan conversion", "image/scan_convert.hpp", r"const bool full_circle = ", r"^/// The same for a single frame", ["image/scan_convert"]),
    ("attenuation", "acoustics/laws.hpp", r"float echo_loss", r"^/// An attenuation law", ["acoustics/laws_attenuation"]),
    ("progressive mean", "paper/picture.hpp", r"const image& add", r"^    /// The mean after", ["paper/picture_progressive"]),
]

# Header, mutated code, reason.
stands_aside = "the ray stands aside to another side: as good a rule"
never_read = "set before it is read"
spare = "room that nothing uses"
equivalent = [
    ("geometry/triangle.hpp", "if (side != 0) return side <= 0 ? 1 : -1;", stands_aside),
    ("geometry/triangle.hpp", "if (p.y != q.y) return p.y <= q.y ? 1 : -1;", stands_aside),
    ("acoustics/laws.hpp", "float incident = 1;", never_read),
    ("acoustics/laws.hpp", "float transmitted = 1;", never_read),
    ("scene/layers.hpp", "static constexpr std::uint32_t none = ~1U;", "no rank is that high either"),
    ("bvh/build_sah.hpp", "float size[5];", spare),
    ("bvh/build_sah.hpp", "side low[4], high[3];", spare),
    ("bvh/build_sah.hpp", "side low[3], high[4];", spare),
    ("bvh/build_sah.hpp", "float area[4][sah_grid::max_bins] = {};", spare),
    ("bvh/build_sah.hpp", "std::uint32_t held[4][sah_grid::max_bins] = {};", spare),
    ("bvh/build_sah.hpp", "build_box box_[4][sah_grid::max_bins];", spare),
    ("bvh/build_sah.hpp", "std::uint32_t count_[4][sah_grid::max_bins];", spare),
    ("signal/pulse.hpp", "if (!(burst > 0.015F * sigma)) return std::exp(-0.5F * (x / sigma) * (x / sigma));",
     "so short a burst and none are the same in float"),
    ("signal/pulse.hpp", "if (!is_finite(frequency) && !(frequency >= 0))", "the next check refuses infinity"),
    ("image/scan_convert.hpp", "for (std::size_t i = y / map.size.x; i < (y + 1) * map.size.x; ++i) {",
     "rows before are written anew, as they were"),
    ("paper/picture.hpp", "mean_.assign(frame.pixels.size(), 1.0F);", "the first frame's share of it is 0"),
]

flips = [(" <= ", " > "), (" >= ", " < "), (" < ", " >= "), (" > ", " <= "), (" == ", " != "), (" != ", " == "),
         (" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), (" && ", " || "), (" || ", " && "),
         (" += ", " -= "), ("!(", "(")]
number = re.compile(r"(?<![\w.\"])(\d+\.\d+(?:e-?\d+)?F?|\d+e-?\d+F?|\d+U?)(?![\w.\"])")
negation = re.compile(r"(?<=[(=,{?:] )-(?=[\w(])|(?<=[({])-(?=[\w(])|(?<=return )-(?=[\w(])")


def changed(text):
    if text.endswith("F") or "." in text or "e" in text:
        return repr(float(text.rstrip("F")) * 1.5 + (1 if float(text.rstrip("F")) == 0 else 0)) + "F"
    return str(int(text.rstrip("U")) + 1) + ("U" if text.endswith("U") else "")


def mutants_of(lines, begin, end):
    for i in range(begin, end):
        code = lines[i].split("//")[0]
        if not code.strip() or code.strip().startswith(("throw", "static_assert", "template", "\"", "friend", "exec::for_each_block")):
            continue
        strings = [(m.start(), m.end()) for m in re.finditer(r'"[^"]*"', code)]
        inside = lambda at: any(a <= at < b for a, b in strings)
        for old, new in flips:
            at = code.find(old)
            while at >= 0:
                if not inside(at):
                    yield i, code[:at] + new + code[at + len(old):]
                at = code.find(old, at + 1)
        for m in number.finditer(code):
            if not inside(m.start()):
                yield i, code[:m.start()] + changed(m[0]) + code[m.end():]
        for m in negation.finditer(code):
            yield i, code[:m.start()] + code[m.end():]


def run(command, seconds):
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return None


def main():
    words = sys.argv[1:]
    compiler = ["g++", "-std=c++20", "-O1", "-w", "-fsanitize=bounds", "-fno-sanitize-recover=all"]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        run([*compiler, "-I", project / "include", "-c", project / "tests/main.cpp", "-o", folder / "main.o"], 600)

        def outcome(tests, first):
            program = folder / "tests"
            sources = [project / "tests" / (test + ".cpp") for test in tests]
            built = run([*compiler, "-I", first, "-I", project / "include", *sources, folder / "main.o", "-o", program, "-pthread"], 900)
            if built is None or built.returncode != 0:
                return None
            ran = run([program], 120)
            if ran is None:
                return "hangs"
            if ran.returncode == 0:
                return ""
            named = re.search(r"TEST CASE: +(.*)", ran.stdout)
            return named[1] if named else "crashes"

        print("| function | line | mutant | caught by |\n|---|---|---|---|")
        survivors = total = excused = 0
        for name, header, first, last, tests in functions:
            if words and not any(word in name for word in words):
                continue
            lines = (project / "include/insonify" / header).read_text().split("\n")
            begin = next(i for i, line in enumerate(lines) if re.search(first, line))
            end = next(i for i in range(begin + 1, len(lines)) if re.search(last, lines[i]))
            if outcome(tests, folder) != "":
                sys.exit(f"{name}: its tests fail, or do not compile, without any mutant")
            for i, code in mutants_of(lines, begin, end):
                copy = folder / "mutated/insonify" / header
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_text("\n".join(lines[:i] + [code] + lines[i + 1:]))
                caught = outcome(tests, folder / "mutated")
                copy.unlink()
                if caught is None:
                    continue
                total += 1
                reason = next((why for where, what, why in equivalent if where == header and what == code.strip()), None)
                if caught == "" and reason:
                    excused += 1
                elif caught == "":
                    survivors += 1
                shown = code.strip().replace("|", "\\|")
                print(f"| {name} | {header}:{i + 1} | `{shown}` | {caught or reason or '**nobody**'} |", flush=True)
        print(f"\n{total} mutants: {total - survivors - excused} caught, {excused} compute the same, {survivors} survive")
        return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
