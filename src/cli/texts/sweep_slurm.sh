#!/usr/bin/env bash
# Hands {name} to Slurm: an array job, a task per shard, and the merge once all have ended well. A task that is requeued goes on where it was
# broken off; after a failure run this again: what is done is not done again.
set -euo pipefail
mkdir -p {log}
array=$(sbatch --parsable --job-name={name} --array=0-{last} --requeue --ntasks=1 --cpus-per-task=1 --mem=500M \
  --output={log}/%a.txt --wrap={shard})
merge=$(sbatch --parsable --job-name={name}-merge --dependency=afterok:"$array" --kill-on-invalid-dep=yes --ntasks=1 --mem=2G \
  --output={log}/merge.txt --wrap={merge})
echo "shards $array, merge $merge; the digest will be in "{log}/merge.txt
