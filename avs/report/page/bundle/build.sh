#!/usr/bin/env bash
# Builds ../static/splats.bundle.js from the packages that package.json pins, with their licences beside it. Needs npm;
# who uses the page needs neither npm nor this script, since the result is part of the repository.
set -euo pipefail
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp package.json package-lock.json entry.js "$work"
(cd "$work" && npm ci --ignore-scripts --no-audit --no-fund --silent && node node_modules/esbuild/install.js 2> /dev/null || true)
(cd "$work" && npx esbuild entry.js --bundle --minify --format=iife --global-name=avsSplats --target=es2020 \
    --legal-comments=none --outfile=splats.bundle.js \
    --banner:js='/* @mkkellogg/gaussian-splats-3d 0.4.7 and three 0.169.0, both MIT; see splats.licences.txt */')
{
    for package in @mkkellogg/gaussian-splats-3d three; do
        echo "$package"
        echo
        cat "$work/node_modules/$package/LICENSE"
        echo
    done
} > "$work/splats.licences.txt"
cp "$work/splats.bundle.js" "$work/splats.licences.txt" ../static/
sha256sum ../static/splats.bundle.js
