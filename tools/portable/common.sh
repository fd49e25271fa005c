# Sourced by what starts programs on another machine: which of the libraries that drivers load, too, are
# ours. The system's is taken, but where it is missing or older: a driver may need a newer one than ours,
# and a process has one of each name.

# common_libraries FOLDER: of the folders FOLDER/NAME/NAME sets $own_libraries, the names that are taken from
# there, and $own_path, their folders for LD_LIBRARY_PATH.
common_libraries() {
  own_libraries="" own_path=""
  _cache=$({ /sbin/ldconfig -p || ldconfig -p; } 2>/dev/null)
  for _folder in "$1"/*; do
    [ -d "$_folder" ] || continue
    _name=${_folder##*/}
    _system=$(printf '%s\n' "$_cache" |
      sed -n "s/^[[:space:]]*$(printf '%s' "$_name" | sed 's/\./\\&/g') (libc6,\(x86-64\|AArch64\).*) => //p" | head -n 1)
    if [ -n "$_system" ]; then
      [ "$_name" = libstdc++.so.6 ] || continue
      [ "$(newest_symbols "$_system")" -lt "$(newest_symbols "$_folder/$_name")" ] || continue
      take_library "$1/libgcc_s.so.1" # they belong together
    fi
    take_library "$_folder"
  done
}

newest_symbols() { LC_ALL=C grep -ao 'GLIBCXX_3\.4\.[0-9]*' "$1" | cut -d. -f3 | sort -n | tail -n 1; }

take_library() {
  case ":$own_path:" in
    *":$1:"*) ;;
    *)
      own_libraries="$own_libraries${1##*/} "
      own_path=${own_path:+$own_path:}$1
      ;;
  esac
}
