#!/usr/bin/env bash
# Installs what is missing, builds, runs every test, and closes with one line:
#
#   N passed, N failed[, N skipped]
#
# The exit code is 0 only if nothing failed and something ran.
#
#   scripts/test.sh [--quick | --sanitizers | --preset NAME...] [--only REGEX]
#
# Without a choice it tests the presets release (what users run) and asan (AddressSanitizer and
# UndefinedBehaviorSanitizer).
# --quick        only release
# --sanitizers   release, asan and tsan (ThreadSanitizer)
# --preset NAME  this preset of CMakePresets.json (may be repeated)
# --only REGEX   only the ctest entries whose name matches
#
# Tests that need the shared scenes search $SIGHTLINE_DATA (default: ../shared/data beside this
# checkout) and say SKIPPED where there are none.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

presets=()
default_presets=(release asan)
only=()
while [ $# -gt 0 ]; do
  case $1 in
    --preset) presets+=("${2:?--preset needs a name}"); shift 2 ;;
    --quick) default_presets=(release); shift ;;
    --sanitizers) default_presets=(release asan tsan); shift ;;
    --only) only=(--tests-regex "${2:?--only needs a regex}"); shift 2 ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "$0: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
[ ${#presets[@]} -gt 0 ] || presets=("${default_presets[@]}")

# Tests run in their own folders.
if [ -n "${SIGHTLINE_DATA:-}" ]; then
  SIGHTLINE_DATA=$(realpath -m "$SIGHTLINE_DATA")
  export SIGHTLINE_DATA
fi

scripts/install_packages.sh test
mkdir -p build
for preset in "${presets[@]}"; do
  case $preset in clang | fuzz) scripts/install_packages.sh lint; break ;; esac
done

# ThreadSanitizer of this compiler cannot live with every layout of the address space.
fixed_layout=()
if setarch "$(uname -m)" -R true 2>/dev/null; then fixed_layout=(setarch "$(uname -m)" -R); fi

reports=()
code=0
for preset in "${presets[@]}"; do
  echo "=== $preset: configure and build"
  cmake --preset "$preset" -DSIGHTLINE_TESTS=ON -DSIGHTLINE_WARNINGS_AS_ERRORS=ON \
    >"build/configure-$preset.log" 2>&1 ||
    { cat "build/configure-$preset.log"; echo "$0: cannot configure $preset" >&2; exit 1; }
  cmake --build --preset "$preset"
  echo "=== $preset: test"
  report=$PWD/build/$preset/test-report
  rm -rf "$report"
  mkdir -p "$report"
  wrapper=()
  [ "$preset" != tsan ] || wrapper=("${fixed_layout[@]}")
  # GoogleTest programs write their cases beside ctest's own report, so that cases are counted.
  GTEST_OUTPUT="xml:$report/cases/" "${wrapper[@]}" ctest --preset "$preset" --parallel "$(nproc)" \
    --timeout 1800 --no-tests=error --output-junit "$report/ctest.xml" "${only[@]}" || code=$?
  reports+=("$preset=$report")
done

python3 -B scripts/summarise_tests.py "${reports[@]}" || exit 1
exit "$code"
