#!/usr/bin/env bash
# trimesh's own tests of rays, proximity, thickness, voxels and inertia, from its source distribution, with trisect in
# the place of its tracer. PYTHON is an interpreter with trisect, trimesh, pytest and scipy; exit code 3 where the source
# cannot be fetched.
set -euo pipefail
cd "$(dirname "$0")"
python=${PYTHON:-python3}
version=$("$python" -c 'import trimesh; print(trimesh.__version__)')
cache=${XDG_CACHE_HOME:-$PWD/.cache}/trimesh-$version
if [[ ! -d $cache/tests ]]; then
    mkdir -p "$cache"
    "$python" -m pip download --quiet --no-deps --no-binary trimesh --dest "$cache" \
        "trimesh==$version" || exit 3
    tar -xzf "$cache/trimesh-$version.tar.gz" -C "$cache" --strip-components=1 "trimesh-$version/tests"
fi
cp tests/trimesh_generic.py "$cache/tests/generic.py"
export PYTHONPATH=$cache/tests TRISECT_MESHES=$PWD/../../data/meshes
# In place before any test makes a mesh.
exec "$python" -c '
import sys, pytest, trisect.trimesh
trisect.trimesh.install()
sys.exit(pytest.main(sys.argv[1:]))
' -q -p no:cacheprovider --rootdir "$cache/tests" -c /dev/null \
    "$cache"/tests/test_{ray,ray_upstream,proximity,thickness,voxel,inertia}.py "$@"
