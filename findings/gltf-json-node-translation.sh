#!/usr/bin/env bash
# gltf-json 1.4.1 (Rust): node transforms are single precision, although a glTF file is JSON, whose numbers are
# doubles, and although the accessor of a mesh may be relative to a node for just that reason. A building in a national grid,
# whose node stands at 5400000.123, is moved to 5400000.0; no error, no warning, and a file that is read and written again
# has lost the digits. A reader that needs them has to take them from the JSON itself.
#
# Needs cargo and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "node-translation"
version = "0.0.0"
edition = "2021"

[dependencies]
gltf-json = "=1.4.1"
TOML
cat > "$work/src/main.rs" <<'RUST'
fn main() {
    let file = r#"{"asset":{"version":"2.0"},"nodes":[{"translation":[500000.25,5400000.123,12.5]}]}"#;
    let root = gltf_json::Root::from_str(file).expect("valid glTF");
    println!("read:    {:?}", root.nodes[0].translation.expect("a translation"));
    let again = root.to_string().expect("JSON");
    let from = again.find("\"translation\"").expect("a translation");
    let to = again[from..].find(']').expect("its end");
    println!("written: {}", &again[from..=from + to]);
}
RUST
seen=$(cd "$work" && cargo run --quiet)
echo "$seen"
# As seen with gltf-json 1.4.1.
expected='read:    [500000.25, 5400000.0, 12.5]
written: "translation":[500000.25,5400000.0,12.5]'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
