#!/usr/bin/env bash
# Families of hard rays with fresh seeds until the time is up, on Sightline, Embree (default and
# robust) and the textbook tests, judged by rational arithmetic.
#
#   scripts/stress.sh [--minutes N] [--out FOLDER] [FLAG...]
#   scripts/stress.sh --boxes [--out FOLDER] [FLAG...]
#   scripts/stress.sh fuzz [--minutes N] [--jobs N] [--target NAME]... [--list]
#   scripts/stress.sh kills [--times N] [--seed S] [--memory-budget BYTES]
#   scripts/stress.sh soak [--minutes N] [--workers N] [--seed S] [--difficult]
#   scripts/stress.sh faults [--times N] [--seed S]
#   scripts/stress.sh client [--calls N] [--seed S]
#   scripts/stress.sh large
#   scripts/stress.sh cases
#   scripts/stress.sh geometry
#
# --boxes       instead of rays in scenes, pairs of rays and boxes (10,000,000) and of triangles and
#               boxes (2,000,000; at least a third of each touching exactly), beside the literature's
#               tests; boxes.json and boxes.md, and "floor 5: ..." as the last line. About four CPU
#               minutes. FLAGs: --pairs N, --triangle-pairs N, --seed S, --threads N
# --minutes N   how long (default 20)
# --out FOLDER  where stress.json, stress.md and trials.log go (default build/stress)
# FLAG...       passed on: --seed S, --family NAME, --rays N, --kernel NAME, --threads N, ...
#
# fuzz runs every libFuzzer target, 10 minutes each and two at once unless told otherwise, with
# AddressSanitizer and UndefinedBehaviorSanitizer (tests/fuzz/run_fuzz.py --help). A crash, leak, hang
# or broken promise in one of them fails it.
#
# kills ends a server with kill -9, 100 times unless told otherwise, at random moments of uploads,
# builds and writes, half of them on a disk that strace slows down. It checks that every
# acknowledged scene is there and right afterwards, and nothing else (tests/integration/kills.py).
#
# soak asks a server of everything at once for 30 minutes, beside clients that leave and scenes that come
# and go, and holds every answer against a stored truth (tests/integration/soak.py); build/stress/soak.md and
# "floor 3: ..." as the last lines. --difficult adds the slow, waiting and expensive clients of tests/bench/mixed_load.py.
#
# faults makes the disk full and every step of a commit fail: the kernel reports it, or strace in its place.
# It exhausts the budgets of memory, damages files, and ends with kills (20 times unless told otherwise).
#
# client makes 100,000 random calls of the Python client, with right and wrong shapes, layouts, dtypes and numbers, and
# compares every answer with a model (tests/integration/python_client_fuzz.py). It says SKIPPED without numpy.
#
# large sends 20,000,000 rays in one stream and 1,000,000 in one body of JSON. It checks the order of the answers and
# the memory that a server takes above its scene (64 MiB, and 3 times the body).
#
# cases runs the tests that draw random cases under AddressSanitizer and UndefinedBehaviorSanitizer with all of them,
# where scripts/test.sh runs an eighth.
#
# geometry judges 200,000 pairs of crossing triangles, 200,000 pairs of convex bodies (kind and penetration depth), and
# 200,000 rays through masked materials (tests/unit/geometry, tests/unit/run, tests/integration/alpha_cutoff_test.py).
# It also judges 200,000 sweeps of each shape: spheres, capsules, boxes and turned boxes, with time, point and normal of
# each contact (tests/unit/trace/sweep_test.cpp), and 200,000 winding numbers of open meshes
# (tests/unit/run/solid_angle_test.cpp). And 200,000 hulls of points with triangles (tests/unit/geometry/point_hull_test.cpp),
# 200,000 depths and contact normals of boxes and hulls, and 200,000 of balls and capsules
# (tests/unit/geometry/shape_contact_test.cpp). All take about 38 minutes of one processor.
#
# The exit code is not 0 if Sightline was wrong once, or stopped. A wrong answer is printed with its
# family and seed; `sightline_stress --family F --trial S --rays N --shrink` makes the smallest case
# of it. After a crash the last lines of trials.log name the trials that were under way.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

configure() {  # PRESET
  mkdir -p build
  cmake --preset "$1" -DSIGHTLINE_TESTS=ON >"build/configure-$1.log" 2>&1 ||
    { cat "build/configure-$1.log"; echo "$0: cannot configure" >&2; exit 1; }
}

