#!/usr/bin/env bash
# Installs a program from the crates as they would be published:
#
#   release/crates.sh [PACKAGE [OPTION...]]
#
# packages the workspace, unpacks all crates in a folder of their own, and installs PACKAGE
# (`azulejo-cli` by default) from there, with the others in place of those on crates.io. Dependencies are
# the newest that the manifests allow, as `cargo install` takes them. Options are those of `cargo
# install`: with `--debug` it takes a fraction of the time. Then the program says its version, and the
# command renders an example. Nothing is left on this machine. Needs Rust.
set -euo pipefail
cd "$(dirname "$0")/.."
package=${1:-azulejo-cli}
shift $(($# > 0))

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo package --workspace --no-verify --locked --quiet --target-dir "$work/target"
mkdir "$work/crates"
patches=()
for crate in "$work"/target/package/*.crate; do
    tar xzf "$crate" -C "$work/crates"
    folder=$(basename "$crate" .crate)
    patches+=(--config "patch.crates-io.${folder%%-[0-9]*}.path='$work/crates/$folder'")
done
installed=$work/installed
cargo install --path "$(echo "$work/crates/$package"-[0-9]*)" "${patches[@]}" --root "$installed" "$@"
for program in "$installed"/bin/*; do
    "$program" --version
done
if [ -e "$installed/bin/azulejo" ]; then
    "$installed/bin/azulejo" render examples/cornell.grf -o "$work/cornell.png" --size 64x64
fi
