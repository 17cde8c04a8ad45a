#include "mtled/bench/bench_features.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/interrupt.h"
#include "io/load_model.h"
#include "mtled/bench/bare_loop.h"
#include "mtled/bench/instruction_counter.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/recording.h"
#include "simulation/step.h"

namespace palpate::tools {
namespace {

constexpr double limit = 0.01;          // of a step: what a feature that is off may cost
constexpr double pressed_depth = 3e-3;  // m: under a third of the ball's radius

/// tick() and nothing around it, the tool held where it is. Loops of one body share tables and workspace, so that no
/// luck with the
/// places of pages and cache lines comes between them.
class TickLoop final : public FeatureLoop {
 public:
  struct Use {
    double friction = 0;
    Material material;
    int pulled = -1;  // skin vertex
  };
  TickLoop(const Model& model, Workspace& workspace, const State& start, const Use& use)
      : model_(model), workspace_(workspace), state_(start) {
    state_.live = loadedParameters(model);  // `start` may be another body's
    state_.live.friction = use.friction;
    setMaterial(model, 0, use.material, state_.live);
    command_.tool_target = start.tool_pose;
    command_.pull_vertex = use.pulled;
    if (use.pulled >= 0) command_.pull_target = model.skin.surface.vertices[use.pulled] + Vec3(0, 0, 2e-3);
  }
  double run(int ticks, const Meter& meter) override {
    tick(model_, state_, command_, workspace_);
    const double before = meter();
    for (int k = 0; k < ticks; ++k) tick(model_, state_, command_, workspace_);
    return meter() - before;
  }
  const State& state() const override { return state_; }

 private:
  const Model& model_;
  Workspace& workspace_;
  State state_;
  Command command_;
};

class HandWrittenLoop final : public FeatureLoop {
 public:
  HandWrittenLoop(const Model& model, Workspace& workspace, const State& start, BareLoop::Contact contact)
      : loop_(model, workspace, start, contact) {}
  double run(int ticks, const Meter& meter) override {
    loop_.tick();
    const double before = meter();
    for (int k = 0; k < ticks; ++k) loop_.tick();
    return meter() - before;
  }
  const State& state() const override { return loop_.state(); }

 private:
  BareLoop loop_;
};

/// The tissue's physics, looking at a meter when its second and its last tick begin.
class MeteredPhysics final : public Physics {
 public:
  explicit MeteredPhysics(const Model& model) : tissue_(model, 1) {}
  void expect(int ticks, const Meter& meter) {
    meter_ = &meter;
    last_ = ticks;
    ticks_ = 0;
  }
  double growth() const { return at_last_ - at_second_; }

  StepReport tick(const Command& command) override {
    ++ticks_;
    if (ticks_ == 2) at_second_ = (*meter_)();
    if (ticks_ == last_) at_last_ = (*meter_)();
    return tissue_.tick(command);
  }
  const State& state() const override { return tissue_.state(); }
  std::uint64_t stateHash() const override { return tissue_.stateHash(); }
  void reset() override { tissue_.reset(); }
  void restore(const State& past) override { tissue_.restore(past); }
  void setFriction(double coefficient) override { tissue_.setFriction(coefficient); }
  double setMaterial(int index, const Material& material) override { return tissue_.setMaterial(index, material); }

 private:
  TissuePhysics tissue_;
  const Meter* meter_ = nullptr;
  int last_ = 0, ticks_ = 0;
  double at_second_ = 0, at_last_ = 0;
};

/// Ticks in the real-time loop, as fast as it can, its force, snapshots, watchdog and statistics with them. The tool
/// trembles above the
/// tissue, so that every tick has something to record.
class RealTimeLoop final : public FeatureLoop {
 public:
  RealTimeLoop(const Model& model, bool record) : model_(model), physics_(model), record_(record) {}
  void prepare(int ticks) override {
    std::vector<Pose> poses(static_cast<std::size_t>(ticks + 2), model_.tool_start);
    for (std::size_t k = 0; k < poses.size(); ++k) poses[k].position.z() += 1e-6 * static_cast<double>(k % 8);
    SimulationLoopOptions options;
    options.as_fast_as_possible = true;
    options.tick_limit =
        ticks + 2;  // the first is not counted, and the last not to its end, where the loop sums up its run
    options.track = trackFromPoses(poses);
    options.record = record_;
    options.force_capacity = options.record_capacity = 1024;  // fresh memory would drive the body from the caches
    loop_ = std::make_unique<SimulationLoop>(model_, physics_, nullptr, options);
  }
  double run(int ticks, const Meter& meter) override {
    physics_.expect(ticks + 2, meter);
    loop_->run(clock_);
    return physics_.growth();
  }
  const State& state() const override { return physics_.state(); }

