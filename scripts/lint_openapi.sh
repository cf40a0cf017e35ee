#!/usr/bin/env bash
# Lints proto/openapi.json with redocly's recommended rules, by npm.
#
#   scripts/lint_openapi.sh
#
# Exit code 77 (skipped), with the reason, where npm or its registry is not there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
document=$PWD/proto/openapi.json
export REDOCLY_TELEMETRY=off REDOCLY_SUPPRESS_UPDATE_NOTICE=true NO_COLOR=1
linter=(npx --yes @redocly/cli@1.34.3)

if ! command -v npx >/dev/null; then
  echo "SKIPPED: npx is not installed"
  exit 77
fi
# Elsewhere, so that no package.json nearby has a say.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
if ! timeout 120 "${linter[@]}" --version >log 2>&1; then
  echo "SKIPPED: npm cannot get redocly: $(tail -n 1 log)"
  exit 77
fi
"${linter[@]}" lint "$document"
