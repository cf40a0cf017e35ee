#!/usr/bin/env bash
# Installs the packages of Debian 12 or 13 that a task needs and that are missing; touches nothing when none
# is. Packages are listed only in this file; docs/dependencies.md says what each is
# for.
#
#   scripts/install_packages.sh GROUP...           install what is missing
#   scripts/install_packages.sh --print GROUP...   print the list, one package per line
#
# Groups: engine (compile the server without its page), build (compile the server), run (build, and ask it),
#         test (build and run every test), lint (clang, clang-tidy), image (make a container image without docker),
#         browser (test, with the pages in a headless browser; scripts/page_pictures.sh),
#         bench (build every benchmark and draw its charts), package (make a .deb),
#         cluster (an object store and a balancer; scripts/cluster_test.sh),
#         convert (build sightline-convert too),
#         arm (build for aarch64 and run under qemu-user; scripts/arm_check.sh).
set -euo pipefail

engine="g++ cmake ninja-build pkg-config ca-certificates
  libtinygltf-dev libmeshoptimizer-dev libdraco-dev nlohmann-json3-dev libcpp-httplib-dev libsimdjson-dev libfast-float-dev libspdlog-dev
  libcli11-dev libcurl4-openssl-dev libpugixml-dev prometheus-cpp-dev libtbb-dev libhwy-dev libssl-dev zlib1g-dev libpng-dev libzstd-dev libbrotli-dev"
build="$engine npm"
run="$build curl"
# A first build takes a fifth longer with a compiler cache, so run.sh does not install it.
test="$run ccache libassimp-dev libgtest-dev libgmp-dev libembree-dev python3 python3-numpy python3-yaml python3-pip python3-setuptools python3-wheel mypy strace clang-format"
bench="$test librsvg2-bin fonts-dejavu-core nginx-light libnginx-mod-stream valgrind"
browser="$test chromium fonts-dejavu-core pngquant"
convert="$build libassimp-dev"
package="$build dpkg-dev file python3"
cluster="radosgw ceph-mon ceph-osd ceph-common haproxy python3 python3-numpy python3-distributed"
arm="g++-aarch64-linux-gnu qemu-user debootstrap"
lint="clang clang-format clang-tidy python3"
image="buildah podman runc debootstrap ca-certificates curl python3"

usage() { sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"; }

print_only=no
packages=()
for argument in "$@"; do
  case $argument in
    --print) print_only=yes ;;
    build | engine | run | test | browser | bench | convert | package | cluster | arm | lint | image) read -r -d '' -a group <<<"${!argument} " || true; packages+=("${group[@]}") ;;
    -h | --help) usage; exit 0 ;;
    *) echo "$0: no group '$argument'" >&2; usage >&2; exit 2 ;;
  esac
done
[ ${#packages[@]} -gt 0 ] || { usage >&2; exit 2; }

if [ "$print_only" = yes ]; then
  printf '%s\n' "${packages[@]}" | sort -u
  exit 0
fi

if ! command -v dpkg-query >/dev/null; then
  echo "$0: this is no Debian; install by hand what '$0 --print' lists, then run cmake as CONTRIBUTING.md shows" >&2
  exit 1
fi

# Node.js and npm may come from elsewhere; Debian's npm would conflict with them.
if command -v node >/dev/null && command -v npm >/dev/null; then
  mapfile -t packages < <(printf '%s\n' "${packages[@]}" | grep -vx npm)
fi

# What is wanted minus what dpkg calls installed.
mapfile -t missing < <(comm -23 \
  <(printf '%s\n' "${packages[@]}" | sort -u) \
  <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${packages[@]}" 2>/dev/null |
    sed -n 's/^installed //p' | sort -u))
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" != 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "$0: these packages are missing and need root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

echo "installing ${#missing[@]} packages: ${missing[*]}" >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
  -o Dpkg::Use-Pty=0 "${missing[@]}" >/dev/null
