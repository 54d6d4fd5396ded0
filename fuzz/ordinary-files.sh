#!/usr/bin/env bash
# Counts how many of the mesh files that three Debian packages ship the program loads. The packages are
# unpacked into a temporary folder, not installed. Exit code 3 (skipped) where they cannot be had; otherwise
# that of `ordinary-files`. Arguments go to it, as `--program FILE`.
set -euo pipefail
packages=(assimp-testmodels openscad-testing-data glmark2-data)
root=$(cd "$(dirname "$0")/.." && pwd)

skip() {
    echo "skipped: $*" >&2
    exit 3
}
for tool in apt-get dpkg-deb; do
    command -v "$tool" >/dev/null || skip "no $tool"
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
(cd "$folder" && apt-get download "${packages[@]}" >/dev/null 2>&1) || skip "the packages cannot be fetched"
for package in "$folder"/*.deb; do
    dpkg-deb --extract "$package" "$folder/files"
done
cd "$root"
cargo run --quiet --release --package trisect-fuzz --bin ordinary-files -- "$@" "$folder/files"
