#include "mtled/batch/batch_command.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

#include "base/build_info.h"
#include "base/interrupt.h"
#include "base/key.h"
#include "base/number_text.h"
#include "io/find_asset.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mtled/batch/batch_run.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Which jobs this run has: every `count`-th from `first` on.
struct Shard {
  std::size_t first = 0, count = 1;
};

Shard shardOf(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t slash = text.find('/');
  const auto number = [](std::string_view digits) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() && end == digits.data() + digits.size() ? value : 0;
  };
  const std::string_view all = text;
  const std::size_t k = slash == std::string::npos ? 0 : number(all.substr(0, slash));
  const std::size_t n = slash == std::string::npos ? 0 : number(all.substr(slash + 1));
  if (k < 1 || k > n) throw InputError({}, "--shard " + inQuotes(text) + " is no part", "write K/N with 1 <= K <= N");
  return {k - 1, n};
}

std::string lines(const std::vector<BatchResult>& results) {
  std::string all;
  for (const BatchResult& result : results) all += toLine(result) + "\n";
  return all;
}

/// The program and the files that a job's numbers come from: what it left before is good while it is the same.
std::string originOf(const BatchJob& job) {
  ByteKey key;
  for (const std::string& file : {findScene(job.scene), job.tool.empty() ? "" : findToolScript(job.tool)})
    if (!file.empty()) key.add(fnv1a(readWholeFile(file)));
  try {
    for (const std::string& file : readScene(findScene(job.scene), job.changes).files)
      key.add(fnv1a(readWholeFile(file)));
  } catch (const InputError&) {  // said when the job is run
  }
  return sourceIdentity() + " " + std::to_string(key.hash());
}

/// What the jobs share while they run.
class Batch {
 public:
  Batch(std::vector<BatchJob> jobs, std::string folder, const BatchOptions& options)
      : jobs_(std::move(jobs)), folder_(std::move(folder)), results_(jobs_.size()) {
    std::vector<BatchJob> left;
    for (std::size_t j = 0; j < jobs_.size(); ++j) {
      results_[j] = kept(jobs_[j]);
      if (results_[j]) continue;
      waiting_.push_back(j);
      left.push_back(jobs_[j]);
    }
    kept_ = jobs_.size() - waiting_.size();
    models_.emplace(left, ModelCache(options.use_cache ? ModelCache::userFolder() : "", warn));
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    const std::size_t wanted = options.workers > 0 ? static_cast<std::size_t>(options.workers) : cores;
    workers_ = std::max<std::size_t>(1, std::min(wanted, waiting_.size()));
  }

  void run() {
    std::vector<std::thread> threads;
    for (std::size_t t = 1; t < workers_; ++t) threads.emplace_back([this] { work(); });
    work();
    for (std::thread& thread : threads) thread.join();
  }

  /// Those that have one, in the order of the jobs.
  std::vector<BatchResult> results() const {
    std::vector<BatchResult> all;
    for (const auto& result : results_)
      if (result) all.push_back(*result);
    return all;
  }

  nlohmann::ordered_json report() const {
    const double wall = seconds();
    const auto failed = std::count_if(results_.begin(), results_.end(), [](const auto& r) { return r && !r->done; });
    return {
        {"program", buildInfo()},
        {"jobs", jobs_.size()},
        {"done", results().size() - static_cast<std::size_t>(failed)},
        {"failed", failed},
        {"kept_from_before", kept_},
        {"workers", workers_},
        {"wall_seconds", wall},
        {"physics_seconds", physics_seconds_},
        {"physics_per_wall_second_and_core", wall > 0 ? physics_seconds_ / wall / static_cast<double>(workers_) : 0.0}};
  }

