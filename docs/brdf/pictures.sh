#!/bin/sh
# Redraws the images of all models with the commands on their pages.
# AZULEJO names the program; without it, it is built.
set -eu
cd "$(dirname "$0")/../.."
grep -h '^azulejo brdf plot' docs/brdf/*.md | while read -r _ arguments; do
    # The arguments are words without blanks in them.
    # shellcheck disable=SC2086
    ${AZULEJO:-cargo run --quiet --release --} $arguments --quiet </dev/null
done
