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
