# Sourced by harness/set_up and harness/demo. Of each step one line: what it is, how it ended, how long it took.

# What an exit status means, where it is not 0 (good): words by status, `failed` where there is none.
verdict_of=()

# step FILE TITLE COMMAND...: runs COMMAND, all output into FILE. Returns its status, with its last lines shown where
# that is not 0. On a terminal the line says meanwhile what COMMAND said last, and rewrites itself.
step() {
  local file=$1 title=$2 status=0 began=$SECONDS follower=
  shift 2
  printf '%-46s' "$title"
  if [ -t 1 ]; then
    follow "$file" "$title" &
    follower=$!
    trap 'kill "$follower" 2>/dev/null || true' EXIT
  fi
  "$@" >"$file" 2>&1 || status=$?
  if [ -n "$follower" ]; then
    kill "$follower" 2>/dev/null || true
    wait "$follower" 2>/dev/null || true
    trap - EXIT
    printf '\r\e[K%-46s' "$title"
  fi
  local verdict=good
  [ $status -eq 0 ] || verdict=${verdict_of[status]:-failed}
  local seconds=$((SECONDS - began))
  printf '%-10s%3d min %2d s\n' "$verdict" $((seconds / 60)) $((seconds % 60))
  [ $status -eq 0 ] || { tail -n 12 "$file" | sed 's/^/    /'; echo "    all of it: $file"; }
  return $status
}

# follow FILE TITLE: the last line of FILE behind the title, until it is killed or its shell has ended.
follow() {
  local began=$SECONDS rows columns line
  while kill -0 $$ 2>/dev/null; do
    read -r rows columns < <(stty size </dev/tty 2>/dev/null || echo 24 80)
    [ "$columns" -gt 0 ] || columns=80
    line=$(tail -n 1 "$1" 2>/dev/null | tr -cd '[:print:]' || true)
    line="$2  $((SECONDS - began)) s  $line"
    printf '\r\e[K%s' "${line:0:columns - 1}"
    sleep 0.5
  done
}
