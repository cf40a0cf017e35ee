#!/usr/bin/env bash
# Proves that the install step lacks no package. Makes a Debian root with nothing but debootstrap's
# minbase, puts a clone of the committed tree there, runs scripts/run.sh, and pastes the curl line
# that it prints. Puts two larger scenes where there are any ($SIGHTLINE_DATA, default
# ../shared/data), and runs scripts/test.sh without them. Prints how long each step took.
#
#   scripts/bare_check.sh [--suite bookworm|trixie] [--keep] [--run-only] [--package] [-- ARGUMENTS OF test.sh]
#
# --suite     the release of Debian (default: bookworm, Debian 12; trixie is Debian 13)
# --keep      leave the root in build/bare (default: remove it)
# --run-only  without scripts/test.sh
# --package   also build the .deb; in a second bare root install it with apt, serve, ask, and purge it
#
# Needs root. Everything that is mounted lives in a mount namespace of its own and vanishes with it,
# whatever happens; so do all processes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

keep=no
suite=bookworm
run_only=no
package=no
test_arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --keep) keep=yes; shift ;;
    --suite) suite=${2:?--suite needs a name}; shift 2 ;;
    --run-only) run_only=yes; shift ;;
    --package) package=yes; shift ;;
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
make_root() {
  debootstrap --variant=minbase "$suite" "$1" "${mirror:-http://deb.debian.org/debian}" >"$work/debootstrap.log" ||
    { tail "$work/debootstrap.log" >&2; exit 1; }
  # Proxies and the like under which apt works on this machine are valid inside too.
  apt-config dump --format '%f "%v";%n' | grep -E '^Acquire::(https?|Check|Retries)' \
    >"$1/etc/apt/apt.conf.d/90host" || true
  cp -L /etc/resolv.conf /etc/hosts "$1/etc/"
  # So are the certificates with which npm works.
  local certificates
  certificates=$(npm config get cafile 2>/dev/null || true)
  if [ -f "$certificates" ]; then
    cp -L "$certificates" "$1/root/npm-certificates.pem"
    echo "cafile=/root/npm-certificates.pem" >"$1/root/.npmrc"
  fi
}
make_root "$root"
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
      LANG=C.UTF-8 bash -euc "cd /root/sightline 2>/dev/null || cd /root; $*"
  ' bash "$root" "$@"
}

# Serves, pastes the printed line as a reader would, and stops the server again.
inside '
  run_and_ask() {
    started=$SECONDS
    # The line of an earlier run must not be taken for the line of this one.
    rm -f /root/run.log
    ./scripts/run.sh --port 0 >/root/run.log 2>&1 &
    run=$!
    until grep -qs "^curl " /root/run.log; do
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
if [ "$package" = yes ]; then
  inside './scripts/package.sh'
  deb=$(ls "$root"/root/sightline/build/package/sightline_*.deb)
  clean=$work/clean
  make_root "$clean"
  cp "$deb" "$clean/root/"
  build_root=$root
  root=$clean
  inside '
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends ./sightline_*.deb curl python3 >/dev/null
    dpkg-query -W sightline
    # There is no systemd in this root: the command line of the unit, as root.
    command=$(sed -n "s/^ExecStart=//p" /usr/lib/systemd/system/sightline.service)
    mkdir -p /var/lib/sightline
    sightline check-config /etc/sightline/sightline.json
    $command >/root/serve.log 2>&1 &
    server=$!
    until curl -fsS -o /dev/null http://127.0.0.1:8080/readyz 2>/dev/null; do
      kill -0 $server || { cat /root/serve.log; exit 1; }
      sleep 0.2
    done
    sightline demo town town.glb
    python3 -c "
from sightline import Sightline
with Sightline(\"http://127.0.0.1:8080\") as server:
    server.put(\"town\", \"town.glb\")
    print(server.closest(\"town\", [[3, 200, 5]], [[0, -1, 0]], fields=[\"t\", \"node\"]))"
    curl -fsS http://127.0.0.1:8080/v1/scenes/town/rays:closest -d "{\"rays\":[{\"origin\":[3,200,5],\"direction\":[0,-1,0]}]}" |
      grep -F "\"t\":199.75"
    kill -TERM $server
    wait $server
    test -s /usr/share/man/man1/sightline.1
    apt-get purge -y -qq sightline >/dev/null
    for left in /usr/bin/sightline /etc/sightline /usr/lib/systemd/system/sightline.service \
      /usr/lib/python3/dist-packages/sightline.py /usr/lib/python3/dist-packages/sightline_bulk.py /usr/share/doc/sightline; do
      [ ! -e $left ] || { echo "purge left $left"; exit 1; }
    done
    ! getent group sightline-keys
    ls /var/lib/sightline/scenes
    echo "package: installs, serves, is purged; the data stays"
  '
  root=$build_root
fi
[ "$run_only" = no ] || exit 0
inside "
  started=\$SECONDS
  ./scripts/test.sh ${test_arguments[*]} >/root/test.log 2>&1 || { tail -n 60 /root/test.log; exit 1; }
  grep ^SKIPPED /root/test.log || true
  tail -n 1 /root/test.log
  echo \"test.sh: \$((SECONDS - started)) s\"
"
