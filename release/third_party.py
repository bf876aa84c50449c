#!/usr/bin/env python3
"""Prints the licences of all third-party crates in given packages of this workspace.

    third_party.py --target TRIPLE --features FEATURES PACKAGE...

Walks the dependencies that `cargo metadata` resolves for the target, without those of tests,
benchmarks and build scripts. Each crate is listed with its version and licence expression; each
licence text that a crate ships is printed once, with the crates that ship it.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

# Files that hold licences, copyright notices or attributions.
LICENCE_FILE = re.compile(
    r"(licen[cs]e|copying|copyright|notice|unlicense|ofl|ufl)([-_.].*)?$|.*licen[cs]e(\.txt|\.md)?$", re.I
)
DEJAVU = pathlib.Path(__file__).parent.parent / "examples/fonts/LICENSE-DEJAVU"
SKIPPED_SUFFIXES = {".rs", ".toml", ".json", ".html", ".ttf", ".otf", ".py"}


def metadata(arguments):
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    command += ["--filter-platform", arguments.target]
    if arguments.features:
        command += ["--features", arguments.features]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def third_party(data, roots):
    """Packages outside of the workspace that the roots depend on, sorted by name and version."""
    packages = {p["id"]: p for p in data["packages"]}
    nodes = {n["id"]: n for n in data["resolve"]["nodes"]}
    members = set(data["workspace_members"])
    stack = [i for i in members if packages[i]["name"] in roots]
    missing = set(roots) - {packages[i]["name"] for i in stack}
    if missing:
        sys.exit(f"not in the workspace: {', '.join(sorted(missing))}")
    seen = set(stack)
    while stack:
        for dependency in nodes[stack.pop()]["deps"]:
            is_linked = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if is_linked and dependency["pkg"] not in seen:
                seen.add(dependency["pkg"])
                stack.append(dependency["pkg"])
    found = [packages[i] for i in seen - members]
    return sorted(found, key=lambda p: (p["name"], p["version"]))


def licence_texts(package):
    """The licence texts in the package's folder and one below."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = {f for pattern in ("*", "*/*") for f in folder.glob(pattern)}
    if package["license_file"]:
        files.add(folder / package["license_file"])
    for file in sorted(files):
        is_named = LICENCE_FILE.match(file.name) or str(file.relative_to(folder)) == package["license_file"]
        if is_named and file.is_file() and file.suffix not in SKIPPED_SUFFIXES:
            yield file.read_text(encoding="utf-8", errors="replace").strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target", required=True)
    parser.add_argument("--features", default="")
    parser.add_argument("packages", nargs="+")
    arguments = parser.parse_args()
    packages = third_party(metadata(arguments), arguments.packages)
    # Windows has another encoding.
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")

    print("Third-party software in azulejo\n")
    print("azulejo is under MIT or Apache-2.0 (LICENSE-MIT, LICENSE-APACHE); its typeface, DejaVu Serif, is")
    print("under the first of the licences below. Programs and modules contain Rust's standard library")
    print("(MIT OR Apache-2.0) and the following crates from crates.io.\n")
    texts = {"": (DEJAVU.read_text(encoding="utf-8").strip(), ["DejaVu Serif"])}
    for package in packages:
        name = f"{package['name']} {package['version']}"
        licence = package["license"] or f"see {package['license_file']}"
        shipped = list(dict.fromkeys(licence_texts(package)))
        note = "" if shipped else "  (ships no licence text)"
        print(f"{name:45} {licence}{note}")
        for text in shipped:
            # Copies differ in line breaks only.
            texts.setdefault(" ".join(text.split()), (text, []))[1].append(name)
    for text, names in texts.values():
        print("\n" + "=" * 100 + "\n")
        print(", ".join(names) + ":\n")
        print(text)


if __name__ == "__main__":
    main()
