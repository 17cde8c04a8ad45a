#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

struct BatchOptions {
  std::string jobs;                // file: JSON Lines (batch_job.h)
  std::string out;                 // folder; "": out/<file's name>
  int workers = 0;                 // jobs at once; 0: one per core
  std::string shard;               // "K/N": every N-th job from the K-th on; "": all
  std::vector<std::string> merge;  // folders of shards: nothing is run, their results become one
  bool use_cache = false;          // keep set-ups for the next start
};

/// Runs many scenes, one thread each, and leaves a folder for each job (force.csv, field, picture, result.json),
/// results.jsonl in the order of the jobs, and batch.json with the throughput. What a folder has done already stays and
/// is not run again; a job that fails is kept with its reason, and the others go on. SIGINT keeps what is done.
/// @return 0 all done, 1 some failed or were not run
/// Throws InputError for a file that can't be used; in a merge, for a job without result, with two, or of another file.
int batchCommand(const BatchOptions& options);

}  // namespace palpate::tools
