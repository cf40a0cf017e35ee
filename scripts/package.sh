#!/usr/bin/env bash
# Builds a Debian package of this machine's release: binary, man page, systemd unit, sysusers, settings,
# examples and the Python client; and the Python client alone as a wheel and a source distribution. Prints the paths.
#
#   scripts/package.sh [--output DIR]
#
# --output DIR  where to put the files (default: build/package)
#
# Install it with `apt install ./sightline_*.deb`. scripts/bare_check.sh --package proves that it installs,
# serves and is removed in a bare root.
set -euo pipefail
called_from=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."

output=$PWD/build/package
while [ $# -gt 0 ]; do
  case $1 in
    --output) output=${2:?--output needs a folder}; shift 2 ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "$0: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
case $output in /*) ;; *) output=$called_from/$output ;; esac

scripts/install_packages.sh package
mkdir -p build "$output"
# An existing build tree retains its options, so that running, testing and packaging do not rebuild each other.
if [ ! -f build/release/build.ninja ]; then
  cmake --preset release -DSIGHTLINE_TESTS=OFF >build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
fi
cmake --build --preset release --target sightline >&2
rm -f "$output"/sightline_*.deb
(cd build/release && cpack -B "$output" >"$output/cpack.log") || { cat "$output/cpack.log" >&2; exit 1; }
rm -rf "$output/_CPack_Packages"
ls "$output"/sightline_*.deb
python3 -B scripts/python_package.py "$output"
