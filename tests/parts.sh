# The parts of a test run and the table of their minutes; sourced by tests/run and tests/long.
#   part NAME COMMAND...   runs the command in a shell of its own; the first part that fails ends the run
# Names given on the command line choose parts; none chooses all. The table is printed at the end, also of a run that failed.
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

part() {
  local name=$1 start=$SECONDS status=0
  shift
  known+=("$name")
  if ((${#chosen[@]} > 0)) && [[ " ${chosen[*]} " != *" $name "* ]]; then return; fi
  printf '\n== %s\n' "$name"
  # A function called in a condition would run on after a command that fails; one in a shell of its own does not.
  set +e
  (set -e; "$@")
  status=$?
  set -e
  rows+=("$(printf '%-12s %8s  %s' "$name" "$(minutes $((SECONDS - start)))" "$( ((status == 0)) && echo passed || echo "failed ($status)")")")
  ((status == 0)) || exit "$status"
}
