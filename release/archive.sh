#!/usr/bin/env bash
# Builds the release archive of this machine's platform:
#
#   release/archive.sh [FOLDER [PROGRAMS]]
#
# writes FOLDER/azulejo-VERSION-TARGET.tar.gz, for Windows .zip (FOLDER is `dist` by default), and
# brings FOLDER/SHA256SUMS up to date. The archive has the programs with graphics cards enabled, manual
# pages, shell completions, examples, documentation, licences, the list of third-party licences, and
# checksums of all of it. On macOS, which has neither Vulkan nor a current OpenGL, it has the command
# alone, without graphics cards. With PROGRAMS, a folder, the programs there are taken instead of
# building them. Needs Rust and Python 3.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p "${1:-dist}"
dist=$(cd "${1:-dist}" && pwd)

features=azulejo-cli/gpu
packages=(azulejo-cli azulejo-workbench)
programs=(azulejo azulejo-workbench)
suffix=.tar.gz
target=$(rustc -vV | sed -n 's/^host: //p')
case $target in
*-apple-*)
    features=
    packages=(azulejo-cli)
    programs=(azulejo)
    ;;
*-windows-*)
    programs=(azulejo.exe azulejo-workbench.exe)
    suffix=.zip
    ;;
esac
version=$(cargo pkgid --locked -p azulejo-cli | sed 's/.*[#@]//')
name=azulejo-$version-$target

if [ $# -ge 2 ]; then
    built=$2
else
    cargo build --release --locked "${packages[@]/#/--package=}" --features "$features"
    built=${CARGO_TARGET_DIR:-target}/release
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/$name
share=$root/share
mkdir -p "$root/bin" "$share/man/man1" "$share/bash-completion/completions" \
    "$share/zsh/site-functions" "$share/fish/vendor_completions.d"

for program in "${programs[@]}"; do
    install -m 755 "$built/$program" "$root/bin/$program"
done
# Elsewhere symbols are in files of their own, or what signs a program would have to sign it again.
case $target in *-linux-*) strip "$root"/bin/* ;; esac
"$root/bin/azulejo" man "$share/man/man1"
"$root/bin/azulejo" completions bash > "$share/bash-completion/completions/azulejo"
"$root/bin/azulejo" completions zsh > "$share/zsh/site-functions/_azulejo"
"$root/bin/azulejo" completions fish > "$share/fish/vendor_completions.d/azulejo.fish"

cp -r README.md ARCHITECTURE.md BENCHMARKS.md CHANGELOG.md CONTRIBUTING.md LICENSE-MIT LICENSE-APACHE examples docs web blender bevy "$root"
rm -rf "$root/bevy/azulejo-lightmap/target"
# Pages that these link to.
mkdir -p "$root/fuzz" "$root/tests/programs"
cp fuzz/README.md "$root/fuzz"
cp tests/programs/README.md "$root/tests/programs"
python3 release/third_party.py --target "$target" --features "$features" "${packages[@]}" \
    > "$root/THIRD-PARTY-LICENSES.txt"

python3 release/checksums.py "$root"
python3 release/pack.py --time "$(git log -1 --format=%ct)" "$root" "$dist/$name$suffix"
python3 release/checksums.py "$dist"
echo "$dist/$name$suffix"
