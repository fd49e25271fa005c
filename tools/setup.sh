# Sourced by tools/run, tools/test and tools/check: installing packages, and steps that are quiet
# unless they fail. Expects $log, the file that takes the output of every step.

timings=""

# show_count NAME: shows how far Ninja is, by the last line of the log, until it is killed.
show_count() {
  local count
  while sleep 1; do
    count=$(tail -n 1 "$log" | grep -o '^\[[0-9]*/[0-9]*\]') || continue
    printf '\r%-12s%s' "$1" "$count"
  done
}

# run_step NAME COMMAND...: runs it with its output in the log, says how long it took, and on a
# terminal how far it is; shows the end of the log and leaves with status 1 when it fails.
run_step() {
  local name=$1 began=$SECONDS status=0 counter=""
  shift
  printf '%-12s' "$name"
  echo "== $name: $*" >>"$log"
  if [ -t 1 ]; then
    show_count "$name" &
    counter=$!
  fi
  "$@" >>"$log" 2>&1 </dev/null || status=$?
  if [ -n "$counter" ]; then
    kill "$counter"
    wait "$counter" 2>/dev/null || true
    printf '\r\033[K%-12s' "$name"
  fi
  if [ "$status" != 0 ]; then
    echo "failed (status $status). The end of $log:"
    tail -n 40 "$log"
    exit 1
  fi
  echo "$((SECONDS - began)) s"
  timings="$timings, $(tr '[:upper:]' '[:lower:]' <<<"$name") $((SECONDS - began)) s"
}

# missing_packages PACKAGE...: those that are not installed. A PACKAGE may be names with | between, any of which does.
missing_packages() {
  local package
  for package in "$@"; do
    # shellcheck disable=SC2086
    dpkg-query -W -f='${Status}\n' ${package//|/ } 2>/dev/null | grep -q '^install ok installed$' ||
      printf '%s ' "$package"
  done
}

# known_packages PACKAGE...: the first name of each that apt knows; 1 where it knows none of them.
known_packages() {
  local package name
  for package in "$@"; do
    for name in ${package//|/ }; do
      apt-cache show "$name" >/dev/null 2>&1 && break
      name=""
    done
    [ -n "$name" ] || { echo "This system has no package ${package//|/ or }." >&2; return 1; }
    printf '%s ' "$name"
  done
}

apt_install() {
  local as_root="" names
  [ "$(id -u)" = 0 ] || as_root="sudo"
  $as_root apt-get update
  names=$(known_packages "$@") || return
  # Another may be installing something, as Ubuntu does by itself after it has started.
  # shellcheck disable=SC2086
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -y --no-install-recommends $names
}

# apt_apart FOLDER COMMAND...: apt-get by the package lists that FOLDER/sources.list names, apart from the system's.
apt_apart() {
  mkdir -p "$1/lists/partial" "$1/archives/partial"
  apt-get -o Dir::Etc::SourceList="$1/sources.list" -o Dir::Etc::SourceParts=- -o Dir::State::Lists="$1/lists" \
    -o Dir::Cache="$1" -o APT::Sandbox::User=root -o Acquire::Languages=none "${@:2}"
}

# debian_line TYPE SUITE: a line of sources.list. PLANISH_DEBIAN and PLANISH_DEBIAN_SECURITY name other mirrors.
debian_line() {
  local mirror=${PLANISH_DEBIAN:-http://deb.debian.org/debian}
  [ "${2%-security}" = "$2" ] || mirror=${PLANISH_DEBIAN_SECURITY:-http://deb.debian.org/debian-security}
  echo "$1 [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror $2 main"
}

# fetch_sources FOLDER PACKAGE...: unpacks there the sources of these packages of Debian 12, in the versions that are
# installed, each in a folder of its source's name. Updates that mend what was unsafe are in lists of their own, and not
# every mirror has their sources: then the release's do, which have the same headers.
fetch_sources() (
  local lists=$1/apt package source version
  rm -rf "$1"
  mkdir -p "$lists"
  { debian_line deb-src bookworm; debian_line deb-src bookworm-security; } >"$lists/sources.list"
  cd "$1" || return
  apt_apart "$lists" update || return
  for package in "${@:2}"; do
    package=$package:$(dpkg --print-architecture)
    source=$(dpkg-query -W -f='${source:Package}' "$package") || return
    version=$(dpkg-query -W -f='${source:Version}' "$package")
    apt_apart "$lists" source --download-only "$source=$version" ||
      apt_apart "$lists" source --download-only -t bookworm "$source" || return
    dpkg-source --no-check -x "$source"_*.dsc "$source" || return
  done
  rm -rf ./*.tar.* ./*.dsc "$lists"
)

# require_packages PACKAGE...: installs what is missing, or names it and leaves.
require_packages() {
  local missing
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "This system has no apt. It needs what these packages of Debian and Ubuntu hold:"
    echo "  " "$@"
    echo "Trying with what is here."
    return
  fi
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  # A password can be asked for only where somebody sits.
  if [ "$(id -u)" != 0 ] && ! { command -v sudo >/dev/null &&
                                { [ -t 0 ] && sudo -v || sudo -n true 2>/dev/null; }; }; then
    echo "Packages are missing, and this user may not install them. As root:"
    echo "  apt-get update && apt-get install --no-install-recommends $(sed 's/|[^ ]*//g' <<<"$missing")"
    exit 1
  fi
  # shellcheck disable=SC2086
  run_step Packages apt_install $missing
}

# require_foreign ARCHITECTURE PACKAGE...: the same of another processor's, which this system learns to know.
require_foreign() {
  local as_root="" architecture=$1
  shift
  [ "$(id -u)" = 0 ] || as_root="sudo"
  dpkg --print-foreign-architectures | grep -qx "$architecture" || $as_root dpkg --add-architecture "$architecture"
  require_packages "${@/%/:$architecture}"
}
