#!/usr/bin/env bash
# Builds the container image, tries it out, and prints what it found. The image becomes ready, takes
# a scene, answers exactly, and stops on SIGTERM with exit code 0. It is at most 120 MB larger than its
# base. Writes its bill of materials (SPDX) beside it: build/image/sightline.spdx.json.
#
#   scripts/image.sh [--tag NAME] [--fresh]
#
# --tag NAME  name of the image (default: sightline)
# --fresh     forget the base and storage of earlier runs (only without docker)
#
# Where a docker daemon answers, docker does it. Elsewhere buildah and podman do, as root: the base
# image is made by debootstrap from the mirror that this machine uses, and everything is stored in
# build/image. Take the image elsewhere with the command that is printed at the end.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tag=sightline
fresh=no
while [ $# -gt 0 ]; do
  case $1 in
    --tag) tag=${2:?--tag needs a name}; shift 2 ;;
    --fresh) fresh=yes; shift ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "$0: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done

base=docker.io/library/debian:bookworm-slim
limit_mb=120
work=$PWD/build/image
started=$SECONDS
step() { printf '== %s (%d s)\n' "$*" $((SECONDS - started)); }
fail() { echo "$0: $*" >&2; exit 1; }
free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

if docker info >/dev/null 2>&1; then
  command -v curl python3 >/dev/null || fail "needs curl and python3"
  step "building with docker"
  docker build --quiet -f docker/Dockerfile -t "$tag" . >/dev/null
  engine=(docker)
  quiet=()
  port=$(free_port)
  place=(--publish "127.0.0.1:$port:8080")
  listen=0.0.0.0:8080
  inner_port=8080
  health() { docker exec "$container" ready; }
