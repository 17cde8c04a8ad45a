#!/usr/bin/env bash
# One job file over the machines that GNU parallel knows, which share this folder:
#   tools/examples/batch_parallel.sh JOBS.jsonl OUT SHARDS [parallel's options, such as --sshloginfile machines]
# MTLED names the program; for machines with other processors, one that was built for all (tools/README.md).
set -euo pipefail
jobs=$(realpath "$1") out=$(realpath -m "$2") shards=$3
shift 3
mtled=$(realpath "${MTLED:-$(dirname "$0")/../../build/release/tools/mtled}")
# A shard with a failed job ends with 1, and the others go on; the merge tells of it.
parallel -j 1 "$@" "$mtled" batch "$jobs" --shard "{}/$shards" --out "$out/{}" ::: $(seq "$shards") || true
"$mtled" batch "$jobs" --merge $(seq -f "$out/%g" "$shards") --out "$out"
