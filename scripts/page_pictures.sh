#!/bin/sh
# Takes the pictures of docs/images/page anew: those that the documents name, from a run of integration_page.
#
#   scripts/page_pictures.sh [BINARY]     build/release/sightline by default; needs install_packages.sh browser
set -eu
cd "$(dirname "$0")/.."
binary=$(realpath "${1:-build/release/sightline}")
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
(cd tests/integration && SIGHTLINE_SOURCE="$(realpath ../..)" SIGHTLINE_PICTURES="$folder" python3 -B page_test.py "$binary" > "$folder/log") ||
  { tail -40 "$folder/log"; exit 1; }
grep -oh 'images/page/[^)]*\.png' README.md docs/*.md docs/*/*.md | sed 's#.*/##' | sort -u | while read -r name; do
  # 96 colours: the pictures are in the repository.
  pngquant --force --speed 1 --output "docs/images/page/$name" 96 "$folder/$name"
done
