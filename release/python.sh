#!/usr/bin/env bash
# Builds the Python package for this machine's platform:
#
#   release/python.sh [FOLDER [OPTION...]]
#
# writes FOLDER/pyazulejo-VERSION.tar.gz, the sources of the package and of the crates that it is made
# of, and a wheel for every Python from 3.10 on (FOLDER is `dist` by default), and brings
# FOLDER/SHA256SUMS up to date. The wheel is built from the unpacked sources alone, as pip builds
# it, and has the list of third-party licences. Options are those of `maturin build`. On Linux the
# wheel gets the oldest tag `manylinux` that its symbols allow: what it needs of the C library depends on
# where it is built. Needs Rust, Python 3 and maturin.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p "${1:-dist}"
dist=$(cd "${1:-dist}" && pwd)
shift $(($# > 0))

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m maturin sdist --manifest-path crates/azulejo-python/Cargo.toml --out "$work"
cp "$work"/pyazulejo-*.tar.gz "$dist"
tar xzf "$work"/pyazulejo-*.tar.gz -C "$work"
source=$(echo "$work"/pyazulejo-*/)
# The links to our own licences are no files where Git makes no links.
cp LICENSE-MIT LICENSE-APACHE "$source"
third_party=$PWD/release/third_party.py
target=$(rustc -vV | sed -n 's/^host: //p')
(
    cd "$source"
    # What only other crates of the workspace need leaves Cargo.lock.
    cargo update --workspace --quiet
    python3 "$third_party" --target "$target" azulejo-python > THIRD-PARTY-LICENSES.txt
    python3 -m maturin build --locked --out "$dist" "$@"
)
python3 release/checksums.py "$dist"