 private:
  std::string folderOf(const BatchJob& job) const { return folder_ + "/" + job.id; }

  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  /// A result that an earlier run of this very program left for this very job.
  std::optional<BatchResult> kept(const BatchJob& job) const {
    const std::string file = folderOf(job) + "/result.json";
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) return {};
    std::vector<std::string> outputs{"force.csv"};
    if (!job.field.empty()) outputs.push_back("field." + job.field);
    if (job.picture) outputs.emplace_back("picture.png");
    try {
      const std::string text = readWholeFile(file);
      const std::size_t end = text.find('\n');
      BatchResult result = resultFromLine(text.substr(0, end), {file});
      const bool same = end != std::string::npos && text.substr(end + 1) == originOf(job) + "\n";
      const bool whole = std::all_of(outputs.begin(), outputs.end(), [&](const std::string& output) {
        return fs::is_regular_file(folderOf(job) + "/" + output, ignored);
      });
      if (same && whole && result.done && result.job == job.text) return result;
    } catch (const InputError&) {  // damaged: it is run again
    }
    return {};
  }

  void work() {
    for (std::size_t next = 0; !interrupted() && (next = next_++) < waiting_.size();) {
      const std::size_t j = waiting_[next];
      try {
        add(j, runOne(jobs_[j]));
      } catch (const Interrupted&) {
        return;
      }
    }
  }

  BatchResult runOne(const BatchJob& job) {
    BatchResult result;
    std::string origin;
    try {
      origin = originOf(job);
      fs::create_directories(folderOf(job));
      const std::shared_ptr<const BatchModel> model = models_->take(job);
      result = runBatchJob(job, *model, folderOf(job));
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      result.id = job.id;
      result.job = job.text;
      result.reason = error.what();
    }
    std::error_code ignored;
    try {
      if (fs::is_directory(folderOf(job), ignored))
        writeWholeFile(folderOf(job) + "/result.json", toLine(result) + "\n" + origin + "\n");
    } catch (const std::exception& error) {
      result.done = false;
      result.reason += (result.reason.empty() ? "" : "; ") + std::string(error.what());
    }
    return result;
  }

  void add(std::size_t j, const BatchResult& result) {
    const std::lock_guard lock(mutex_);
    if (!result.done) warn(result.id + ": " + result.reason);
    physics_seconds_ += result.seconds;
    failed_ += !result.done;
    results_[j] = result;
    ++run_;
    std::string detail = std::to_string(run_) + " of " + std::to_string(waiting_.size()) + " jobs";
    if (failed_ > 0) detail += ", " + std::to_string(failed_) + " failed";
    progress_.show(static_cast<double>(run_) / static_cast<double>(waiting_.size()), detail);
  }

  const std::vector<BatchJob> jobs_;
  const std::string folder_;
  std::vector<std::size_t> waiting_;  // into jobs_: those to be run
  std::size_t kept_ = 0, workers_ = 1;
  std::optional<BatchModels> models_;
  std::atomic<std::size_t> next_{0};  // into waiting_
  const Clock::time_point start_ = Clock::now();

  std::mutex mutex_;  // of what follows
  std::vector<std::optional<BatchResult>> results_;
  std::size_t run_ = 0, failed_ = 0;
  double physics_seconds_ = 0;
  ProgressLine progress_{"batch"};
};

int merge(const std::vector<BatchJob>& jobs, const BatchOptions& options, const std::string& folder) {
  std::map<std::string, BatchResult> found;
  for (const std::string& part : options.merge) {
    const std::string file = part + "/results.jsonl";
    std::istringstream text(readWholeFile(file));
    int number = 0;
    for (std::string line; std::getline(text, line);) {
      const SourceLocation place{file, ++number, 0};
      BatchResult result = resultFromLine(line, place);
      const auto job = std::find_if(jobs.begin(), jobs.end(), [&](const BatchJob& j) { return j.id == result.id; });
      if (job == jobs.end() || job->text != result.job)
        throw InputError(place, "the result of " + inQuotes(result.id) + " is of no job in " + options.jobs,
                         "merge what was run from this file");
      if (!found.emplace(result.id, result).second)
        throw InputError(place, "a second result of " + inQuotes(result.id), "leave one of the folders out");
    }
  }
  std::vector<BatchResult> results;
  for (const BatchJob& job : jobs) {
    const auto result = found.find(job.id);
    if (result == found.end())
      throw InputError({options.jobs}, "no folder has a result of " + inQuotes(job.id), "run its shard first");
    results.push_back(result->second);
  }
  fs::create_directories(folder);
  writeWholeFile(folder + "/results.jsonl", lines(results));
  const auto failed = std::count_if(results.begin(), results.end(), [](const BatchResult& r) { return !r.done; });
  std::cout << results.size() << " results, " << failed << " of failed jobs   " << folder << "/results.jsonl"
            << std::endl;
  return failed == 0 ? 0 : 1;
}

}  // namespace

int batchCommand(const BatchOptions& options) {
  const std::vector<BatchJob> all = readBatchJobs(options.jobs);
  const std::string folder = options.out.empty() ? "out/" + fs::path(options.jobs).stem().string() : options.out;
  if (!options.merge.empty()) return merge(all, options, folder);
  const Shard shard = shardOf(options.shard);
  std::vector<BatchJob> jobs;
  for (std::size_t j = shard.first; j < all.size(); j += shard.count) jobs.push_back(all[j]);

  makeFolder(folder, "choose another place with --out");
  Batch batch(jobs, folder, options);
  batch.run();
  const std::vector<BatchResult> results = batch.results();
  writeWholeFile(folder + "/results.jsonl", lines(results));
  const nlohmann::ordered_json report = batch.report();
  writeWholeFile(folder + "/batch.json", report.dump(2) + "\n");
  std::cout << report["done"] << " of " << jobs.size() << " jobs done, " << report["failed"] << " failed; "
            << format("%.3g", report["physics_per_wall_second_and_core"].get<double>())
            << " s of physics in a second of a core\nresults      " << folder << "/results.jsonl" << std::endl;
  const bool whole = results.size() == jobs.size();
  return whole && report["failed"] == 0 ? 0 : 1;
}

}  // namespace palpate::tools
