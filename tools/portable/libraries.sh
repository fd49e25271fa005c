# Sourced by tools/package, tools/windows/package and tools/gpu_check: what programs need on another machine.

# copy_libraries FOLDER FILE...: all that the files load but glibc, which is the system's. $planish_ldd says what another
# processor's load.
copy_libraries() {
  local folder=$1 file
  shift
  mkdir -p "$folder"
  for file in "$@"; do ${planish_ldd:-ldd} "$file"; done | sed -nE 's/^\s*(\S+) => (\/\S+) .*/\1 \2/p' | sort -u |
    while read -r soname path; do
      case $soname in
        libc.so.* | libm.so.* | libdl.so.* | libpthread.so.* | librt.so.* | ld-linux*) ;;
        *) [ -e "$folder/$soname" ] || install -m 644 "$path" "$folder/$soname" ;;
      esac
    done
}

# set_common_apart FOLDER: moves those that drivers load, too, to common/NAME/NAME, for common.sh to choose.
set_common_apart() {
  local library name
  for library in "$1"/lib{stdc++,gcc_s,z,EGL,GLdispatch}.so.*; do
    name=${library##*/}
    [ -e "$library" ] || continue
    mkdir -p "$1/common/$name"
    mv "$library" "$1/common/$name/"
  done
  install -m 644 "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1/common.sh"
}

# make_runnable FOLDER: adds the libraries of FOLDER/bin's programs, which move to FOLDER/libexec; what starts
# them with the right ones takes their place.
make_runnable() {
  local program
  copy_libraries "$1/lib" "$1"/bin/*
  set_common_apart "$1/lib"
  mkdir -p "$1/libexec"
  for program in "$1"/bin/*; do
    mv "$program" "$1/libexec/"
    install -m 755 "$(dirname "${BASH_SOURCE[0]}")/launch" "$program"
  done
}

# owner_of NAME: Debian's package of a library for this machine's programs (there are others for 32 bits).
owner_of() { dpkg-query -S "*-linux-gnu/$1" 2>/dev/null | cut -d: -f1 | head -n 1; }

# copy_copyright FOLDER PACKAGE: what Debian says of its licence.
copy_copyright() {
  [ ! -f "/usr/share/doc/$2/copyright" ] || cp "/usr/share/doc/$2/copyright" "$1/copyright.$2"
}

# copy_licences FOLDER LIBRARY...: what Debian's packages say of the libraries, and the licences that they name
# by the place where Debian has them.
copy_licences() {
  local folder=$1 library text
  shift
  mkdir -p "$folder"
  for library in "$@"; do
    copy_copyright "$folder" "$(owner_of "${library##*/}")"
  done
  grep -ohE '/usr/share/common-licenses/[A-Za-z0-9.-]*[A-Za-z0-9]' "$folder"/copyright.* | sort -u |
    while read -r text; do
      [ ! -f "$text" ] || cp -L "$text" "$folder/${text##*/}.txt"
    done || true
}

# compiled_in NAME: the packages whose code is part of a component or program.
compiled_in() { sed -n "s/^$1 //p" "$(dirname "${BASH_SOURCE[0]}")/compiled_in"; }

# document_licences FOLDER SOURCE: into FOLDER/doc, the licences of all programs of FOLDER/libexec and libraries
# of FOLDER/lib, and LICENCES.txt, which says which is whose.
document_licences() {
  local folder=$1 source=$2 library package list
  local libraries=("$folder"/lib/*.so* "$folder"/lib/common/*/*)
  mkdir -p "$folder/doc"
  cp "$source/LICENSE" "$folder/doc/"
  list=$folder/doc/LICENCES.txt
  {
    echo "Licences of what lies in this folder; the texts are beside this file."
    echo
    echo "planish, libplanish: MIT (LICENSE), with code of"
    for package in $({ compiled_in command; compiled_in runtime; } | sort -u); do
      copy_copyright "$folder/doc" "$package"
      echo "  $package (copyright.$package)"
    done
    if [ -e "$folder/libexec/planish-reconstruct" ]; then
      echo
      echo "planish-reconstruct: GPL-3.0-or-later (GPL-3.txt), because CGAL is part of it. Its source is"
      echo "src/planish/reconstruct/cgal of planish and CGAL $(dpkg-query -W -f '${Version}' libcgal-dev 2>/dev/null)."
      echo "planish starts it as a program of its own. With code of"
      cp /usr/share/common-licenses/GPL-3 "$folder/doc/GPL-3.txt"
      for package in $(compiled_in planish-reconstruct); do
        copy_copyright "$folder/doc" "$package"
        echo "  $package (copyright.$package)"
      done
    fi
    echo
    echo "Libraries of Debian:"
    for library in "${libraries[@]}"; do
      case ${library##*/} in
        libplanish*) ;;
        *) echo "  ${library##*/} (copyright.$(owner_of "${library##*/}"))" ;;
      esac
    done
  } >"$list"
  copy_licences "$folder/doc" "${libraries[@]}"
}

# pack_for_npm FOLDER SYSTEM PROCESSOR PROGRAM [FACT]: FOLDER as the npm package that tools/wasm/js/cli.js takes PROGRAM from
# where it is installed beside planish. SYSTEM and PROCESSOR are node's names, FACT one more member of its package.json.
pack_for_npm() {
  local version name=planish-$2-$3
  version=$(sed -n 's/^project(planish VERSION \([0-9.]*\) .*/\1/p' "$root/CMakeLists.txt")
  cat >"$1/package.json" <<JSON
{
  "name": "$name",
  "version": "$version",
  "description": "The command of planish for this system, which npx planish takes",
  "license": "SEE LICENSE IN doc",
  "os": ["$2"],
  "cpu": ["$3"],
  "program": "$4"${5:+,
  $5}
}
JSON
  tar -C "$1" --sort=name --owner=0 --group=0 --numeric-owner --transform='s,^\.,package,' -czf "$out/$name-$version.tgz" .
  rm "$1/package.json"
}