else
  scripts/install_packages.sh image
  [ "$(id -u)" = 0 ] || exec sudo "$0" --tag "$tag" $([ "$fresh" = no ] || echo --fresh)
  [ "$fresh" = no ] || rm -rf "$work"
  mkdir -p "$work"
  # vfs and chroot isolation need nothing of the kernel; a storage of our own leaves none behind.
  storage=(--root "$work/storage" --runroot "$work/run" --storage-driver vfs)
  engine=(podman "${storage[@]}" --cgroup-manager cgroupfs)
  quiet=(--log-level fatal)

  if ! "${engine[@]}" image exists "$base"; then
    step "making the base image by debootstrap"
    mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE)' 2>/dev/null |
      awk '$2 ~ /^bookworm$/ {print $1; exit}')
    rm -rf "$work/root"
    debootstrap --variant=minbase bookworm "$work/root" "${mirror:-http://deb.debian.org/debian}" >"$work/debootstrap.log" ||
      fail "debootstrap failed, see $work/debootstrap.log"
    # Proxies and the like under which apt works on this machine hold in the build too.
    apt-config dump --format '%f "%v";%n' | grep -E '^Acquire::(https?|Check|Retries)' \
      >"$work/root/etc/apt/apt.conf.d/90host" || true
    # What Debian leaves out of its slim images.
    rm -rf "$work"/root/usr/share/{doc,man,info,locale}/* "$work"/root/var/{lib/apt/lists,cache/apt,log}/*
    tar -C "$work/root" -c . | "${engine[@]}" import --quiet - "$base" >/dev/null
    rm -rf "$work/root"
  fi
  step "building with buildah"
  # Docker's own format: the other one has no HEALTHCHECK.
  buildah "${storage[@]}" bud --quiet --isolation chroot --format docker --pull-never \
    -f docker/Dockerfile -t "$tag" . >"$work/build.log" 2>&1 || { tail -n 40 "$work/build.log" >&2; fail "the build failed"; }
  port=$(free_port)
  place=(--runtime runc --network host --ulimit nofile=1024:1024 --ulimit nproc=1024:1024)
  listen=127.0.0.1:$port
  inner_port=$port
  health() { "${engine[@]}" healthcheck run "$container"; }
fi

step "running it"
url=http://127.0.0.1:$port
# Without systemd podman cannot set a timer for the health check and says so; it is run by hand below.
container=$("${engine[@]}" "${quiet[@]}" run --detach "${place[@]}" \
  --env "SIGHTLINE_PORT=$inner_port" "$tag" serve --listen "$listen" --data /data --insecure)
files=$(mktemp -d)
trap '"${engine[@]}" rm --force --volumes "$container" >/dev/null 2>&1 || true; rm -rf "$files"' EXIT

for _ in $(seq 300); do
  curl -fsS -o /dev/null "$url/readyz" 2>/dev/null && break
  [ "$("${engine[@]}" inspect --format '{{.State.Running}}' "$container")" = true ] ||
    { "${engine[@]}" logs "$container" >&2; fail "the server ended before it was ready"; }
  sleep 0.1
done
curl -fsS -o /dev/null "$url/readyz" || { "${engine[@]}" logs "$container" >&2; fail "not ready after 30 s"; }
health >/dev/null || fail "the image's own health check says no"
step "ready; the image's own health check agrees"

# One triangle in the plane z = 0 around the origin, as a GLB: the ray from (0,0,5) along -z meets it
# at t = 5.
python3 - "$files/triangle.glb" <<'PYTHON'
import json, struct, sys
corners = struct.pack("<9f", -1, -1, 0, 1, -1, 0, 0, 1, 0)
gltf = json.dumps({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "leaf", "mesh": 0}],
    "meshes": [{"name": "one triangle", "primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [-1, -1, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": len(corners)}],
    "buffers": [{"byteLength": len(corners)}]}).encode()
gltf += b" " * (-len(gltf) % 4)
with open(sys.argv[1], "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(gltf) + 8 + len(corners)))
    file.write(struct.pack("<I4s", len(gltf), b"JSON") + gltf)
    file.write(struct.pack("<I4s", len(corners), b"BIN\0") + corners)
PYTHON
status=$(curl -sS -o "$files/put.json" -w '%{http_code}' -X PUT -H 'Content-Type: model/gltf-binary' \
  --data-binary @"$files/triangle.glb" "$url/v1/scenes/triangle")
[ "$status" = 201 ] || { cat "$files/put.json" >&2; fail "PUT answered $status"; }
answer=$(curl -sS -H 'Content-Type: application/json' "$url/v1/scenes/triangle/rays:closest" \
  -d '{"rays":[{"origin":[0,0,5],"direction":[0,0,-1]},{"origin":[0,0,5],"direction":[0,0,1]}]}')
python3 -c '
import json, sys
hits = json.loads(sys.argv[1])["hits"]
sys.exit(0 if hits[0]["t"] == 5 and hits[1] is None else 1)' "$answer" || fail "wrong answer: $answer"
step "took a scene and answered: $answer"

page=()
curl -fsS "$url/page.js" | grep -q 'The page was not built' && page=(--without-page)
"${engine[@]}" kill --signal TERM "$container" >/dev/null
code=$("${engine[@]}" wait "$container")
[ "$code" = 0 ] || { "${engine[@]}" logs "$container" >&2; fail "stopped by SIGTERM with exit code $code"; }
step "stopped by SIGTERM with exit code 0"

mkdir -p "$work" "$files/root"
"${engine[@]}" export "$container" | tar -C "$files/root" -x --no-same-owner --exclude='dev/*' --exclude='proc/*' --exclude='sys/*'
scripts/sbom.py "$files/root" "${page[@]}" -o "$work/sightline.spdx.json"
step "bill of materials of $(grep -c '"versionInfo"' "$work/sightline.spdx.json") packages: $work/sightline.spdx.json"

size_of() { "${engine[@]}" image inspect --format '{{.Size}}' "$1"; }
user=$("${engine[@]}" image inspect --format '{{.Config.User}}' "$tag")
[ -n "$user" ] && [ "$user" != root ] || fail "the image runs as root"
if ! base_bytes=$(size_of "$base" 2>/dev/null); then
  docker pull --quiet "$base" >/dev/null # a builder keeps its base to itself
  base_bytes=$(size_of "$base")
fi
bytes=$(size_of "$tag")
above=$(((bytes - base_bytes) / 1000000))
echo "image $((bytes / 1000000)) MB, base $((base_bytes / 1000000)) MB, above the base $above MB (limit $limit_mb MB), user $user"
[ "$above" -le "$limit_mb" ] || fail "the image is too large"
if [ "${engine[0]}" = podman ]; then
  echo "take it elsewhere: ${engine[*]} save --format docker-archive -o sightline.tar $tag"
fi
