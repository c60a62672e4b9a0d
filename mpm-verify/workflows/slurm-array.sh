#!/usr/bin/env bash
#SBATCH --job-name=mpm-study
#SBATCH --array=1-64
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=1G
#SBATCH --time=02:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#
# A study as a Slurm job array, one share a task:
#
#   cargo build --release
#   sbatch mpm-verify/workflows/slurm-array.sh --no-times
#   target/release/mpm-verify merge reports/shares/* --out reports/accuracy     # when all are done
#
# Arguments are those of `mpm-verify study`. PROGRAM and WORK may be set. A task that is killed or put back into the queue goes
# on where it was. Without Slurm `mpm-verify/workflows/slurm-array.sh --local 64 ARGUMENTS` does all tasks one after the other.
set -euo pipefail

PROGRAM=${PROGRAM:-target/release/mpm-verify}
WORK=${WORK:-reports/shares}

share() { # number of the share, shares, arguments of the study
    local number=$1 count=$2
    shift 2
    "$PROGRAM" study "$@" --shard "$number/$count" --jobs "${SLURM_CPUS_PER_TASK:-1}" --resume --quiet --out "$WORK/$number"
}

if [[ ${1:-} == --local ]]; then
    count=$2
    shift 2
    failed=0
    for ((number = 1; number <= count; number++)); do
        # As Slurm does, a task that is killed is run again.
        for attempt in 1 2 3; do
            if share "$number" "$count" "$@"; then break; fi
            echo "share $number: attempt $attempt failed" >&2
            [[ $attempt == 3 ]] && failed=1
        done
    done
    exit $failed
fi
share "$SLURM_ARRAY_TASK_ID" "$SLURM_ARRAY_TASK_COUNT" "$@"
