#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "io/load_model.h"
#include "mtled/batch/batch_job.h"

namespace palpate::tools {

/// What a job runs on: a model, or the places of a cloud that follows the tool.
struct BatchModel {
  std::optional<Model> stays;
  std::shared_ptr<PlaceSource> following;

  const Model& model() const { return following ? following->start()->model : *stays; }
};

/// The models of a batch, each made once and kept while jobs wait for it. Set-ups use all cores, so they are made one
/// after another. Any thread.
class BatchModels {
 public:
  /// @param jobs  those that will ask
  BatchModels(const std::vector<BatchJob>& jobs, ModelCache cache);

  /// Once for each job. Throws InputError for a scene that can't be used.
  std::shared_ptr<const BatchModel> take(const BatchJob& job);

 private:
  struct Shelf {
    int waiting = 0;  // jobs that have not asked yet
    std::shared_ptr<const BatchModel> model;
  };
  std::mutex mutex_;
  std::map<std::string, Shelf> shelves_;
  ModelCache cache_;
};

/// Runs a job on the calling thread as `palpate SCENE --offscreen` does, with the same bits, and leaves force.csv and,
/// where it is asked for, field.vtu in the folder. Throws what a job fails for; Interrupted where the program was.
BatchResult runBatchJob(const BatchJob& job, const BatchModel& of, const std::string& folder);

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace palpate::tools
