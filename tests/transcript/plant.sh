# What the transcripts of one client alone share: a server with roles on, its machine, and who is who. Sourced, with `programs` set to the folder of
# axiscald and axiscal. Prints what it does; leaves $grpc, $http (addresses) and the tokens of cell, bob (technician) and ann (approver) in $work.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
example=$root/deploy/examples/integrex
work=$(mktemp -d "${TMPDIR:-/tmp}/axiscal-transcript.XXXXXX")
server_pid=
unset AXISCAL_SERVER AXISCAL_DB AXISCAL_TOKEN_FILE AXISCAL_USER

end() {
  [[ -z $server_pid ]] || { kill -TERM "$server_pid" && wait "$server_pid"; } 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT

fail() { printf 'transcript: %s\n' "$*" >&2; exit 1; }

# On the file, before anybody is asked who he is: an admin's work (docs/security.md).
axiscal=$programs/axiscal
cd "$work"
"$axiscal" --db plant.db machine add "$example/machine.json"
while read -r name role; do
  "$axiscal" --db plant.db admin principal add "$name"
  "$axiscal" --db plant.db admin role add "$name" "$role" --machine integrex-i200
  "$axiscal" --db plant.db admin token add "$name" -o "$name.token"
done <<<"cell cell
bob technician
ann approver" >/dev/null

: >server.out  # it is read before the server, in the background, may have opened it
"$programs/axiscald" --db plant.db --listen 127.0.0.1:0 --http 127.0.0.1:0 --ask-identity >server.out 2>server.log &
server_pid=$!
for tries in $(seq 400); do
  grpc=$(sed -n 's/^axiscald listens on //p' server.out)
  http=$(sed -n 's/^axiscald serves HTTP on //p' server.out)
  [[ -z $grpc || -z $http ]] || break
  kill -0 "$server_pid" 2>/dev/null || { cat server.log >&2; fail "the server did not start"; }
  sleep 0.05
done
