#!/usr/bin/env bash
# Runs one benchmark: builds it, measures, draws the chart, and closes with its floors.
#
#   scripts/bench.sh trace [--quick] [OPTION...]    Sightline beside Embree, ray by ray
#   scripts/bench.sh accuracy [--quick] [OPTION...] run time against error
#   scripts/bench.sh build [--quick] [OPTION...]    building trees beside Embree
#   scripts/bench.sh scale [--quick] [OPTION...]    time and memory as scenes grow
#   scripts/bench.sh skip [--quick] [OPTION...]     lazily beside nothing skipped
#   scripts/bench.sh door [--quick] [OPTION...]     trivial requests beside cpp-httplib and nginx
#   scripts/bench.sh http [--quick] [OPTION...]     rays over HTTP beside the codec alone and Embree
#   scripts/bench.sh client [ROUNDS]                5 M rays by the Python client, beside slices by hand and raw bytes
#   scripts/bench.sh patch [ROUNDS]                 PATCH of 1,000 of 4,000 nodes, durable
#   scripts/bench.sh large KIND [COUNT]             a mesh, instances or nodes: how soon they are ready; placed meshes (placed); a mesh
#                                                   beyond the memory budget (budget) or in little memory (small); answers judged
#   scripts/bench.sh page [ROUNDS]                  first picture, picks, bytes sent, pictures that the server traces
#
# Writes build/bench/NAME.json, .csv, .md, .svg and .png. Every floor that the benchmark measures
# is a line "floor N: FIGURE (needs FIGURE) ok|short" at the end. OPTIONs go to the program
# (build/release/tests/bench/NAME_bench --help lists them).
# Scenes from files are taken from $SIGHTLINE_DATA (default: ../shared/data beside the checkout).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() { sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; }
case ${1:-} in
  trace | accuracy | build | scale | skip | door | http) name=$1; shift ;;
  patch)
    cmake --preset release -DSIGHTLINE_TESTS=ON >&2
    cmake --build --preset release --target sightline >&2
    exec python3 -B tests/bench/patch_bench.py build/release/sightline "${@:2}"
    ;;
  client)
    scripts/install_packages.sh test
    cmake --preset release -DSIGHTLINE_TESTS=ON >&2
    cmake --build --preset release --target sightline >&2
    # Debian's numpy belongs to Debian's Python.
    exec /usr/bin/python3 -B tests/bench/client_bench.py build/release/sightline "${@:2}"
    ;;
  large)
    scripts/install_packages.sh test
    cmake --preset release -DSIGHTLINE_TESTS=ON >&2
    cmake --build --preset release --target sightline >&2
    exec /usr/bin/python3 -B tests/bench/large_bench.py build/release/sightline "${@:2}"
    ;;
  page)
    scripts/install_packages.sh browser
    cmake --preset release -DSIGHTLINE_TESTS=ON >&2
    cmake --build --preset release --target sightline >&2
    exec python3 -B tests/bench/page_bench.py build/release/sightline "${@:2}"
    ;;
  -h | --help) usage; exit 0 ;;
  *) usage >&2; exit 2 ;;
esac

scripts/install_packages.sh bench
mkdir -p build/bench
if ! grep -qs 'SIGHTLINE_TESTS:BOOL=ON' build/release/CMakeCache.txt; then
  cmake --preset release -DSIGHTLINE_TESTS=ON >build/configure-release.log 2>&1 ||
    { cat build/configure-release.log >&2; exit 1; }
fi
cmake --build --preset release --target "${name}_bench" >&2

# The floors come last, after the chart.
code=0
build/release/tests/bench/"${name}_bench" --out build/bench "$@" |
  tee "build/bench/$name.log" | { grep --line-buffered -v '^floor ' || true; } || code=$?
[ "$code" = 0 ] || { echo "$0: the benchmark failed, see build/bench/$name.log" >&2; exit 1; }
python3 -B scripts/plot_"$name".py build/bench
grep '^floor ' "build/bench/$name.log"
