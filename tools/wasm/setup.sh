#!/bin/bash
# tools/wasm/setup.sh: fetches and builds what compiles planish to WebAssembly, once, into $PLANISH_WASM
# (~/.cache/planish-wasm where unset): Debian 13's Emscripten and Binaryen, beside Debian 12's clang-19, and the
# libraries that planish uses, from the sources of Debian 12's packages. Nothing of Debian 13 is installed.
# PLANISH_DEBIAN and PLANISH_DEBIAN_SECURITY name other mirrors.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
case "${1:-}" in
  -h | --help)
    sed -n '2,5s/^# //p' "$0"
    exit 0
    ;;
esac
home=${PLANISH_WASM:-$HOME/.cache/planish-wasm}
mkdir -p "$home"
script=$root/tools/wasm/setup.sh
home=$(cd "$home" && pwd)
log=$home/setup.log
: >"$log"
. "$root/tools/packages.sh"
. "$root/tools/setup.sh"

# shellcheck disable=SC2086
require_packages $wasm_packages

# What decides the bytes that are made is named by its hash; the others only run it.
fetch_toolchain() {
  mkdir -p "$home/packages"
  cd "$home/packages"
  debian_line deb trixie >sources.list
  apt_apart "$PWD" update
  apt_apart "$PWD" download emscripten=3.1.69+dfsg-3 binaryen=120-4 node-acorn libc6 libstdc++6 libgcc-s1
  sha256sum -c - <<'SUMS'
d2ac788b952c56ab6736b4db2ac0825aa63cfb4c08b8abaefe19e324779d1b2d  emscripten_3.1.69+dfsg-3_all.deb
47be56009e56170f4338a0154fbff2028bd607bc3c8b6a5414658a985bef6470  binaryen_120-4_amd64.deb
SUMS
}

# unpack PACKAGE FOLDER [TAR ARGUMENT...]
unpack() {
  mkdir -p "$2"
  dpkg-deb --fsys-tarfile "$home/packages/$1"_*.deb | tar -x -C "$2" --exclude='./usr/share/doc' \
    --exclude='./usr/share/man' "${@:3}"
}

unpack_toolchain() {
  rm -rf "$home/emscripten" "$home/binaryen"
  # Nine tenths are libraries for threads, dynamic linking and link-time optimisation.
  unpack emscripten "$home/emscripten" --exclude='*/wasm32-emscripten/lto*' \
    --exclude='*/wasm32-emscripten/pic' --exclude='*-mt*.a' --exclude='*-ww*.a' --exclude='*asan*'
  dpkg-deb --fsys-tarfile "$home/packages"/emscripten_*.deb |
    tar -x -C "$home/emscripten" ./usr/share/doc/emscripten/copyright
  local share=$home/emscripten/usr/share/emscripten
  unpack node-acorn "$home/acorn"
  mkdir -p "$share/node_modules"
  cp -rL "$home/acorn/usr/share/nodejs/acorn" "$share/node_modules/"
  for package in binaryen libc6 libstdc++6 libgcc-s1; do
    unpack "$package" "$home/binaryen" --exclude='*/locale*' --exclude='*/gconv'
  done
  # It needs Debian 13's C library, which its own loader finds.
  mkdir -p "$home/binaryen/bin"
  local tool
  for tool in "$home"/binaryen/usr/bin/wasm*; do
    printf '#!/bin/sh\nexec "%s" --library-path "%s" "%s" "$@"\n' \
      "$home/binaryen/usr/lib64/ld-linux-x86-64.so.2" "$home/binaryen/usr/lib/x86_64-linux-gnu" \
      "$tool" >"$home/binaryen/bin/${tool##*/}"
    chmod +x "$home/binaryen/bin/${tool##*/}"
  done
  {
    echo "LLVM_ROOT = '/usr/lib/llvm-19/bin'"
    echo "BINARYEN_ROOT = '$home/binaryen'"
    echo "NODE_JS = '$(command -v node)'"
    echo "CACHE = '$share/cache'"
    echo "FROZEN_CACHE = True"
    if command -v ccache >/dev/null; then echo "COMPILER_WRAPPER = '$(command -v ccache)'"; fi
  } >"$share/.emscripten"
  rm -rf "$home/acorn" "$home/packages"
}

# Anew: another checkout may have made what is there, from its own folder.
build_libraries() {
  rm -rf "$home/libraries"
  cmake -S "$root/tools/wasm/libraries" -B "$home/libraries" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_TOOLCHAIN_FILE="$root/tools/wasm/toolchain.cmake" -DCMAKE_INSTALL_PREFIX="$home/prefix" \
    -DSOURCES="$home/sources"
  cmake --build "$home/libraries" --target install
}

fetch_and_unpack() { fetch_toolchain && unpack_toolchain; }
# The versions of the installed headers, so that both builds have the same library.
# shellcheck disable=SC2086
fetch_and_build() { fetch_sources "$home/sources" $wasm_sources && build_libraries; }
# step NAME STAMP COMMAND: unless it was done with the same stamp, of what it depends on.
step() {
  [ "$(cat "$home/$1.done" 2>/dev/null)" != "$2" ] || return 0
  rm -f "$home/$1.done"
  run_step "$1" "$3"
  echo "$2" >"$home/$1.done"
}
step Toolchain "$(sha256sum <"$script")" fetch_and_unpack
# shellcheck disable=SC2086
step Libraries "$({ cat "$script" "$root"/tools/wasm/libraries/* "$root/tools/wasm/toolchain.cmake"
  dpkg-query -W $wasm_sources; } | sha256sum)" fetch_and_build
