#!/usr/bin/env bash
# Proves that the install step lacks no package. Makes a Debian root with nothing but debootstrap's
# minbase, puts a clone of the committed tree there, runs scripts/run.sh, and pastes the curl line
# that it prints. Puts two larger scenes where there are any ($SIGHTLINE_DATA, default
# ../shared/data), and runs scripts/test.sh without them. Prints how long each step took.
#
#   scripts/bare_check.sh [--suite bookworm|trixie] [--keep] [--run-only] [-- ARGUMENTS OF test.sh]
#
# --suite     the release of Debian (default: bookworm, Debian 12; trixie is Debian 13)
# --keep      leave the root in build/bare (default: remove it)
# --run-only  without scripts/test.sh
#
# Needs root. Everything that is mounted lives in a mount namespace of its own and vanishes with it,
# whatever happens; so do all processes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

keep=no
suite=bookworm
run_only=no
test_arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --keep) keep=yes; shift ;;
    --suite) suite=${2:?--suite needs a name}; shift 2 ;;
    --run-only) run_only=yes; shift ;;
    --) shift; test_arguments=("$@"); break ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "$0: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
case $suite in bookworm | trixie) ;; *) echo "$0: no suite '$suite': bookworm or trixie" >&2; exit 2 ;; esac
[ "$(id -u)" = 0 ] || { echo "$0: needs root" >&2; exit 1; }

scripts/install_packages.sh image
work=$PWD/build/bare
root=$work/root
rm -rf "$work"
mkdir -p "$work"
trap '[ "$keep" = yes ] || rm -rf "$work"' EXIT

started=$SECONDS
# The mirror of this machine's own Debian has the other releases too.
mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE)' 2>/dev/null |
  awk '$2 ~ /^(bookworm|trixie)$/ {print $1; exit}')
debootstrap --variant=minbase "$suite" "$root" "${mirror:-http://deb.debian.org/debian}" >"$work/debootstrap.log" ||
  { tail "$work/debootstrap.log" >&2; exit 1; }
# Proxies and the like under which apt works on this machine hold inside too.
apt-config dump --format '%f "%v";%n' | grep -E '^Acquire::(https?|Check|Retries)' \
  >"$root/etc/apt/apt.conf.d/90host" || true
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
scenes=${SIGHTLINE_DATA:-../shared/data}/scenes
mkdir -p "$root/root/scenes"
for name in furnished_house jacksboro_dem; do
  [ ! -f "$scenes/$name.glb" ] || cp "$scenes/$name.glb" "$root/root/scenes/"
done
git clone --quiet --no-hardlinks . "$root/root/sightline"
echo "bare root of $suite with $(git rev-parse --short HEAD): $((SECONDS - started)) s, $(chroot "$root" dpkg-query -W | wc -l) packages"

inside() {
  unshare --mount --pid --fork --kill-child bash -euc '
    root=$1
    shift
    mount --make-rprivate /
    mount -t proc proc "$root/proc"
    mount -t sysfs -o ro sysfs "$root/sys"
    mount --rbind /dev "$root/dev"
    exec chroot "$root" env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      LANG=C.UTF-8 bash -euc "cd /root/sightline; $*"
  ' bash "$root" "$@"
}

# Serves, pastes the printed line as a reader would, and stops the server again.
inside '
  run_and_ask() {
    started=$SECONDS
    ./scripts/run.sh --port 0 >/root/run.log 2>&1 &
    run=$!
    until grep -q "^curl " /root/run.log; do
      kill -0 $run 2>/dev/null || { tail -n 40 /root/run.log; exit 1; }
      sleep 0.2
    done
    echo "$1 run.sh: ready after $((SECONDS - started)) s"
    line=$(grep "^curl " /root/run.log)
    echo "$line"
    answer=$(bash -c "$line")
    echo "$answer"
    for word in hits t position normal node mesh; do
      case $answer in *"\"$word\""*) ;; *) echo "no $word in the answer"; exit 1 ;; esac
    done
    url=$(grep -o "http://[0-9.:]*" /root/run.log | head -n 1)
    for file in /root/scenes/*.glb; do
      [ -f "$file" ] || continue
      name=$(basename "$file" .glb)
      curl -fsS -o /dev/null -X PUT -H "Content-Type: model/gltf-binary" --data-binary "@$file" "$url/v1/scenes/$name"
      case $name in
        furnished_house) origin=5.2,100,4.7 ;;
        *) origin=15000,5000,15000 ;;
      esac
      answer=$(curl -fsS -H "Content-Type: application/json" "$url/v1/scenes/$name/rays:closest" \
        -d "{\"rays\":[{\"origin\":[$origin],\"direction\":[0,-1,0]}]}")
      echo "$name: $answer"
      case $answer in *"\"t\""*) ;; *) echo "no hit"; exit 1 ;; esac
    done
    kill -TERM $run
    code=0
    wait $run || code=$?
    echo "$1 run.sh: stopped by SIGTERM, exit code $code"
    [ $code = 0 ]
  }
  run_and_ask first
  run_and_ask second
'
[ "$run_only" = no ] || exit 0
inside "
  started=\$SECONDS
  ./scripts/test.sh ${test_arguments[*]} >/root/test.log 2>&1 || { tail -n 60 /root/test.log; exit 1; }
  grep ^SKIPPED /root/test.log || true
  tail -n 1 /root/test.log
  echo \"test.sh: \$((SECONDS - started)) s\"
"
