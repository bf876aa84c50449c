#!/usr/bin/env python3
"""Writes SHA256SUMS of all files in a folder and below, as sha256sum does, which not every system has.

    checksums.py [--check] FOLDER

With --check, compares the files with SHA256SUMS.
"""

import argparse
import hashlib
import pathlib
import sys

NAME = "SHA256SUMS"


def checksums(folder):
    files = sorted(f for f in folder.rglob("*") if f.is_file() and f != folder / NAME)
    lines = [f"{hashlib.sha256(f.read_bytes()).hexdigest()}  {f.relative_to(folder).as_posix()}\n" for f in files]
    return "".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    list_of_all = arguments.folder / NAME
    found = checksums(arguments.folder)
    if not arguments.check:
        list_of_all.write_bytes(found.encode())
    elif (expected := list_of_all.read_text(encoding="utf-8")) != found:
        different = sorted(set(found.splitlines()) ^ set(expected.splitlines()))
        sys.exit(f"{list_of_all} and the files beside it differ:\n" + "\n".join(different))


if __name__ == "__main__":
    main()
