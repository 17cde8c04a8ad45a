#!/bin/sh
# What a run leaves where one of its files can't be written, its terminal is closed or nobody reads what it prints.
#   outputs.sh PALPATE WORK
set -eu
palpate=$1 work=$2
fail() { echo "$*" >&2; cat error.txt >&2; exit 1; }
rm -rf "$work"
mkdir -p "$work"
cd "$work"
scene=two_fingers  # few nodes

# Each output is tried on its own.
mkdir -p one/report.json
code=0
"$palpate" "$scene" --offscreen --fast --size 320x240 --seconds 0.1 --out one --record one.rec --export one.glb \
  > output.txt 2> error.txt || code=$?
[ "$code" = 1 ] || fail "an unwritten report: code $code"
grep -q "^palpate: can't write one/report.json: Is a directory" error.txt || fail "an unwritten report is not told"
for file in one/force.csv one/snapshot.png one/manifest.json one.rec one.glb; do
  [ -s "$file" ] || fail "$file is missing beside an unwritten report"
done

# Nobody reads what is printed.
{ "$palpate" "$scene" --offscreen --fast --size 320x240 --seconds 0.1 --out two --record two.rec 2> error.txt || true
} | true
for file in two/report.json two.rec; do [ -s "$file" ] || fail "$file is missing where nobody reads the output"; done

# A terminal is closed: its shell and the system both say so.
"$palpate" "$scene" --offscreen --size 320x240 --seconds 20 --out three --record three.rec \
  --animation three.png > output.txt 2> error.txt &
child=$!
until [ -s three/force.csv ] || ! kill -0 "$child" 2> /dev/null; do sleep 0.05; done
kill -HUP "$child" 2> /dev/null || true
kill -HUP "$child" 2> /dev/null || true
code=0
wait "$child" || code=$?
[ "$code" = 130 ] || fail "a closed terminal: code $code"
for file in three/report.json three.rec three.png; do
  [ -s "$file" ] || fail "$file is missing after the terminal was closed"
done
