#!/bin/sh
# Takes the pictures of docs/images/page anew, from a run of integration_page: those that the documents name, and for each
# size and theme a sheet of all views.
#
#   scripts/page_pictures.sh [BINARY]     build/release/sightline by default; needs install_packages.sh browser
set -eu
cd "$(dirname "$0")/.."
binary=$(realpath "${1:-build/release/sightline}")
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
(cd tests/integration && SIGHTLINE_SOURCE="$(realpath ../..)" SIGHTLINE_PICTURES="$folder" python3 -B page_test.py "$binary" > "$folder/log") ||
  { tail -40 "$folder/log"; exit 1; }
for look in 1280x720-light 1280x720-dark 390x844-light 390x844-dark; do
  node tests/integration/page_browser.mjs "$(dirname "$binary")/page/node_modules" "$(command -v chromium)" none "$folder" sheet "$folder"/*-"$look".png
  mv "$folder/sheet.png" "$folder/all-$look.png"
done
# Few colours: the pictures are in the repository.
grep -oh 'images/page/[^)]*\.png' README.md docs/*.md docs/*/*.md | sed 's#.*/##' | sort -u | while read -r name; do
  case $name in all-*) colours=256 ;; *) colours=96 ;; esac
  pngquant --force --speed 1 --output "docs/images/page/$name" $colours "$folder/$name"
done
