# The parts of a test run and the table of their minutes; sourced by tests/run and tests/long.
#   part NAME COMMAND...           runs the command in a shell of its own; the first part that fails ends the run
#   part_in_time NAME COMMAND...   the same, but with AXISCAL_MINUTES set it is ended, and not begun any more, when the run is that old. The
#                                  table says so: what was not run is not proven, and it is no failure either
# Names given on the command line choose parts; none chooses all but those that are declared with by_name=yes before them. The table is printed at the end, also of a run that failed.
chosen=("$@")
known=()
rows=()
began=$SECONDS

table() {
  local status=$? row name
  for name in "${chosen[@]}"; do
    if ((status == 0)) && [[ " ${known[*]} " != *" $name "* ]]; then
      echo "there is no part $name, only: ${known[*]}" >&2
      status=2
    fi
  done
  printf '\n%-12s %8s  %s\n' part minutes result
  for row in "${rows[@]}"; do printf '%s\n' "$row"; done
  printf '%-12s %8s\n' together "$(minutes $((SECONDS - began)))"
  exit "$status"
}
trap table EXIT
minutes() { printf '%d.%d' $(($1 / 60)) $((($1 % 60) / 6)); }

# Left of AXISCAL_MINUTES, in seconds; without it, as good as for ever.
seconds_left() { echo $((${AXISCAL_MINUTES:-10000} * 60 - (SECONDS - began))); }

part_in_time() {
  in_time=yes part "$@"
}

part() {
  local name=$1 start=$SECONDS status=0
  shift
  known+=("$name")
  if ((${#chosen[@]} > 0)) && [[ " ${chosen[*]} " != *" $name "* ]]; then return; fi
  if ((${#chosen[@]} == 0)) && [[ -n ${by_name:-} ]]; then return; fi
  printf '\n== %s\n' "$name"
  if [[ -n ${in_time:-} ]] && (($(seconds_left) <= 0)); then
    rows+=("$(printf '%-12s %8s  %s' "$name" - "NOT RUN: the $AXISCAL_MINUTES minutes of this run are over")")
    return
  fi
  # A function called in a condition would run on after a command that fails; one in a shell of its own does not.
  set +e
  if [[ -n ${in_time:-} ]]; then
    export -f $(compgen -A function)
    timeout --kill-after=30 "$(seconds_left)" bash -euo pipefail -c '"$@"' "$name" "$@"
  else
    (set -e; "$@")
  fi
  status=$?
  set -e
  local result="failed ($status)"
  if ((status == 0)); then result=passed; fi
  # What timeout says when it ended the part, and when it had to kill it.
  if [[ -n ${in_time:-} ]] && ((status == 124 || status == 137)) && (($(seconds_left) <= 0)); then
    status=0
    result="NOT ENDED: the $AXISCAL_MINUTES minutes of this run are over"
  fi
  rows+=("$(printf '%-12s %8s  %s' "$name" "$(minutes $((SECONDS - start)))" "$result")")
  ((status == 0)) || exit "$status"
}
