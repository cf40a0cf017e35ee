#!/usr/bin/env bash
# A file of rays through Dask over three servers that share a folder, while a worker and a server are killed. Closes with
# "1 passed, 0 failed" if the bytes equal those of one process, and the rate is at least 70% of the servers' own.
#
#   scripts/bulk_test.sh [--rays N] [--workers N] [--least PART] [--folder DIR]    (default: 1e7 rays, 2 workers, 0.7)
#   scripts/bulk_test.sh --rays 1e8                                                the long form: 10 GB of files
#
# tests/cluster/bulk.py says what is measured.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
case ${1:-} in -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;; esac
scripts/install_packages.sh run cluster
cmake --preset release >/dev/null
cmake --build --preset release --target sightline >&2
# Debian's numpy and Dask belong to Debian's Python.
exec /usr/bin/python3 -B tests/cluster/bulk.py build/release/sightline "$@"
