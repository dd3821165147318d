# shellcheck shell=bash
# One line for each thing that is proved, for prove-deb, prove-slurm, prove-slurm-ranks and prove-container, which source this file and end with $status.

status=0

# check WHAT COMMAND...: says whether the command succeeded and how long it took; of one that failed, what it said last.
check() {
  local what=$1 began=$EPOCHREALTIME said
  shift
  if said=$("$@" 2>&1); then
    awk -v what="$what" -v from="$began" -v to="$EPOCHREALTIME" 'BEGIN { printf "ok    %7.2f s  %s\n", to - from, what }'
  else
    printf 'FAIL  %s\n%s\n' "$what" "$(tail -n 50 <<<"$said")"
    # shellcheck disable=SC2034  # of who sources this
    status=1
  fi
}

# says STATUS WORDS COMMAND...: the command ends with that status and these words.
says() {
  local wanted=$1 words=$2 ended=0 said
  shift 2
  said=$("$@" 2>&1) || ended=$?
  echo "$said"
  [[ $ended == "$wanted" && $said == *"$words"* ]]
}

# eventually COMMAND...: tries again for half a minute.
eventually() {
  local tries
  for ((tries = 0; tries < 600; tries++)); do
    if "$@" >/dev/null 2>&1; then return 0; fi
    sleep 0.05
  done
  "$@"
}
