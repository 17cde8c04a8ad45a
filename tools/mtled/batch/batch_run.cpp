#include "mtled/batch/batch_run.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/npz_file.h"
#include "io/output_file.h"
#include "io/vtu_file.h"
#include "mtled/report/pictures.h"
#include "realtime/loop/cloud_follower.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/force_csv.h"
#include "step/resolution.h"
#include "step/trust.h"

namespace palpate::tools {
namespace {

constexpr double default_seconds = 4;  // as off-screen runs without a script

std::int64_t ticksOf(const BatchJob& job, const ScriptTrajectory& way, double rate_hz) {
  if (!job.seconds && !job.tool.empty()) return way.ticks();
  return std::max<std::int64_t>(1, std::llround(job.seconds.value_or(default_seconds) * rate_hz));
}

void writeField(const Model& model, const State& state, const std::string& folder, bool for_numpy) {
  std::vector<Vec3> u(state.u.size()), displacement(state.u.size(), Vec3::Zero());
  std::transform(state.u.begin(), state.u.end(), u.begin(), [](const Float4& v) { return toVec3(v); });
  const ShapeTable& shape = model.node_shape;
  for (std::size_t i = 0; i < u.size(); ++i)
    for (int k = shape.begin[i]; k < shape.begin[i + 1]; ++k) {
      const auto e = static_cast<std::size_t>(k);
      displacement[i] += shape.N[e] * u[static_cast<std::size_t>(shape.node[e])];
    }
  if (for_numpy) {
    const std::vector<NpzArray> arrays{npzVectors("X_m", model.X), npzVectors("displacement_m", displacement),
                                       npzCells("cells", model.cells)};
    return writeNpz(folder + "/field.npz", arrays);
  }
  const std::vector<VtuField> fields{vtuVectors("displacement_m", displacement)};
  writeVtu(folder + "/field.vtu", model.X, model.cells, fields);
}

/// One after another: a picture's context belongs to one thread.
void drawState(const Model& model, const State& state, const std::string& png) {
  static std::mutex one;
  const std::lock_guard lock(one);
  const std::unique_ptr<Pictures> pictures = openPictures();
  if (!pictures) throw std::runtime_error("picture.png " + withoutPictures());
  BodyPicture picture;
  picture.title = model.scene.name;
  picture.tool = state.tool[0].pose;
  pictures->write(png, picture, model, state.u, nullptr);
}

}  // namespace

BatchModels::BatchModels(const std::vector<BatchJob>& jobs, ModelCache cache) : cache_(std::move(cache)) {
  for (const BatchJob& job : jobs) ++shelves_[job.modelKey()].waiting;
}

std::shared_ptr<const BatchModel> BatchModels::take(const BatchJob& job) {
  const std::lock_guard lock(mutex_);
  Shelf& shelf = shelves_.at(job.modelKey());
  const bool last = --shelf.waiting == 0;
  if (!shelf.model) {
    const Progress progress = [](const std::string&, double) {
      if (interrupted()) throw Interrupted();
    };
    const Scene scene = readScene(findScene(job.scene), job.changes);
    auto made = std::make_shared<BatchModel>();
    if (scene.discretization.follow)
      made->following = loadFollowing(scene, progress, cache_);
    else
      made->stays = loadModel(scene, progress, cache_);
    shelf.model = std::move(made);
  }
  return last ? std::move(shelf.model) : shelf.model;
}

BatchResult runBatchJob(const BatchJob& job, const BatchModel& of, const std::string& folder) {
  const Model& model = of.model();
  const std::optional<ToolScript> script = namedScript(job.tool, model.scene.tools[0].shape.radius);
  ScriptTrajectory way = trajectoryOf(script ? *script : indentScript(model), model);
  const std::int64_t ticks = ticksOf(job, way, model.scene.dynamics.rate_hz);

  std::unique_ptr<FollowingTissue> following;
  if (of.following) following = std::make_unique<FollowingTissue>(of.following, 1, false);
  const auto own = following ? nullptr : std::make_unique<TissuePhysics>(model, 1);
  TissuePhysics& physics = following ? following->physics : *own;
  SimulationLoopOptions options;
  options.follower = following ? &following->follower : nullptr;
  options.force_capacity = 1;
  options.undo = false;
  SimulationLoop loop(model, physics, &physics.team(), options);
  BatchResult result;
  result.id = job.id;
  result.job = job.text;
  PendingFile pending(folder + "/force.csv");
  errno = 0;
  std::ofstream rows(pending.part(), std::ios::binary | std::ios::trunc);
  const ForceColumns columns(model, following != nullptr);
  rows << forceCsvHeader(columns);
  for (std::int64_t k = 0; k < ticks; ++k) {
    if (interrupted()) throw Interrupted();
    if (!script || k < way.ticks()) {  // after a script the tool stays where it is
      loop.hand().back().pose = way.next();
      loop.hand().publish();
      if (way.opening() >= 0) loop.toolHands().opening[0] = way.opening();
    }
    loop.advanceHere(1);
    const ForceSample sample = loop.force().sample;
    rows << forceCsvRow(sample, loop.toolReadings(), columns);
    result.peak_force = std::max(result.peak_force, sample.force_raw.norm());
    result.last_force = sample.force_raw.norm();
    result.last_depth = sample.depth_m;
    if (k + 1 == ticks && sample.frozen) result.reason = "the run ended frozen: its solution was lost again and again";
  }
  result.done = result.reason.empty();
  result.ticks = ticks;
  result.seconds = static_cast<double>(ticks) / model.scene.dynamics.rate_hz;
  result.state_hash = hex16(physics.stateHash());
  const Model& last = following ? physics.place()->place.model : model;
  RunTrust trust = loop.summary().trust;
  addLast(last, physics.state(), loop.snapshots().latest().report, result.seconds, trust);
  result.doubt = doubtName(trust.doubt());
  result.expected_error = trust.expectedError();
  rows.close();
  if (!rows) failWriting(folder + "/force.csv", errno);
  pending.takePlace();
  if (!job.field.empty()) writeField(last, physics.state(), folder, job.field == "npz");
  if (job.picture) drawState(last, physics.state(), folder + "/picture.png");
  return result;
}

}  // namespace palpate::tools
