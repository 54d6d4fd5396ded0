#!/usr/bin/env bash
# Installs Chromium, which the test of pages needs, by Debian's package; at no cost where there is one.
# Says so and ends with 3 where it cannot be had.
set -euo pipefail

for name in "${CHROMIUM:-}" chromium chromium-browser google-chrome; do
    if [[ -n $name ]] && command -v "$name" >/dev/null; then
        echo "$name is here already"
        exit 0
    fi
done

skip() {
    echo "skipped: $*" >&2
    exit 3
}
command -v apt-get >/dev/null || skip "no apt-get; install Chromium and name it in CHROMIUM"
((EUID == 0)) || skip "only root may install; apt-get install --no-install-recommends chromium"
apt-get update -qq >/dev/null 2>&1 || skip "no list of packages can be fetched"
apt-get install -y -qq --no-install-recommends chromium >/dev/null 2>&1 || skip "chromium cannot be fetched"
