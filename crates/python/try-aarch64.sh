#!/usr/bin/env bash
# Tries a wheel for aarch64 under qemu-user, with numpy alone: the tests of instances and of shapes, and those of truth.
# Debian's packages of Python and of the C library for arm64 are unpacked beside the build, and nothing but qemu-user is
# installed. Exit code 3 where any of them cannot be fetched.
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")"
place=${CARGO_TARGET_DIR:-$PWD/../../target}/python-aarch64

skip() {
    echo "skipped: $*" >&2
    exit 3
}

command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null || skip "this is no Debian"
command -v qemu-aarch64 >/dev/null || apt-get install --yes --no-install-recommends qemu-user >/dev/null 2>&1 ||
    skip "qemu-user cannot be installed"
if [[ ! -e $place/done ]]; then
    rm -rf "$place"
    mkdir -p "$place"/{root,packages,lists/partial}
    # Lists of its own: those of the system, and its architectures, stay as they are.
    debian=(-o "Dir::State::Lists=$place/lists" -o "Dir::Cache=$place" -o APT::Sandbox::User=root
        -o APT::Architecture=arm64 -o APT::Architectures::=arm64)
    apt-get "${debian[@]}" update >/dev/null 2>&1 || skip "the lists of Debian for arm64 cannot be fetched"
    version=$(apt-cache "${debian[@]}" show python3-minimal | sed -n 's/^Pre-Depends:.*\(python3\.[0-9]*\)-minimal.*/\1/p' | head -1)
    (
        cd "$place/packages"
        apt-get "${debian[@]}" download "$version-minimal" "lib$version-minimal" "lib$version-stdlib" libc6 libgcc-s1 \
            libstdc++6 zlib1g libexpat1 libffi8 libbz2-1.0 liblzma5
    ) >/dev/null 2>&1 || skip "Debian's packages for arm64 cannot be fetched"
    for package in "$place"/packages/*.deb; do
        dpkg-deb --extract "$package" "$place/root"
    done
    "${PYTHON:-python3}" -m pip download --quiet --dest "$place/packages" --only-binary :all: --implementation cp \
        --python-version "${version#python}" --platform manylinux2014_aarch64 --platform manylinux_2_28_aarch64 \
        numpy pytest || skip "numpy for aarch64 cannot be fetched"
    echo "$version" >"$place/done"
fi
rm -rf "$place/site"
mkdir "$place/site"
for package in "$place"/packages/*.whl "$wheel"; do
    "${PYTHON:-python3}" -m zipfile --extract "$package" "$place/site"
done
export PYTHONPATH=$place/site PYTHONDONTWRITEBYTECODE=1
exec qemu-aarch64 -L "$place/root" "$place/root/usr/bin/$(<"$place/done")" -m pytest -q -p no:cacheprovider \
    tests/test_instances.py tests/test_scene.py -k "rational or shapes or layouts or instances or pickle"
