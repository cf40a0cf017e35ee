#!/usr/bin/env bash
# Installs what is missing, builds the server and serves the demo scenes until Ctrl-C. When it is
# ready it prints the address of its page and one curl line to paste.
#
#   scripts/run.sh [--port N] [--data DIR]
#
# --port N    TCP port on 127.0.0.1 (default: $PORT, else 8080; 0 takes a free one)
# --data DIR  where scenes that you PUT are stored; relative to where you stand (default: build/data in
#             this checkout)
set -euo pipefail
called_from=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."

port=${PORT:-8080}
data=$PWD/build/data
while [ $# -gt 0 ]; do
  case $1 in
    --port) port=${2:?--port needs a number}; shift 2 ;;
    --data) data=${2:?--data needs a folder}; shift 2 ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "$0: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
case $data in /*) ;; *) data=$called_from/$data ;; esac
case $port in
  *[!0-9]* | '') echo "$0: '$port' is no port number" >&2; exit 2 ;;
esac

scripts/install_packages.sh engine
mkdir -p build

configure() { cmake "$@" >build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }; }

# An existing build tree retains its options, so that running and testing do not rebuild each other.
[ -f build/release/build.ninja ] || configure --preset release -DSIGHTLINE_TESTS=OFF
echo "building build/release/sightline (the first time takes some minutes)" >&2
# npm, which only the page needs, has 360 packages. The engine is compiled while they are installed.
compiler=
if grep -q NPM_PROGRAM-NOTFOUND build/release/CMakeCache.txt; then
  cmake --build --preset release --target sightline_run >&2 &
  compiler=$!
  trap 'kill "$compiler" 2>/dev/null || true' EXIT
fi
scripts/install_packages.sh run
if [ -n "$compiler" ]; then
  wait "$compiler"
  configure build/release
fi
cmake --build --preset release --target sightline >&2

if [ "$port" != 0 ] && (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then
  echo "$0: port $port is taken by another program; choose one: PORT=$((port + 1)) $0" >&2
  exit 1
fi

mkdir -p "$data"
# The first line that the server prints is its address; a pipe hands it over as soon as it is there.
lines=$(mktemp -u)
mkfifo -m 600 "$lines"
# A session of its own: Ctrl-C then reaches this script only, which tells the server once to stop.
setsid build/release/sightline serve --listen "127.0.0.1:$port" --data "$data" \
  --preload town=demo:town --preload six=demo:six >"$lines" &
server=$!
interrupted=no
stop() { kill -TERM "$server" 2>/dev/null || true; }
trap 'interrupted=yes; stop' INT TERM HUP
trap stop EXIT
exec 4<"$lines"
rm -f "$lines"
if ! read -r first <&4; then
  wait "$server" && code=0 || code=$?
  echo "$0: the server stopped with exit code $code before it listened" >&2
  exit 1
fi
echo "$first"
url=${first#listening on }
cat <&4 &

until curl -fsS -o /dev/null "$url/readyz" 2>/dev/null; do
  kill -0 "$server" 2>/dev/null || { echo "$0: the server stopped before it was ready" >&2; exit 1; }
  sleep 0.1
done

# A scene of this name in the data folder replaces the demo's. If it differs, the curl line has another answer.
demo=$(mktemp)
build/release/sightline demo town "$demo"
hash=$(sha256sum <"$demo")
rm -f "$demo"
if ! curl -sS "$url/v1/scenes/town" | grep -q "\"sha256\":\"${hash%% *}\""; then
  cat >&2 <<TEXT

$0: warning: the scene "town" in $data is not the demo town (of this version), so
the line below will answer otherwise than said here. For a fresh one remove it and start again,
    curl -X DELETE $url/v1/scenes/town
or start with another folder: $0 --data ANOTHER
TEXT
fi

cat <<TEXT

Ready. Open $url/ in a browser to see the scenes.

Or ask from another terminal what lies straight below a point above the town:

curl -s $url/v1/scenes/town/rays:closest -d '{"rays":[{"origin":[3,200,5],"direction":[0,-1,0]}]}'

It answers with one hit: t 199.75, its position, the normal, and the names of the node ("market square")
and the mesh. Scenes that you PUT are stored in $data. Ctrl-C stops the server.
TEXT

# A signal ends wait early; the server then finishes what it is answering, and is waited for again.
while :; do
  code=0
  wait "$server" || code=$?
  [ "$interrupted" = yes ] || exit "$code"
  interrupted=no
done
