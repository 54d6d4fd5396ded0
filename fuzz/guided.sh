#!/usr/bin/env bash
# Coverage-guided fuzzing of one reader, on the stable toolchain: fuzz/guided.sh TARGET [TIME], as `ply 10m`.
# Targets are the tests of fuzz/guided. Inputs that reach new code are kept in target/guided, and what fails
# in target/guided/failed. Exit code 3 (skipped) without cargo-bolero.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${1:?name a target, as ply}
cargo bolero --version >/dev/null 2>&1 || {
    echo "skipped: no cargo-bolero; cargo install cargo-bolero" >&2
    exit 3
}
kept=target/guided/$target
mkdir -p "$kept" target/guided/failed
cp -n "fuzz/corpus/${target%_binary}/"* "$kept"
# Sanitizers need nightly, and find nothing in code without `unsafe`.
cargo bolero test --package trisect-fuzz-guided --sanitizer NONE --profile release \
    --corpus-dir "$PWD/$kept" --crashes-dir "$PWD/target/guided/failed" -T "${2:-1m}" "$target"