case ${1:-} in
  fuzz)
    shift
    scripts/install_packages.sh test lint
    configure fuzz
    mapfile -t targets < <(python3 tests/fuzz/run_fuzz.py --list)
    cmake --build --preset fuzz --target "${targets[@]}"
    exec python3 tests/fuzz/run_fuzz.py "$@"
    ;;
  faults)
    shift
    scripts/install_packages.sh test
    configure release
    cmake --build --preset release --target sightline
    for name in full_disk memory restart; do
      (cd tests/integration && python3 -B "${name}_test.py" ../../build/release/sightline)
    done
    exec python3 -B tests/integration/kills.py build/release/sightline --times 20 "$@"
    ;;
  client)
    shift
    scripts/install_packages.sh test
    configure release
    cmake --build --preset release --target sightline
    # Debian's numpy belongs to Debian's Python.
    exec /usr/bin/python3 -B tests/integration/python_client_fuzz.py build/release/sightline "$@"
    ;;
  large)
    scripts/install_packages.sh test
    configure release
    cmake --build --preset release --target sightline
    binary=$PWD/build/release/sightline
    cd tests/integration
    export SIGHTLINE_STREAM_RAYS=20000000
    python3 -B streams_test.py "$binary" Streams.test_memory_does_not_grow_with_the_stream
    exec python3 -B memory_test.py "$binary" Budget.test_rays_in_one_body_take_three_times_the_body
    ;;
  cases)
    scripts/install_packages.sh test
    configure asan
    programs=(unit_geometry unit_trace unit_run oracle_test)
    cmake --build --preset asan --target "${programs[@]}"
    SIGHTLINE_ALL_CASES=1 exec ctest --preset asan --tests-regex "^($(IFS='|'; echo "${programs[*]}"))\$"
    ;;
  geometry)
    scripts/install_packages.sh test
    configure release
    cmake --build --preset release --target sightline unit_geometry unit_run unit_trace
    SIGHTLINE_TIMES_CASES=8 build/release/tests/unit/geometry/unit_geometry --gtest_filter='TriangleCrossing.*'
    for test in PointHull.meets:200 PointHull.of_numbers:40 ShapeContact.of_hulls:134 ShapeContact.of_balls:400; do
      SIGHTLINE_TIMES_CASES=${test#*:} build/release/tests/unit/geometry/unit_geometry --gtest_filter="${test%:*}*"
    done
    SIGHTLINE_TIMES_CASES=50 build/release/tests/unit/run/unit_run --gtest_filter='NodeClashes.*'
    SIGHTLINE_TIMES_CASES=110 build/release/tests/unit/run/unit_run --gtest_filter='SolidAngle.*'
    for shape in spheres:67 capsules:200 boxes:134 turned_boxes:400; do
      SIGHTLINE_TIMES_CASES=${shape#*:} build/release/tests/unit/trace/unit_trace --gtest_filter="Sweep.${shape%:*}_meet_*"
    done
    binary=$PWD/build/release/sightline
    cd tests/integration
    SIGHTLINE_ALPHA_RAYS=200000 exec python3 -B alpha_cutoff_test.py "$binary" AlphaCutoff.test_random_scenes_against_images_read_here
    ;;
  kills | soak)
    name=$1
    shift
    scripts/install_packages.sh test
    configure release
    cmake --build --preset release --target sightline
    exec python3 -B "tests/integration/$name.py" build/release/sightline "$@"
    ;;
esac

minutes=20
boxes=
out=build/stress
flags=()
while [ $# -gt 0 ]; do
  case $1 in
    --minutes) minutes=${2:?--minutes needs a number}; shift 2 ;;
    --boxes) boxes=yes; shift ;;
    --out) out=${2:?--out needs a folder}; shift 2 ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) flags+=("$1"); shift ;;
  esac
done

scripts/install_packages.sh test
mkdir -p "$out"
configure release
if [ -n "$boxes" ]; then
  cmake --build --preset release --target stress_boxes
  exec build/release/tests/stress/sightline_stress_boxes --pairs 10000000 --triangle-pairs 2000000 \
    --json "$out/boxes.json" --markdown "$out/boxes.md" "${flags[@]}"
fi
cmake --build --preset release --target stress_program

code=0
build/release/tests/stress/sightline_stress --minutes "$minutes" --log \
  --json "$out/stress.json" --markdown "$out/stress.md" "${flags[@]}" 2>"$out/trials.log" || code=$?
if [ "$code" -gt 2 ]; then
  echo "sightline_stress stopped with code $code; under way were:" >&2
  tail -n 3 "$out/trials.log" >&2
fi
exit "$code"
