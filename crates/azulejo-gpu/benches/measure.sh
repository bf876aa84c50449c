#!/usr/bin/env bash
# Measures hemicubes on the graphics card of this machine, beside the processor and rays, and the
# thesis' box of 12,922 facets against the 251 s of its GTX 1070 Ti. Needs Rust and the card's
# driver; writes what it prints to gpu-report.txt. Words after the name go to the benchmark:
# "thesis" or "room" for one part, "quick" for less.
set -euo pipefail
cd "$(dirname "$0")/../../.."
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-$(mktemp -d)}
{
    date -u +"%F %T UTC"
    uname -srm
    grep -m1 "model name" /proc/cpuinfo || true
    nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2> /dev/null || true
    cargo bench --locked -p azulejo-gpu --bench hemicubes -- "$@"
} | tee gpu-report.txt
