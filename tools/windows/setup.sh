#!/bin/bash
# tools/windows/setup.sh: builds what planish.exe and its tests link, once, into $PLANISH_WINDOWS
# (~/.cache/planish-windows where unset): oneTBB, OpenSubdiv, meshoptimizer and zlib from the sources of Debian 12's
# packages by its mingw-w64, with the installed headers of the others. Installs that compiler, and Wine.
# PLANISH_DEBIAN names another mirror.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
case "${1:-}" in
  -h | --help)
    sed -n '2,5s/^# //p' "$0"
    exit 0
    ;;
esac
home=${PLANISH_WINDOWS:-$HOME/.cache/planish-windows}
mkdir -p "$home/lists/partial"
script=$root/tools/windows/setup.sh
home=$(cd "$home" && pwd)
log=$home/setup.log
: >"$log"
. "$root/tools/packages.sh"
. "$root/tools/setup.sh"

# shellcheck disable=SC2086
require_packages $windows_packages

# The versions of the installed headers, so that both builds have the same libraries.
fetch_sources() {
  local sources=() package
  rm -rf "$home/sources"
  mkdir -p "$home/sources"
  cd "$home/sources"
  echo "deb-src ${PLANISH_DEBIAN:-http://deb.debian.org/debian} bookworm main" >"$home/sources.list"
  for package in $windows_sources; do
    sources+=("$(dpkg-query -W -f='${source:Package}=${source:Version}' "$package:$(dpkg --print-architecture)")")
  done
  local apt=(apt-get -o Dir::Etc::SourceList="$home/sources.list" -o Dir::Etc::SourceParts=- -o Dir::State::Lists="$home/lists"
    -o APT::Sandbox::User=root -o Acquire::Languages=none)
  "${apt[@]}" update
  "${apt[@]}" source --download-only "${sources[@]}"
  for package in *.dsc; do
    dpkg-source --no-check -x "$package" "${package%%_*}"
  done
  rm -f ./*.tar.* ./*.dsc
}

build_libraries() {
  rm -rf "$home/libraries" "$home/prefix"
  cmake -S "$root/tools/windows/libraries" -B "$home/libraries" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_TOOLCHAIN_FILE="$root/tools/toolchains/windows-x86_64.cmake" -DCMAKE_INSTALL_PREFIX="$home/prefix" \
    -DSOURCES="$home/sources"
  cmake --build "$home/libraries" --target install
}

fetch_and_build() { fetch_sources && build_libraries; }
# Unless it was done with the same sources.
# shellcheck disable=SC2086
stamp=$({ cat "$script" "$root"/tools/windows/libraries/* "$root"/tools/wasm/libraries/* \
  "$root/tools/toolchains/windows-x86_64.cmake"
  dpkg-query -W $windows_sources; } | sha256sum)
if [ "$(cat "$home/done" 2>/dev/null)" != "$stamp" ]; then
  run_step Libraries fetch_and_build
  echo "$stamp" >"$home/done"
fi
