# shellcheck shell=bash disable=SC2154  # $work and $job are the caller's
# A Slurm of two nodes on this machine, for prove-slurm, prove-slurm-ranks and prove-ondemand, which source this file in namespaces of their own (apart) and after checks.sh. Each node
# has a network, a name and a /tmp of its own, and a laptop beside them reaches n1 alone. Needs root, slurm-wlm, munge, openssh-server, iproute2.

# apart "$0" "$@": the script again, with processes, mounts, network and name that nobody else sees; whatever it starts ends with it.
apart() {
  if [[ ${ISOSTRATA_PROVE_APART:-} == "$1" ]]; then return; fi
  ((EUID == 0)) || { echo "${1##*/}: namespaces for a Slurm need root" >&2; exit 1; }
  ISOSTRATA_PROVE_APART=$1 exec unshare --mount --pid --net --uts --ipc --fork --kill-child --mount-proc "$@"
}

# needs PROGRAM PACKAGE, twice as many words for two: ends where one is not installed.
needs() {
  while (($#)); do
    command -v "$1" >/dev/null || { echo "${0##*/}: $1 is not installed (Debian: $2)" >&2; exit 1; }
    shift 2
  done
}

# on NODE COMMAND...: n1 is this shell's own.
on() {
  local node=$1
  shift
  if [[ $node == n1 ]]; then "$@"; else nsenter --target "${holder[$node]}" --mount --uts --net "$@"; fi
}

# exec_on NODE COMMAND...: in place of this shell, so that what runs beside others is the command itself.
exec_on() { exec nsenter --target "${holder[$1]}" --mount --uts --net "${@:2}"; }

# A network that ADDRESS of n1 and OTHER of NODE share.
join_to_n1() {
  local node=$1 address=$2 other=$3
  mkdir -p "$work/tmp-$node"
  unshare --uts --mount --net sleep infinity &
  holder[$node]=$!
  while [[ $(readlink "/proc/${holder[$node]}/ns/mnt") == "$(readlink /proc/self/ns/mnt)" ]]; do sleep 0.01; done
  on "$node" hostname "$node"
  on "$node" mount --bind "$work/tmp-$node" /tmp
  ip link add "$node" type veth peer name n1 netns "${holder[$node]}"
  ip address add "$address/24" dev "$node"
  ip link set "$node" up
  on "$node" ip address add "$other/24" dev n1
  on "$node" ip link set n1 up
  on "$node" ip link set lo up
}

# Everybody may go everywhere by ssh, with a key; the state folder is that of the proof.
ssh_everywhere() {
  local home
  home=$(getent passwd root | cut -d: -f6)
  mkdir -p "$home/.ssh" /run/sshd
  mount -t tmpfs -o mode=700 tmpfs "$home/.ssh"
  ssh-keygen -q -t ed25519 -N '' -f "$home/.ssh/id_ed25519"
  ssh-keygen -q -t ed25519 -N '' -f "$work/host_key"
  cp "$home/.ssh/id_ed25519.pub" "$home/.ssh/authorized_keys"
  printf 'StrictHostKeyChecking accept-new\nLogLevel ERROR\n' >"$home/.ssh/config"
  cat >"$work/sshd_config" <<CONF
HostKey $work/host_key
UsePAM no
PermitRootLogin yes
PasswordAuthentication no
PidFile none
SetEnv XDG_STATE_HOME=$work/home/.local/state
CONF
}

# two_nodes: $work is a folder of the caller's, not in /tmp; $work/home becomes the home of both nodes; $slurm_conf are lines that slurm.conf has besides.
slurm_conf=()
two_nodes() {
  declare -gA holder=()
  hostname n1
  printf '127.0.0.1 localhost\n10.99.0.1 n1\n10.99.0.2 n2\n10.98.0.1 login portal\n' >"$work/hosts"
  mount --bind "$work/hosts" /etc/hosts
  mkdir -p "$work/home" "$work/state" "$work/spool-n1" "$work/spool-n2"
  mkdir -p /etc/slurm
  mount -t tmpfs tmpfs /etc/slurm
  ssh_everywhere
  ip link set lo up
  join_to_n1 n2 10.99.0.1 10.99.0.2
  join_to_n1 laptop 10.98.0.1 10.98.0.2
  head -c 1024 /dev/urandom >"$work/munge.key"
  chmod 600 "$work/munge.key"
  chmod 755 "$work"
  munged --force --key-file="$work/munge.key" --socket="$work/munge" --pid-file="$work/munge.pid" --log-file="$work/munge.log" \
    --seed-file="$work/munge.seed"
  # Numbers of jobs that no earlier Slurm here had: its PMIx refuses a job of which a folder is left in /tmp.
  cat >/etc/slurm/slurm.conf <<CONF
ClusterName=proof
SlurmctldHost=n1(10.99.0.1)
SlurmUser=root
AuthInfo=socket=$work/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SlurmdParameters=config_overrides
KillWait=10
FirstJobId=$((1000 + EPOCHSECONDS % 1000000))
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd-%n.log
NodeName=n1 NodeAddr=10.99.0.1 CPUs=2 RealMemory=2000
NodeName=n2 NodeAddr=10.99.0.2 CPUs=2 RealMemory=2000
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  printf '%s\n' "${slurm_conf[@]}" >>/etc/slurm/slurm.conf
  slurmctld
  local node
  for node in n1 n2; do
    on "$node" slurmd -N "$node"
    on "$node" "$(command -v sshd)" -f "$work/sshd_config" # by its whole path, as it starts itself again
  done
  check "a Slurm of two nodes" eventually nodes_are_idle
}
nodes_are_idle() { [[ $(sinfo --noheader --format '%t %D') == 'idle 2' ]]; }

# state_is STATE: of $job.
state_is() { [[ $(scontrol show job "$job" | sed -nE 's/.*JobState=(\S+).*/\1/p') == "$1" ]]; }
