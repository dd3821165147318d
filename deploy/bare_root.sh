# shellcheck shell=bash
# Bare Debian root folders for prove-bare, prove-archive, prove-container and tests/bench/peers, which source this file. Needs root, debootstrap and a
# Debian machine, of whatever release. A folder gets nothing of this machine but the way to the network: its mirror, its name servers, the
# certificates added to it.

# make_bare_root DIR [SUITE]: what debootstrap calls minbase of bookworm or of another release, with /proc, /dev and /sys mounted.
make_bare_root() {
  local dir=$1 suite=${2:-bookworm} own from mirror script=/usr/share/debootstrap/scripts/${2:-bookworm}
  ((EUID == 0)) || { echo "making a root folder needs root" >&2; return 1; }
  command -v debootstrap >/dev/null || { echo "debootstrap is not installed" >&2; return 1; }
  [[ -e $script ]] || script=${script%/*}/sid  # debootstrap is older than the suite
  # shellcheck disable=SC2016  # apt-get's own variables
  from=$(apt-get indextargets --format '$(REPO_URI) $(CODENAME)' 'Created-By: Packages')
  own=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
  mirror=$(awk -v own="$own" '$2 == own { print $1; exit }' <<<"$from")
  [[ $mirror ]] || { echo "apt has no source of $own here, so no mirror of $suite is known" >&2; return 1; }
  debootstrap --variant=minbase "$suite" "$dir" "$mirror" "$script" >/dev/null
  # This machine's sources with the other suite's name; what is not released yet has neither updates nor security's.
  awk -v own="$own" -v suite="$suite" 'index($2, own) == 1 {
      part = substr($2, length(own) + 1)
      if (part == "" || suite ~ /^(bookworm|trixie)$/) print "deb", $1, suite part, "main"
    }' <<<"$from" | sort -u >"$dir/etc/apt/sources.list"
  apt-config dump | grep -E '^Acquire::(Check|http|Retries)' >"$dir/etc/apt/apt.conf.d/90network" || true
  cp -L /etc/resolv.conf /etc/hosts "$dir/etc/"
  mkdir -p "$dir/usr/local/share/ca-certificates"
  cp -L /usr/local/share/ca-certificates/*.crt "$dir/usr/local/share/ca-certificates/" 2>/dev/null || true
  mount_bare_root "$dir"
}

# keep_cache DIR FOLDER: what is compiled in the root is kept in FOLDER for another root of the same suite; says what is there already.
keep_cache() {
  mkdir -p "$1/root/.cache/ccache" "$2"
  mountpoint -q "$1/root/.cache/ccache" || mount --bind "$2" "$1/root/.cache/ccache"
  if [[ $(ls -A "$2") ]]; then
    echo "== compiler cache: warm, $(du -smx "$2" | cut -f1) MB in $2"
  else
    echo "== compiler cache: cold, kept in $2"
  fi
}

# clone_into_bare_root DIR REPOSITORY: what is committed, at /srv/isostrata; a clone that is there already is brought up to it.
clone_into_bare_root() {
  local clone=$1/srv/isostrata
  [[ -e $clone ]] || git clone --quiet --no-hardlinks "$2" "$clone"
  git -C "$clone" fetch --quiet "$2" HEAD
  git -C "$clone" reset --quiet --hard FETCH_HEAD
}

mount_bare_root() {
  mountpoint -q "$1/proc" || mount -t proc proc "$1/proc"
  mountpoint -q "$1/dev" || mount --bind /dev "$1/dev"
  mountpoint -q "$1/sys" || mount -t sysfs -o ro sysfs "$1/sys"  # OpenMPI 5 complains without it, and among what ranks say
}

# Unmounts everything below DIR, deepest first.
unmount_bare_root() {
  awk -v dir="$1/" 'index($2, dir) == 1 { print $2 }' /proc/self/mounts | sort -r | while read -r at; do umount "$(printf '%b' "$at")"; done
}

# in_bare_root DIR [--userspec=U:G] COMMAND...: nothing of the caller's environment, no terminal, no standard input.
in_bare_root() {
  local dir=$1 as=()
  shift
  if [[ $1 == --userspec=* ]]; then
    as=("$1")
    shift
  fi
  env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 CI=true \
    chroot "${as[@]}" "$dir" "$@" </dev/null
}

# seconds_since START: for reports, START from $EPOCHREALTIME.
seconds_since() { awk -v from="$1" -v to="$EPOCHREALTIME" 'BEGIN { printf "%.0f", to - from }'; }
