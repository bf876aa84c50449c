#!/usr/bin/env bash
# Builds the release archive of this machine's platform (made for Linux x86-64):
#
#   release/archive.sh [FOLDER [PROGRAMS]]
#
# writes FOLDER/azulejo-VERSION-TARGET.tar.gz and its .sha256 (FOLDER is `dist` by default). The
# archive has the programs with graphics cards enabled, manual pages, shell completions,
# examples, documentation, licences, the list of third-party licences, and checksums of all of it.
# With PROGRAMS, a folder, the programs there are taken instead of building them. Needs Rust and
# Python 3.
set -euo pipefail
cd "$(dirname "$0")/.."
dist=$(realpath -m "${1:-dist}")

features=azulejo-cli/gpu
target=$(rustc -vV | sed -n 's/^host: //p')
version=$(cargo metadata --format-version 1 --no-deps --locked |
    python3 -c 'import json, sys
print(next(p["version"] for p in json.load(sys.stdin)["packages"] if p["name"] == "azulejo-cli"))')
name=azulejo-$version-$target

if [ $# -ge 2 ]; then
    built=$2
else
    cargo build --release --locked -p azulejo-cli -p azulejo-workbench --features "$features"
    built=${CARGO_TARGET_DIR:-target}/release
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/$name
share=$root/share
mkdir -p "$root/bin" "$share/man/man1" "$share/bash-completion/completions" \
    "$share/zsh/site-functions" "$share/fish/vendor_completions.d"

for program in azulejo azulejo-workbench; do
    install -m 755 "$built/$program" "$root/bin/$program"
    strip "$root/bin/$program"
done
"$root/bin/azulejo" man "$share/man/man1"
"$root/bin/azulejo" completions bash > "$share/bash-completion/completions/azulejo"
"$root/bin/azulejo" completions zsh > "$share/zsh/site-functions/_azulejo"
"$root/bin/azulejo" completions fish > "$share/fish/vendor_completions.d/azulejo.fish"

cp -r README.md ARCHITECTURE.md BENCHMARKS.md CHANGELOG.md CONTRIBUTING.md LICENSE-MIT LICENSE-APACHE examples docs web blender bevy "$root"
rm -rf "$root/bevy/azulejo-lightmap/target"
# Pages that these link to.
cp --parents fuzz/README.md tests/programs/README.md "$root"
python3 release/third_party.py --target "$target" --features "$features" \
    azulejo-cli azulejo-workbench > "$root/THIRD-PARTY-LICENSES.txt"

(cd "$root" && find . -type f ! -name SHA256SUMS -printf '%P\0' | sort -z | xargs -0 sha256sum > SHA256SUMS)
mkdir -p "$dist"
tar --create --directory "$work" --sort=name --owner=0 --group=0 --numeric-owner \
    --mtime="@$(git log -1 --format=%ct)" "$name" | gzip --no-name --best > "$dist/$name.tar.gz"
(cd "$dist" && sha256sum "$name.tar.gz" > "$name.tar.gz.sha256")
echo "$dist/$name.tar.gz"
