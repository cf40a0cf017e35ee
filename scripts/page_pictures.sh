#!/bin/sh
# Takes pictures of docs/images anew. Those of docs/images/page come from a run of integration_page: those that the documents
# name, and for each size and theme a sheet of all views. A server of this build gives docs-page.png and town-normal.png.
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

"$binary" serve --listen 127.0.0.1:0 --preload house=demo:town >"$folder/first" 2>"$folder/log" &
server=$!
trap 'kill "$server"; rm -r "$folder"' EXIT
until grep -q . "$folder/first"; do sleep 0.1; done
url=$(sed 's/.* //' "$folder/first")
until curl -fsS -o /dev/null "$url/readyz" 2>/dev/null; do sleep 0.1; done
# The curl line of the README.
cd docs/images
eval "$(sed -n "s#^    curl -s -o house.png http://127.0.0.1:8080#curl -sS -o town-normal.png $url#p" ../../README.md)"
chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir="$folder/profile" --hide-scrollbars --virtual-time-budget=20000 \
  --window-size=1080,760 --screenshot="$folder/docs-page.png" "$url/docs" 2>>"$folder/log"
pngquant --force --speed 1 --output docs-page.png 256 "$folder/docs-page.png"
