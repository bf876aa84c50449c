#!/usr/bin/env python3
"""Packs a folder into an archive, the same bytes for the same content on every system.

    pack.py --time SECONDS FOLDER ARCHIVE

ARCHIVE ends in .tar.gz or .zip. All files get the given time (seconds since 1970) and no owner.
"""

import argparse
import gzip
import pathlib
import tarfile
import time
import zipfile


def pack_tar(folder, archive, seconds):
    def plain(entry):
        entry.uid = entry.gid = 0
        entry.uname = entry.gname = ""
        entry.mtime = seconds
        return entry

    with open(archive, "wb") as file, gzip.GzipFile("", "wb", 9, file, mtime=0) as packed:
        with tarfile.open(fileobj=packed, mode="w") as tar:
            tar.add(folder, folder.name, filter=plain)


def pack_zip(folder, archive, seconds):
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
        for file in sorted(f for f in folder.rglob("*") if f.is_file()):
            name = file.relative_to(folder.parent).as_posix()
            entry = zipfile.ZipInfo(name, time.gmtime(seconds)[:6])
            packed.writestr(entry, file.read_bytes(), zipfile.ZIP_DEFLATED)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--time", type=int, required=True)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("archive", type=pathlib.Path)
    arguments = parser.parse_args()
    pack = pack_zip if arguments.archive.suffix == ".zip" else pack_tar
    pack(arguments.folder, arguments.archive, arguments.time)


if __name__ == "__main__":
    main()
