#!/usr/bin/env bash
# Fetches Embree 4 for `rivals --features embree` into target/embree/, out of the wheel of the Python
# package embreex: its two libraries, and nothing of Python's. Again at no cost once they are there.
set -euo pipefail
cd "$(dirname "$0")/.."

version=4.4.0.post1
folder=target/embree

fail() {
    printf '%s: %s\n' "${0##*/}" "$*" >&2
    exit 1
}

if [[ -e $folder/libembree4.so && -f $folder/$version ]]; then
    printf 'Embree is in %s already\n' "$folder"
    exit 0
fi
[[ $(uname -s) == Linux && $(uname -m) == x86_64 ]] ||
    fail "the wheel is for Linux on x86-64; build Embree 4 yourself and name it with --embree"
command -v python3 >/dev/null || fail "python3 is missing, which fetches the wheel; install it"
python3 -m pip --version >/dev/null 2>&1 ||
    fail "python3 has no pip, which fetches the wheel; install it"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m pip download --quiet --disable-pip-version-check --only-binary=:all: --no-deps \
    --python-version 3.11 --platform manylinux_2_28_x86_64 -d "$scratch" "embreex==$version" ||
    fail "pip cannot fetch embreex $version; is there a network?"
python3 - "$scratch" <<'PYTHON'
import pathlib, sys, zipfile
scratch = pathlib.Path(sys.argv[1])
with zipfile.ZipFile(next(scratch.glob("*.whl"))) as wheel:
    for name in wheel.namelist():
        if ".libs/" in name and ".so" in name:
            (scratch / pathlib.Path(name).name).write_bytes(wheel.read(name))
PYTHON
embree=$(find "$scratch" -name 'libembree4*.so*' -printf '%f\n' -quit)
tbb=$(find "$scratch" -name 'libtbb*.so*' -printf '%f\n' -quit)
[[ -n $embree && -n $tbb ]] || fail "the wheel of embreex $version has not the two libraries in it"

rm -rf "$folder"
mkdir -p "$folder"
# Embree asks for its other library by the very name that it has here, and finds it beside itself.
mv "$scratch/$embree" "$scratch/$tbb" "$folder/"
ln -s "$embree" "$folder/libembree4.so"
touch "$folder/$version"
printf 'Embree is in %s\n' "$folder"
