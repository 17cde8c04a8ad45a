#pragma once

#include <chrono>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "batch/batch_body.h"
#include "contact/rigid_bodies.h"
#include "contact/tool_set.h"
#include "io/csv_table.h"
#include "io/probes_file.h"
#include "io/result_csv.h"
#include "io/vtu_file.h"
#include "model/model.h"
#include "mtled/run/checkpoint.h"
#include "step/trust.h"

namespace palpate::tools {

/// What a solution has come to: an equilibrium or a tick.
struct SolvedRow {
  std::int64_t position = 0;    // where a resumed run goes on
  double time = 0;              // s
  std::optional<double> error;  // m, estimated, of an equilibrium
  int iterations = 0;
  double min_J = 1;
  int inverted_points = 0;
  ToolLoads loads;  // of the tools, without torques
  RigidLoads rigid;
  double largest = 0;  // m, the largest displacement so far; 0: not needed
  Doubt doubt = Doubt::None;
  double expected_error = 0;  // of the forces, as a share, of late
  int worst_point = -1;       // where the doubt is, as far as it is at a point of the tissue
};

/// Everything that a solution leaves in its folder: force.csv, probes.csv, solution.pvd with its VTU files,
/// checkpoint.bin and report.json.
class SolveResults {
 public:
  /// Begins them, or takes them up where the folder's checkpoint ends. Nothing of an earlier run is lost before
  /// all is accepted.
  /// @param end       s, the solution's last time
  /// @param identity  hash of model and load: what a checkpoint must have been made with
  /// Throws InputError for unusable probes or a checkpoint of something else, std::runtime_error where a file can't be
  /// written.
  SolveResults(const Model& model, const std::string& folder, double end, std::uint64_t identity, bool resume);

  const Checkpoint& checkpoint() const { return checkpoint_; }
  /// Throws InputError where the checkpoint remembers other than a solver does.
  void checkHistory(const AlignedVector<double>& solver) const;
  double expectedError() const { return expected_error_; }                   // of the last row
  double error() const { return last_row_.empty() ? 0 : last_row_.back(); }  // m, of the last equilibrium
  /// Of all rows (RunTrust); None: they can be trusted.
  Doubt doubt() const { return trust_.doubt(); }

  /// A row of force.csv, with a frame when its time has come and a checkpoint every ten seconds.
  /// @param tools  where the load has them: what is rigid may have stopped them before
  void add(const SolvedRow& solved, const BatchBody& body, const ToolsAt& tools);

  /// Remembers how far tools stand before where they should be. @param time  s
  void compareTools(double time, const ToolsAt& wanted, const ToolsAt& are);

  /// Probes, checkpoint and report of the last row. @param outcome  more members of the report
  void finish(nlohmann::json outcome);

  /// Says on standard output where they are.
  void print() const;

 private:
  using Clock = std::chrono::steady_clock;

  std::string forceFile() const { return folder_ + "/force.csv"; }
  std::string checkpointFile() const { return folder_ + "/checkpoint.bin"; }
  void readProbePoints();
  std::vector<std::string> columns() const;
  CsvTable takeUp(std::uint64_t identity, const std::vector<std::string>& columns);
  void compareForces(double time, const ToolLoads& loads);
  void remember(Doubt doubt, const std::vector<double>& row, const std::optional<Vec3>& place);
  void addFrame(double time, const BatchBody& body);
  nlohmann::json tools() const;
  void writeProbes() const;
  void save();

  const Model& model_;
  std::string folder_;
  double end_;
  Probes probes_;
  ShapeTable probe_shape_;
  std::unique_ptr<ResultCsv> force_;
  std::vector<double> last_row_;
  RunTrust trust_;
  double expected_error_ = 0;        // of the last row
  std::optional<Vec3> doubt_place_;  // of the gravest
  std::vector<Reaction> last_reactions_;
  std::optional<RigidLoads> last_rigid_;      // of this run
  std::vector<Vec3> last_load_forces_;        // N, of surface loads
  std::optional<ToolLoads> last_loads_;       // likewise
  double short_of_way_ = 0, short_from_ = 0;  // m, that a tool was stopped before, at most; s, from when on
  /// Force or pinch of a tool beyond its limit.
  struct BeyondLimit {
    int tool = 0;
    const char* key = "";
    double limit = 0, force = 0, first_time = 0;  // N, and s
  };
  std::vector<BeyondLimit> beyond_limit_;
  std::vector<PvdFrame> pvd_;
  Checkpoint checkpoint_;
  Clock::time_point saved_ = Clock::now();
};

}  // namespace palpate::tools
