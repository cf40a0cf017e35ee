#!/usr/bin/env bash
# Builds the engine for aarch64 (ARM) with Debian's cross compiler and runs it under qemu-user. It runs the unit tests of geometry,
# bvh, trace and run, among them the golden hashes: the bytes equal those of x86-64. It also runs families of hard rays that
# rational arithmetic judges, Embree beside them, and hard pairs of rays and boxes.
#
#   scripts/arm_check.sh [--root FOLDER] [--rays N]
#
# --root FOLDER  where Debian 12's libraries for aarch64 are unpacked (default build/arm-root, made when it is missing: 400 MB)
# --rays N       rays of each of the families of a round (default 4100: 200,900 rays)
#
# Takes about 20 minutes on 2 cores. Needs root only to install the packages. Nothing is emulated at build time.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

root=$PWD/build/arm-root
rays=4100
while [ $# -gt 0 ]; do
  case $1 in
    --root) root=$(realpath -m "${2:?--root needs a folder}"); shift 2 ;;
    --rays) rays=${2:?--rays needs a number}; shift 2 ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "$0: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done

scripts/install_packages.sh build arm
libraries="libtinygltf-dev libmeshoptimizer-dev libdraco-dev nlohmann-json3-dev libcpp-httplib-dev libsimdjson-dev \
  libfast-float-dev libspdlog-dev libcli11-dev libcurl4-openssl-dev libpugixml-dev prometheus-cpp-dev libtbb-dev libhwy-dev \
  libssl-dev zlib1g-dev libpng-dev libzstd-dev libbrotli-dev libgtest-dev libgmp-dev libembree-dev libstdc++-12-dev libc6-dev"

if [ ! -e "$root/complete" ]; then
  rm -rf "$root"
  mkdir -p "$root"
  # Debian 12, as this machine or another: the compiler and the libraries must be of one release.
  mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE)' 2>/dev/null | awk '$2 == "bookworm" {print $1; exit}')
  debootstrap --foreign --arch=arm64 --variant=minbase --include="${libraries// /,}" bookworm "$root" \
    "${mirror:-http://deb.debian.org/debian}" >"$root.log" || { tail "$root.log" >&2; exit 1; }
  for package in "$root"/var/cache/apt/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -x --keep-directory-symlink -C "$root"
  done
  # Links and CMake's package files name absolute paths, which must lead into the folder.
  find "$root/usr" -lname '/*' | while read -r link; do ln -sfn "$root$(readlink "$link")" "$link"; done
  grep -rlE '[";]/usr/(lib|include)' "$root/usr/lib/aarch64-linux-gnu/cmake" |
    xargs -r sed -i -E "s#([\";])/usr/(lib|include)#\1$root/usr/\2#g"
  touch "$root/complete"
fi

tests=(geometry bvh trace run)
cmake --preset release -B build/aarch64 -DSIGHTLINE_WARNINGS_AS_ERRORS=ON -DSIGHTLINE_ARM_ROOT="$root" \
  -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/aarch64.cmake" >build/configure-aarch64.log 2>&1 ||
  { cat build/configure-aarch64.log; exit 1; }
cmake --build build/aarch64 --target stress_program stress_boxes "${tests[@]/#/unit_}"

export SIGHTLINE_SOURCE=$PWD
for test in "${tests[@]}"; do
  qemu-aarch64 -L "$root" "build/aarch64/tests/unit/$test/unit_$test" --gtest_brief=1
done
qemu-aarch64 -L "$root" build/aarch64/tests/stress/sightline_stress --rounds 1 --rays "$rays" --seed 20251125
qemu-aarch64 -L "$root" build/aarch64/tests/stress/sightline_stress_boxes --pairs 40000 --triangle-pairs 1000 --seed 20251125
echo "aarch64: unit tests of ${tests[*]} passed, golden hashes equal, no wrong ray or pair"
