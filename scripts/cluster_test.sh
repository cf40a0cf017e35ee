#!/usr/bin/env bash
# Three servers behind HAProxy share an object store (Ceph's radosgw), while servers are killed, slow, full, restarted and scaled, and the
# store is lost and returns.
# Judges each answer; closes with "1 passed, 0 failed" if none is wrong, lost, old or failed. All listen on loopback only.
#
#   scripts/cluster_test.sh [--minutes N] [--scenes N] [--kills N] [--seed N]    (default: 3 minutes, 300 scenes, 10 faults)
#   scripts/cluster_test.sh --minutes 30 --kills 100                             the long form
#   scripts/cluster_test.sh writers [--rounds N] [--folder]                      four servers change one scene at once
#   scripts/cluster_test.sh first [--rounds N] [--rays N]                        how soon a server answers from a scene that another has built
#   scripts/cluster_test.sh simulation                                           the simulation beside three servers
#
# The files of tests/cluster say what is judged. The first two forms go on without radosgw or HAProxy where they cannot be had, and say so.
# The others need both; writers --folder and first need neither.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
case ${1:-} in -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;; esac
scripts/install_packages.sh run cluster
cmake --preset release >/dev/null
cmake --build --preset release --target sightline >&2
case ${1:-} in
  writers) exec python3 -B tests/cluster/writers.py build/release/sightline "${@:2}" ;;
  # Debian's numpy belongs to Debian's Python.
  first) exec /usr/bin/python3 -B tests/cluster/first_answer.py build/release/sightline "${@:2}" ;;
  simulation) exec python3 -B tests/cluster/scaling_check.py build/release/sightline "${@:2}" ;;
esac
exec python3 -B tests/cluster/cluster.py build/release/sightline "$@"
