# Sourced by tools/package and tools/gpu_check: the libraries that programs need on another machine.

# copy_libraries FOLDER FILE...: all that the files load but glibc, which is the system's.
copy_libraries() {
  local folder=$1
  shift
  mkdir -p "$folder"
  ldd "$@" | sed -nE 's/^\s*(\S+) => (\/\S+) .*/\1 \2/p' | sort -u |
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

# copy_licences FOLDER LIBRARY...: what Debian's packages say of the libraries.
copy_licences() {
  local folder=$1 owner
  shift
  mkdir -p "$folder"
  printf '*/%s\n' "${@##*/}" | xargs dpkg-query -S 2>/dev/null | cut -d: -f1 | sort -u |
    while read -r owner; do
      [ ! -f "/usr/share/doc/$owner/copyright" ] ||
        cp "/usr/share/doc/$owner/copyright" "$folder/copyright.$owner"
    done || true
}
