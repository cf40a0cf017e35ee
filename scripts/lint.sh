#!/usr/bin/env bash
# Style and lint. Changes nothing (but see --fix).
#
#   scripts/lint.sh [--all | --format | --fix] [FILE...]
#
# With no argument: format of every file, the room laws, openapi.json (scripts/lint_openapi.sh), and clang-tidy over the .cpp files that
# differ from main or include a header that does.
# --all     clang-tidy over every file that the build compiles, several in one run where they are one unit of the build
# --format  only the format check; exit code 77 (skipped) where clang-format 14 is not installed
# --fix     format every file in place
# FILE...   clang-tidy over these .cpp files
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mode=changed
files=()
for argument in "$@"; do
  case $argument in
    --all) mode=all ;;
    --format) mode=format ;;
    --fix) mode=fix ;;
    -h | --help) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "$0: unknown argument '$argument' (see --help)" >&2; exit 2 ;;
    *) mode=files; files+=("$argument") ;;
  esac
done

sources() { find core proto server tests -name '*.h' -o -name '*.cpp' | sort; }

# Each version formats differently: the format of this tree is that of Debian 12.
clang_format=$(command -v clang-format-14 || command -v clang-format || true)
has_format=no
if [ -n "$clang_format" ] && "$clang_format" --version | grep -q ' version 14\.'; then has_format=yes; fi
if [ "$mode" = format ] && [ $has_format = no ]; then
  echo "SKIPPED: clang-format 14 is not installed"
  exit 77
fi
if [ "$mode" != format ]; then scripts/install_packages.sh lint; fi

if [ "$mode" = fix ]; then
  [ $has_format = yes ] || { echo "$0: needs clang-format 14" >&2; exit 1; }
  sources | xargs "$clang_format" -i
  exit 0
fi
if [ $has_format = yes ]; then
  sources | xargs "$clang_format" --dry-run -Werror
  echo "format: $(sources | wc -l) files"
else
  echo "format: SKIPPED, clang-format 14 is not installed"
fi
[ "$mode" != format ] || exit 0

python3 -B tests/laws/room_laws.py
scripts/lint_openapi.sh || [ $? = 77 ]

# clang-tidy reads how each file is compiled from a build tree. Most of its time goes to headers, so --all reads files as the build
# compiles them, several in one unit; a file alone is read alone. Files that the build writes are not there.
tree=build/lint
together=OFF
if [ "$mode" = all ]; then tree=build/lint-all together=ON; fi
cmake --preset dev -B $tree -DSIGHTLINE_TOGETHER=$together >/dev/null
compiled() {
  python3 -c '
import json, os, sys
for entry in json.load(open(sys.argv[1] + "/compile_commands.json")):
    print(os.path.relpath(os.path.join(entry["directory"], entry["file"])))' $tree | { grep -Ev '^build/.*[.]cpp$' || true; } | sort -u
}
case $mode in
  all) mapfile -t files < <(compiled) ;;
  changed)
    base=$(git merge-base HEAD main 2>/dev/null || git rev-parse HEAD)
    differing() {
      { git diff --name-only --diff-filter=d "$base" -- "*.$1"; git ls-files --others --exclude-standard -- "*.$1"; }
    }
    mapfile -t files < <(comm -12 <(compiled) \
      <({ differing cpp; differing h | sed 's/.*/#include "&"/' |
          grep -rlFf /dev/stdin --include='*.cpp' core proto server tests || true; } | sort -u))
    ;;
esac
if [ ${#files[@]} -gt 0 ]; then
  # A unit of several files includes them: what bugprone-suspicious-include warns of.
  printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" \
    clang-tidy -p $tree --quiet --warnings-as-errors='*' --checks=-bugprone-suspicious-include 2> >(grep -v ' warnings\? generated' >&2)
fi
echo "clang-tidy: ${#files[@]} files"
