#!/usr/bin/env bash
# One job file as a Slurm array; submitted again, it runs only what is missing:
#   sbatch --array=1-8 tools/examples/batch_slurm.sh JOBS.jsonl OUT
#   build/release/tools/mtled batch JOBS.jsonl --merge OUT/{1..8} --out OUT
#SBATCH --job-name=palpate
#SBATCH --cpus-per-task=4
set -euo pipefail
mtled=${MTLED:-build/release/tools/mtled}
exec "$mtled" batch "$1" --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --out "$2/$SLURM_ARRAY_TASK_ID" \
  --jobs "${SLURM_CPUS_PER_TASK:-1}"
