# shellcheck shell=bash
# Bare Debian 12 root folders for prove-bare and prove-dockerfile, which source this file. Needs root, debootstrap and a Debian machine.
# A folder gets nothing of this machine but the way to the network: its mirror, its name servers, the certificates added to it.

# make_bare_root DIR: what debootstrap calls minbase, with /proc and /dev mounted.
make_bare_root() {
  local dir=$1 mirror
  ((EUID == 0)) || { echo "making a root folder needs root" >&2; return 1; }
  command -v debootstrap >/dev/null || { echo "debootstrap is not installed" >&2; return 1; }
  # shellcheck disable=SC2016  # apt-get's own variables
  local from='$(REPO_URI) $(RELEASE)'
  mirror=$(apt-get indextargets --format "$from" 'Created-By: Packages' | awk '$2 == "bookworm" { print $1; exit }')
  debootstrap --variant=minbase bookworm "$dir" ${mirror:+"$mirror"} >/dev/null
  apt-get indextargets --format "$from" 'Created-By: Packages' | awk '$2 ~ /^bookworm/ { print "deb", $1, $2, "main" }' |
    sort -u >"$dir/etc/apt/sources.list"
  apt-config dump | grep -E '^Acquire::(Check|http|Retries)' >"$dir/etc/apt/apt.conf.d/90network" || true
  cp -L /etc/resolv.conf /etc/hosts "$dir/etc/"
  mkdir -p "$dir/usr/local/share/ca-certificates"
  cp -L /usr/local/share/ca-certificates/*.crt "$dir/usr/local/share/ca-certificates/" 2>/dev/null || true
  mount_bare_root "$dir"
}

mount_bare_root() {
  mountpoint -q "$1/proc" || mount -t proc proc "$1/proc"
  mountpoint -q "$1/dev" || mount --bind /dev "$1/dev"
}

# Unmounts everything below DIR, deepest first.
unmount_bare_root() {
  awk -v dir="$1/" 'index($2, dir) == 1 { print $2 }' /proc/self/mounts | sort -r | while read -r at; do umount "$at"; done
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
