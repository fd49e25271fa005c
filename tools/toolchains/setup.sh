#!/bin/bash
# tools/toolchains/setup.sh windows|libcxx: builds what planish and its tests link there, once, into $PLANISH_WINDOWS or
# $PLANISH_LIBCXX (~/.cache/planish-windows, ~/.cache/planish-libcxx where unset): oneTBB, OpenSubdiv, meshoptimizer and
# zlib from the sources of Debian 12's packages, with the installed headers of the others. Installs the compiler, and Wine
# for Windows. PLANISH_DEBIAN and PLANISH_DEBIAN_SECURITY name other mirrors.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
case "${1:-}" in
  windows)
    home=${PLANISH_WINDOWS:-$HOME/.cache/planish-windows}
    toolchain=$root/tools/toolchains/windows-x86_64.cmake ;;
  libcxx)
    home=${PLANISH_LIBCXX:-$HOME/.cache/planish-libcxx}
    toolchain=$root/tools/toolchains/libcxx.cmake ;;
  *)
    sed -n '2,5s/^# //p' "$0"
    exit 0 ;;
esac
mkdir -p "$home"
script=$root/tools/toolchains/setup.sh
home=$(cd "$home" && pwd)
log=$home/setup.log
: >"$log"
. "$root/tools/packages.sh"
. "$root/tools/setup.sh"

compiler_packages=${1}_packages
# shellcheck disable=SC2086
require_packages ${!compiler_packages} $toolchain_packages

build_libraries() {
  rm -rf "$home/libraries" "$home/prefix"
  cmake -S "$root/tools/toolchains/libraries" -B "$home/libraries" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_TOOLCHAIN_FILE="$toolchain" -DCMAKE_INSTALL_PREFIX="$home/prefix" -DSOURCES="$home/sources"
  cmake --build "$home/libraries" --target install
}

# The versions of the installed headers, so that all builds have the same libraries.
# shellcheck disable=SC2086
fetch_and_build() { fetch_sources "$home/sources" $toolchain_sources && build_libraries; }
# Unless it was done with the same sources.
# shellcheck disable=SC2086
stamp=$({ cat "$script" "$root"/tools/toolchains/libraries/* "$root"/tools/wasm/libraries/* "$toolchain"
  dpkg-query -W $toolchain_sources; } | sha256sum)
if [ "$(cat "$home/done" 2>/dev/null)" != "$stamp" ]; then
  run_step Libraries fetch_and_build
  echo "$stamp" >"$home/done"
fi