 private:
  const Model& model_;
  MeteredPhysics physics_;
  bool record_;
  MonotonicClock clock_;
  std::unique_ptr<SimulationLoop> loop_;
};

/// The ball pressed in, slowly, and held.
State pressed(const Model& model) {
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tool_target = model.tool_start;
  const double travel = model.first_contact_travel + pressed_depth;
  command.tool_target.position += travel * (model.tool_start.orientation * -Vec3::UnitZ());
  const int ticks = 1 + static_cast<int>(std::ceil(travel / model.scene.tool_max_speed * model.scene.rate_hz));
  StepReport report;
  for (int k = 0; k < ticks; ++k) report = tick(model, state, command, workspace);
  if (report.flags != 0 || report.contact_count == 0)
    throw std::runtime_error("the ball can't be pressed into the box");
  return state;
}

/// The same tissue let go: it swings, and nothing touches it.
State released(const Model& model, State state) {
  state.tool_pose = model.tool_start;
  state.tool_pose.position.z() += 0.05;
  state.contact = makeContactState(model.skin, model.scene.tool);
  return state;
}

Material ogdenLike(const Material& m) {
  const double mu[2] = {0.5 * m.shear_modulus, 0.5 * m.shear_modulus}, alpha[2] = {2, -2};
  return Material::ogden(mu, alpha, 2, 2 / m.bulk_modulus, m.density);
}

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Of this thread on its core: what other programs take is not counted.
double processorSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double measured(FeatureLoop& loop, int ticks, const Meter& meter) {
  loop.prepare(ticks);
  return loop.run(ticks, meter);
}

}  // namespace

FeatureBench::~FeatureBench() = default;

FeatureBench::FeatureBench(const BenchSize& size, const std::function<void(const std::string&, double)>& watch) {
  const auto load = [&](const char* what, double share, const std::function<void(Scene&)>& turn) {
    watch(what, share);
    Scene scene = benchScene(size);
    scene.formulation.node_patches = false;
    turn(scene);
    models_.push_back(std::make_unique<Model>(loadModel(scene)));
    // Equal steps: a feature that allows longer ones is not cheaper for that.
    models_.back()->dt = models_.front()->dt;
    models_.back()->substeps_per_tick = models_.front()->substeps_per_tick;
  };
  load("a box", 0, [](Scene&) {});
  load("with node patches", 0.3, [](Scene& s) { s.formulation.node_patches = true; });
  load("with adaptive points", 0.6, [](Scene& s) { s.quadrature.accuracy = 0.1, s.quadrature.max_depth = 1; });
  for (const auto& model : models_) workspaces_.push_back(std::make_unique<Workspace>(*model, 1));
  const Model& model = *models_[0];
  const State touching = pressed(model), free = released(model, touching);  // of all three: they have the same nodes
  const State at_rest = initialState(model);
  const Material& soft = model.materials[0];
  const auto ticks = [&](const State& start, const TickLoop::Use& use, std::size_t body = 0) {
    return std::make_shared<TickLoop>(*models_[body], *workspaces_[body], start, use);
  };
  const auto add = [&](const char* name, const char* with_text, const char* without_text, double bound,
                       std::shared_ptr<FeatureLoop> with, std::shared_ptr<FeatureLoop> without) {
    FeatureRow row;
    row.name = name;
    row.with = with_text;
    row.without = without_text;
    row.limit = bound;
    pairs_.push_back({row, std::move(with), std::move(without)});
  };
  const TickLoop::Use plain_use{0, soft};
  const auto bare = [&](const State& start, BareLoop::Contact contact) {
    return std::make_shared<HandWrittenLoop>(model, *workspaces_[0], start, contact);
  };
  const auto real_time = [&](bool record) { return std::make_shared<RealTimeLoop>(model, record); };
  add("contact", "ball 3 mm deep", "out of reach", NAN, ticks(touching, plain_use), ticks(free, plain_use));
  add("friction", "coefficient 0.5", "0, ball 3 mm deep", NAN, ticks(touching, {0.5, soft}),
      ticks(touching, plain_use));
  add("pull", "at one vertex", "none", NAN, ticks(free, {0, soft, 0}), ticks(free, plain_use));
  add("Ogden material", "two terms", "neo-Hookean", NAN, ticks(free, {0, ogdenLike(soft)}), ticks(free, plain_use));
  add("node patches", "volume of patches", "of points", NAN, ticks(free, plain_use, 1), ticks(free, plain_use));
  add("adaptive points", "tau 0.1, one division", "one a cell", NAN, ticks(free, plain_use, 2), ticks(free, plain_use));
  add("recording", "a change each tick", "none", NAN, real_time(true), real_time(false));
  add("snapshots, force, watchdog, statistics", "in the real-time loop", "ticks alone", NAN, real_time(false),
      ticks(at_rest, plain_use));

  add("contact, friction, pull, Ogden, node patches", "a tick with all of them off",
      "a loop and a kernel that know none", limit, ticks(free, plain_use), bare(free, BareLoop::Contact::None));
  add("friction", "contact with coefficient 0", "contact that knows no friction", limit, ticks(touching, plain_use),
      bare(touching, BareLoop::Contact::Frictionless));
  add("recording, and a viewer's overlays", "the real-time loop, nobody looking", "ticks alone", limit,
      real_time(false), ticks(at_rest, plain_use));
}

void timePairs(std::vector<FeaturePair>& pairs, double seconds, const std::function<void(double)>& watch) {
  constexpr double round_seconds = 0.002;
  constexpr int judged_rounds = 5;  // for one of the others: a hundredth is to be told apart
  flushDenormals();
  const InstructionCounter counter;
  const Meter seconds_of_core = processorSeconds,
              instructions = [&counter] { return static_cast<double>(counter.count()); };
  struct Times {
    int ticks = 1;
    std::vector<double> with, without, ratio;  // s
  };
  std::vector<Times> times(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const double tick = measured(*pairs[p].without, 1, seconds_of_core);
    times[p].ticks = std::max(1, static_cast<int>(std::ceil(round_seconds / tick)));
    if (counter.available())
      pairs[p].row.more_instructions =
          measured(*pairs[p].with, 1, instructions) / measured(*pairs[p].without, 1, instructions) - 1;
  }
  const auto rounds = std::max<std::size_t>(5, static_cast<std::size_t>(seconds / (5 * round_seconds)));
  for (std::size_t r = 0; r < rounds; ++r) {
    if (interrupted()) throw std::runtime_error("interrupted; nothing is written");
    watch(static_cast<double>(r) / static_cast<double>(rounds));
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const int repeats = std::isfinite(pairs[p].row.limit) ? judged_rounds : 1;
      for (int k = 0; k < repeats; ++k) {
        double took[2];
        for (const int turn : {0, 1}) {
          const int side = (turn + k + static_cast<int>(r)) % 2;
          took[side] = measured(side == 0 ? *pairs[p].with : *pairs[p].without, times[p].ticks, seconds_of_core);
        }
        times[p].with.push_back(took[0]);
        times[p].without.push_back(took[1]);
        times[p].ratio.push_back(took[0] / took[1]);
      }
    }
  }
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    FeatureRow& row = pairs[p].row;
    row.with_us = 1e6 * quantile(times[p].with, 0.5) / times[p].ticks;
    row.without_us = 1e6 * quantile(times[p].without, 0.5) / times[p].ticks;
    row.more = quantile(times[p].ratio, 0.5) - 1;
    // Of a median, as if the ratios were normally distributed.
    row.uncertainty = 1.2533 / 1.349 * (quantile(times[p].ratio, 0.75) - quantile(times[p].ratio, 0.25)) /
                      std::sqrt(static_cast<double>(times[p].ratio.size()));
  }
}

}  // namespace palpate::tools
