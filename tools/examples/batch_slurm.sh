#!/usr/bin/env bash
# One job file as a Slurm array, then one result of all parts; submitted again, it runs only what is missing:
#   export MTLED=$HOME/palpate/bin/mtled    # installed where every node sees it (tools/README.md), or on the PATH
#   array=$(sbatch --parsable --array=1-8 tools/examples/batch_slurm.sh JOBS.jsonl OUT)
#   sbatch --dependency=afterany:"$array" tools/examples/batch_slurm.sh --merge JOBS.jsonl OUT
# A part takes one core, so it starts on any node; where nodes have more to give, say so: sbatch --cpus-per-task=4.
# afterany: a part with a failed job ends with code 1, and the merge tells which job it was.
#SBATCH --job-name=palpate
#SBATCH --cpus-per-task=1
set -euo pipefail
mtled=$(command -v "${MTLED:-mtled}") || { echo "no mtled: set MTLED to where it is installed" >&2; exit 2; }
usage="give JOBS.jsonl OUT, or --merge JOBS.jsonl OUT"
: "${1:?$usage}" "${2:?$usage}"
if [[ "$1" == --merge ]]; then
  exec "$mtled" batch "$2" --merge "$3"/part-* --out "$3"
fi
if [[ "${SLURM_ARRAY_TASK_MIN:-}" != 1 || "$SLURM_ARRAY_TASK_MAX" != "$SLURM_ARRAY_TASK_COUNT" ]]; then
  echo "submit it as a whole array, such as --array=1-8: a part's number and their count say what it runs" >&2
  exit 2
fi
exec "$mtled" batch "$1" --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --out "$2/part-$SLURM_ARRAY_TASK_ID" \
  --jobs "${SLURM_CPUS_PER_TASK:-1}"
