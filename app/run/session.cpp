#include "app/run/session.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <thread>

#include "app/run/run_export.h"
#include "app/run/run_files.h"
#include "app/trainer/feel_check.h"
#include "app/trainer/felt_layout.h"
#include "base/interrupt.h"
#include "base/key.h"
#include "base/number_text.h"
#include "contact/tool.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mechanics/materials/material_law.h"
#include "model/model_hash.h"
#include "realtime/device/open_device.h"
#include "setup/free_axes.h"
#include "setup/tick_cost.h"
#include "step/resolution.h"
#include "step/trust.h"

namespace palpate::app {

namespace {

constexpr double history_seconds = 8;  // of the plots
constexpr double default_offscreen_seconds = 4;
constexpr std::size_t most_samples = 150000;             // kept to be saved: five minutes at 500 Hz
constexpr std::size_t window_record_capacity = 1 << 14;  // half a minute, in which the window draws no picture
constexpr double notice_seconds = 6;  // of the run, that a notice stays when its cause does not come again

std::string fileName(const std::string& path) { return std::filesystem::path(path).filename().string(); }

bool isSubmitted(const Recording& recording) {
  return std::any_of(recording.changes.begin(), recording.changes.end(),
                     [](const TimedRequest& change) { return change.request.kind == Request::Kind::Submit; });
}

/// A picture that would give a search's answers away is refused, unless the run gives them itself.
void checkSearch(const Options& options, const Scene& scene, const std::optional<Recording>& replay) {
  const bool answered =
      options.answers || options.trainee || (replay ? isSubmitted(*replay) : !options.animation.empty());
  const bool inside = options.picture.showsInside() || options.dump_fields || exportsInside(options.export_file);
  if (!isTask(scene) || answered || !inside) return;
  throw InputError(scene.place,
                   "the scene is a search for lumps, and --cut, --ghost, --fields, a .pvd, stress, J, nodes and "
                   "points would show them",
                   replay ? "replay a recording of a search that was submitted, or leave them out"
                          : "add --answers, which shows them without a search, or leave them out");
}

/// What --replay names, and whether it may be shown as asked, as far as that can be checked without the model.
std::optional<Recording> recordingToReplay(const Options& options, const Scene& scene) {
  std::optional<Recording> recording;
  if (!options.replay.empty()) {
    recording = readRecording(options.replay);
    checkRate(*recording, scene.dynamics.rate_hz, options.replay);
    if (recording->ticks == 0)
      throw InputError({options.replay}, "the recording ended before its first tick",
                       "record a run anew with --record");
  }
  checkSearch(options, scene, recording);
  return recording;
}

/// How a set-up's progress is shown, and how it is interrupted.
class ShownProgress {
 public:
  ShownProgress(Log& log, const LoadProgress& progress)
      : watched_(isatty(STDERR_FILENO) != 0),
        warn([this, &log](const std::string& line) {
          if (watched_) std::cerr << "\r\033[K";  // over the progress
          log.warning(line);
        }),
        report([this, progress](const std::string& what, double fraction) {
          if (interrupted()) throw std::runtime_error("interrupted while the model was made");
          if (progress) progress(what, fraction);
          if (!watched_) return;
          std::string line = format("\r\033[K%3.0f %%  %s", 100 * fraction, what.c_str());
          if (line == shown_) return;
          std::cerr << line << std::flush;
          shown_ = std::move(line);
        }) {}
  ShownProgress(const ShownProgress&) = delete;
  ShownProgress& operator=(const ShownProgress&) = delete;
  void end() const {
    if (watched_) std::cerr << "\r\033[K" << std::flush;
  }

 private:
  const bool watched_;
  std::string shown_;

 public:
  const std::function<void(const std::string&)> warn;
  const Progress report;
};

std::string cacheFolder(bool use_cache) { return use_cache ? ModelCache::userFolder() : ""; }

/// @param timed  the run will keep to the clock
void describe(const Model& model, bool timed, Log& log) {
  log.detail(format("%s: %d nodes, %d integration points, %d x %.0f us per tick, ready in %.2f s",
                    model.scene.name.c_str(), model.nodeCount(), model.pointCount(), model.substeps_per_tick,
                    model.dt * 1e6, model.setup_seconds));
  if (model.addedMass() > 0.01)
    log.detail(format("mass scaling added %.3g %% to the mass: the same forces at rest, slower motion",
                      100 * model.addedMass()));
  if (model.scene.places.contains("dynamics.mass_scaling") && !(model.addedMass() > 0))
    log.detail("mass_scaling adds no mass here: it takes as many steps without");
  if (const std::string late = rateWarning(model); timed && !late.empty()) log.warning(late);
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  if (timed && cores > 0 && model.scene.dynamics.threads > cores)
    log.warning(
        format("%d physics threads on %d cores wait for each other: ticks will be late (dynamics.threads, "
               "--threads)",
               model.scene.dynamics.threads, cores));
}

Model buildModelOf(const Scene& scene, bool use_cache, bool timed, Log& log, const LoadProgress& progress) {
  const ShownProgress shown(log, progress);
  Model model = loadModel(scene, shown.report, ModelCache(cacheFolder(use_cache), shown.warn), shown.warn);
  shown.end();
  describe(model, timed, log);
  return model;
}

std::unique_ptr<FollowingTissue> buildFollowingOf(const Scene& scene, bool use_cache, bool timed, Log& log,
                                                  const LoadProgress& progress) {
  const ShownProgress shown(log, progress);
  const ModelCache cache(cacheFolder(use_cache), shown.warn);
  std::shared_ptr<PlaceSource> loaded = loadFollowing(scene, shown.report, cache, shown.warn);
  shown.end();
  const Places& places = loaded->places();
  double thinnest = places.sizes.fine;
  for (const BodyPlaces& body : places.body)
    for (const SpacingField::Refinement& ball : body.thin) thinnest = std::min(thinnest, ball.spacing);
  const std::string in_thin =
      thinnest < places.sizes.fine ? format(", %.1f mm where it is thin there", 1e3 * thinnest) : "";
  log.detail(format("the cloud follows the tool: nodes %.1f mm apart near it%s, %.1f mm elsewhere; %zu places",
                    1e3 * places.sizes.fine, in_thin.c_str(), 1e3 * places.sizes.coarse, places.centres.size()));
  describe(loaded->start()->model, timed, log);
  return std::make_unique<FollowingTissue>(std::move(loaded), scene.dynamics.threads, timed);
}

/// The ring's next entry if it is of a tick up to this one, else null; it waits in `next` until that is emptied.
template <class T>
const T* nextUpTo(SpscRing<T>& ring, std::optional<T>& next, std::int64_t tick) {
  if (T entry; !next && ring.pop(entry)) next = entry;
  return next && next->tick <= tick ? &*next : nullptr;
}

std::int64_t ticksIn(double seconds, double rate_hz) {
  return std::max<std::int64_t>(1, std::llround(seconds * rate_hz));
}

}  // namespace

/// Physics threads of a scene that says nothing: a core is left to the picture and to the places that a tool comes to.
/// (On two virtual cores a second thread gains a tenth of a tick, and places take two to twenty times as long.)
static int threadsInRealTime() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) - 1, 1, 2); }

/// Another probe in the scene's place. What is kept of a set-up depends on the radius.
static void overrideTool(Scene& scene, const ToolChoice& choice) {
  scene.tools[0].shape =
      ToolShape::of(choice.kind, choice.radius, std::max(scene.tools[0].shape.length, 3 * choice.radius));
  if (!scene.set_up_values.empty()) scene.set_up_values += "instead: tool.radius = " + shortest(choice.radius) + "\n";
  if (const std::optional<ToolFault> fault = toolType(choice.kind).fault(scene.tools[0].shape))
    throw InputError(scene.place, fault->problem, fault->advice);
}

Scene readScene(const Options& options, std::optional<int> layout) {
  std::vector<SceneChange> changes;
  if (layout) changes.push_back({"lumps.layout", std::to_string(*layout)});
  Scene scene = palpate::readScene(findScene(options.scene), changes);
  if (options.rate_hz) overrideRate(scene, *options.rate_hz);
  if (options.threads)
    scene.dynamics.threads = *options.threads;
  else if (!options.as_fast_as_possible && !scene.places.contains("dynamics.threads"))
    scene.dynamics.threads = threadsInRealTime();
  if (options.tool_choice) overrideTool(scene, *options.tool_choice);
  if ((options.trainee || options.check_lumps || options.answers) && !isTask(scene))
    throw InputError(scene.place, "there are no lumps to be found in this scene",
                     "add [[lump]] or [lumps], or take lump_liver");
  return scene;
}

bool isTask(const Scene& scene) {
  return scene.places.contains("lumps.count") || scene.places.contains("lump[0].radius");
}

TaskBody LoadedModel::body() const {
  if (!following) return {model};
  return {model, [source = following->source](const Vec3& point) {
            const auto place = source->at(placeAt(source->places(), point));
            return std::shared_ptr<const Model>(place, &place->model);
          }};
}

LoadedModel loadAsItIs(const Options& options, const Scene& scene, Log& log, const LoadProgress& progress) {
  const bool timed = !options.as_fast_as_possible && !options.check_lumps;
  LoadedModel loaded;
  if (scene.discretization.follow) {
    loaded.following = buildFollowingOf(scene, options.use_cache, timed, log, progress);
    const std::shared_ptr<ReadyPlace>& start = loaded.following->start;
    loaded.model = {start, &start->place.model};
  } else {
    loaded.model = std::make_shared<const Model>(buildModelOf(scene, options.use_cache, timed, log, progress));
  }
  return loaded;
}

LoadedModel loadedModelOf(const Options& options, Scene& scene, Log& log, const LoadProgress& progress) {
  LoadedModel loaded;
  const auto build = [&](const Scene& as_read) {
    loaded = loadAsItIs(options, as_read, log, progress);
    return loaded.body();
  };
  if (!isTask(scene)) {
    build(scene);
    return loaded;
  }
  TaskMaking making;
  making.build = build;
  making.progress = [&](double fraction) {
    if (progress) progress("feeling whether the lumps can be found", fraction);
  };
  making.read = [&](int layout) { return readScene(options, layout); };
  making.say = [&](const std::string& line) { log.info(line); };
  if (options.use_cache) making.cache_folder = ModelCache::userFolder();
  makeTask(scene, making);
  return loaded;
}

std::string sceneHash(const Options& options) { return hex16(fnv1a(readWholeFile(findScene(options.scene)))); }

void checkOptions(const Options& options) {
  const Scene scene = readScene(options);
  namedScript(options.tool_script, scene.tools[0].shape.radius);
  recordingToReplay(options, scene);
}

Session::Session(const Options& options, const Scene& scene, Log& log, const LoadProgress& progress)
    : options_(options),
      log_(log),
      scene_(scene),
      scene_hash_(app::sceneHash(options)),
      tool_script_(namedScript(options.tool_script, scene.tools[0].shape.radius)),
      replay_(recordingToReplay(options, scene)),
      results_(openResults(options, scene)),
      loaded_(loadedModelOf(options, scene_, log, progress)),
      model_(*loaded_.model),
      scene_materials_(model_.materials),
      materials_(scene_materials_),
      sent_before_(scene_materials_),
      friction_(scene_.tools[0].friction),
      forces_(history_seconds) {
  if (const std::string loose = looseWarning(model_); !loose.empty()) log_.warning(loose);
  if (const std::string layer = layerWarning(model_); !layer.empty()) log_.warning(layer);
  if (hasOneWay(scene_)) readCertificateOf(findScene(options.scene));
  const bool certified_small = certified_ && certified_->certificate().worst() < TrustLimits::expected_error;
  if (const std::string coarse = resolutionWarning(model_); !coarse.empty() && !certified_small) log_.warning(coarse);
  if (const double limit = scene_.force.rate_limit; limit > 0)
    log_.warning(
        format("the force that is shown rises by %.3g N/s at most (force.rate_limit): the tissue's may be "
               "another, in force.csv as raw",
               limit));
  if (isTask(scene_) && !options_.answers) beginSearch();
  SimulationLoopOptions loop_options;
  loop_options.as_fast_as_possible = options_.as_fast_as_possible;
  loop_options.start_paused = !options_.offscreen;  // the window resumes with its first picture
  chooseInput(loop_options);
  if (!options_.export_file.empty()) options_.snapshot_at = exportTimes(loop_options.tick_limit);
  for (const double time : options_.snapshot_at) {
    const std::int64_t tick = ticksIn(time, scene_.dynamics.rate_hz);
    if (!loop_options.pause_at.empty() && loop_options.pause_at.back() == tick)
      throw InputError({}, format("two pictures fall into one tick, that of %.6g s", time), "leave one out");
    loop_options.pause_at.push_back(tick);
  }

  if (!options_.record.empty()) {
    recording_ = Recording{scene_.name, modelHash(model_), scene_.dynamics.rate_hz, 0, {}};
    loop_options.record = true;
  } else if (!options_.offscreen && !options_.soak_minutes) {
    loop_options.record = true;  // so that the run can be kept once it turns out to be worth it
    loop_options.record_capacity = window_record_capacity;
  }

  if (loaded_.following) {
    physics_ = &loaded_.following->physics;
    loop_options.follower = &loaded_.following->follower;
    loop_options.track_has_places = replay_.has_value();
  } else {
    own_physics_ = std::make_unique<TissuePhysics>(model_, scene_.dynamics.threads);
    physics_ = own_physics_.get();
  }
  if (!options_.device.empty()) {
    coupled_tool_ = std::make_unique<CoupledTool>(model_);
    loop_options.device = coupled_tool_.get();
  }
  loop_ = std::make_unique<SimulationLoop>(model_, *physics_, &physics_->team(), std::move(loop_options));
  latest_ = &loop_->snapshots().latest();
  if (coupled_tool_) {
    device_ = std::make_unique<DeviceThread>(openDevice(options_.device, model_), *coupled_tool_, model_, *loop_);
    log_.info("device: " + device_->name());
    device_watch_.emplace(device_->name(), [this](bool warning, const std::string& text) {
      warning ? log_.warning("device: " + text) : log_.info("device: " + text);
    });
  }
}

Session::~Session() = default;

void Session::readCertificateOf(const std::string& scene_file) {
  std::string refused;
  std::optional<Certificate> read = readCertificate(certificateFile(scene_file), modelHash(model_), &refused);
  if (!refused.empty()) log_.info(refused);
  if (!read) return;
  log_.info(certifiedWay(*read));
  certified_.emplace(std::move(*read), touchRadius(scene_.tools[0].shape));
}

void Session::followScript(const ToolScript& script, SimulationLoopOptions& loop_options) {
  script_motion_.emplace(trajectoryOf(script, model_));
  loop_options.motion = &*script_motion_;
  loop_options.track_ticks = script_motion_->ticks();
  loop_options.keeps_settings = !options_.offscreen;  // what was tried by hand stays when the script is played again
  track_driver_ = ToolDriver::Script;
}

/// What moves the tool, and how long the run lasts.
void Session::chooseInput(SimulationLoopOptions& loop_options) {
  const double rate = scene_.dynamics.rate_hz;
  double track_seconds = 0;
  if (options_.soak_minutes) {
    soak_.emplace(model_, loaded_.following ? &loaded_.following->places() : nullptr, *options_.soak_minutes,
                  options_.rough, options_.seed.value_or(1));
    loop_options.motion = &soak_->motion();
    loop_options.tick_limit = ticksIn(60 * *options_.soak_minutes, rate);
    track_driver_ = ToolDriver::Script;
    script_ = options_.rough ? "rough soak" : "soak";
    track_over_ = false;
    return;
  }
  if (options_.trainee) {
    trainee_.emplace(model_, workingDepth(model_.scene), 1.1 * model_.scene.tools[0].shape.radius);
    loop_options.motion = &*trainee_;
    loop_options.track_ticks = loop_options.tick_limit = trainee_->ticks();
    track_driver_ = ToolDriver::Script;
    script_ = "trainee";
    track_over_ = false;
    return;
  }
  if (replay_) {
    checkRecordingFits(*replay_, model_, options_.replay);
    loop_options.track = std::move(replay_->changes);
    loop_options.track_ticks = replay_->ticks;
    track_seconds = static_cast<double>(replay_->ticks) / rate;
    track_driver_ = ToolDriver::Replay;
    script_ = fileName(options_.replay);
  } else if (tool_script_) {
    followScript(*tool_script_, loop_options);
    track_seconds = static_cast<double>(loop_options.track_ticks) / rate;
    script_ = tool_script_->name.empty() ? fileName(options_.tool_script) : tool_script_->name;
  } else if (!options_.device.empty()) {
    track_seconds = options_.seconds.value_or(default_offscreen_seconds);
  } else if (options_.offscreen) {
    const ToolScript script = indentScript(model_);
    followScript(script, loop_options);
    track_seconds = options_.seconds.value_or(
        std::max(default_offscreen_seconds, static_cast<double>(loop_options.track_ticks) / rate));
    // Longer than the script: the tool stays. Shorter: the run ends before the tool has gone all of its way.
    loop_options.track_ticks = std::max(loop_options.track_ticks, ticksIn(track_seconds, rate));
    script_ = script.name;
  }
  track_over_ = loop_options.track.empty() && loop_options.motion == nullptr;

  if (options_.seconds)
    loop_options.tick_limit = ticksIn(*options_.seconds, rate);
  else if (options_.offscreen)
    loop_options.tick_limit = ticksIn(track_seconds, rate);
}

/// When moments of a run of so many ticks are exported, s.
std::vector<double> Session::exportTimes(std::int64_t ticks) const {
  const double end = static_cast<double>(ticks) / scene_.dynamics.rate_hz;
  if (end > most_exported_seconds)
    throw InputError({}, format("--export keeps at most %.0f s, and this run takes %.1f", most_exported_seconds, end),
                     "give a smaller --seconds");
  std::vector<double> times;
  for (int k = 1; k / export_rate < end; ++k) times.push_back(k / export_rate);
  times.push_back(end);
  return times;
}

void Session::start() {
  if (results_) results_->begin(ForceColumns(model_, scene_.discretization.follow));
  loop_->start();
  if (device_) device_->start();
}

void Session::gather() {
  if (soak_ && !ended_) soak_->update(*loop_, *results_);  // which looks at snapshots, too
  const std::int64_t reset_tick = latest_->status.reset_tick;
  latest_ = &loop_->snapshots().latest();
  latest_ns_ = MonotonicClock().now();
  if (latest_->status.reset_tick != reset_tick) forces_.clear();
  takeForces(latest_->force.tick);
  while (const LogEvent* event = nextUpTo(loop_->log(), next_event_, latest_->status.ticks)) {
    takeEvent(*event);
    next_event_.reset();
  }
  followSearch();
  if (device_ && !ended_) device_watch_->update(device_->status(), 1e-9 * static_cast<double>(latest_ns_));
  if (notice_ && !notice_->frozen && forces_.lastTime() > notice_->time_s + notice_seconds) notice_.reset();
  changes_lost_ |= loop_->recorded().size() + 1 >= window_record_capacity;  // a full ring takes no more
  TimedRequest change;
  while (loop_->recorded().pop(change))
    if (recording_)
      recording_->changes.push_back(change);
    else
      changes_.add(change);
}

/// The forces of the ticks up to this one.
void Session::takeForces(std::int64_t until_tick) {
  while (const ForceSample* next = nextUpTo(loop_->forces(), next_force_, until_tick)) {
    const ForceSample& sample = *next;
    ToolReadings readings;
    if (model_.tools.several()) loop_->tools().pop(readings);
    if (sample.tick > latest_->status.reset_tick) forces_.add(sample, readings);
    if (searching()) felt_.push_back(sample);
    if (certified_) certified_->add(sample);
    if (results_ && !attempt([&] { results_->addForce(sample, readings); }))
      log_.error(failure_ + "; the run goes on without it");  // at once, not only at its end
    if (!options_.soak_minutes && !options_.offscreen) {      // else nobody is there to look at them
      presses_.add(sample);
      samples_.push_back(sample);
      if (samples_.size() > most_samples) samples_.pop_front();
    }
    next_force_.reset();
  }
}

/// Materials and regions have the scene's names for them, not their numbers.
std::string Session::withNames(std::string text, const LogEvent& event) const {
  const bool material = event.kind == LogEvent::Kind::MaterialSet || event.kind == LogEvent::Kind::MaterialRefused;
  if ((!material && event.kind != LogEvent::Kind::RegionMoved) || event.index < 0) return text;
  if (material && searching() && event.index > 0) return text;  // of a lump nothing is told
  const auto k = static_cast<std::size_t>(event.index);
  const std::string number = (material ? "material " : "region ") + std::to_string(event.index);
  std::string name;
  if (material && k < scene_.materials.size()) name = scene_.materials[k].name;
  if (!material && k < scene_.boundaries.size()) name = scene_.boundaries[k].name;
  if (const std::size_t at = text.find(number); at != std::string::npos && !name.empty())
    text.replace(at, number.size(), name);
  return text;
}

void Session::takeEvent(const LogEvent& event) {
  using Kind = LogEvent::Kind;
  if (searching()) said_.push_back(event);
  const std::string text = withNames(logText(event), event);
  const std::string shown = withNames(briefText(event), event);
  if (std::optional<Notice> notice = noticeOf(event); notice && !options_.rough) notice_ = std::move(notice);
  if (event.isFreeze()) {
    frozen_reason_ = text;
    if (soak_) loop_->quit();  // broken for good
    log_.add(LogLevel::Error, event.time_s, shown, text);
  } else if (!options_.export_file.empty() && event.kind == Kind::Resumed) {
    // After each moment that was taken.
  } else if (options_.rough && !event.isRestore()) {
    // Each second of a rough hand has its warnings and settings: the report has their sums.
  } else if (event.isWarning() || event.kind == Kind::MaterialRefused) {
    log_.add(LogLevel::Warning, event.time_s, shown, text);
  } else {
    log_.add(LogLevel::Info, event.time_s, shown, text);
  }
  switch (event.kind) {
    case Kind::TrackEnded:
      track_over_ = true;
      break;
    case Kind::FrictionSet:
      if (event.index == 0) friction_ = event.value;
      break;
    case Kind::MaterialRefused: {
      const auto m = static_cast<std::size_t>(event.index);
      materials_[m] = sent_before_[m];
      break;
    }
    case Kind::Undone:
      if (event.value > 0) notice_.reset();
      break;
    case Kind::Reset:
      notice_.reset();
      if (track_driver_ != ToolDriver::User) {  // the track starts over, with the scene's own values
        track_over_ = false;
        if (track_driver_ == ToolDriver::Replay || options_.offscreen) materials_ = scene_materials_;
      }
      break;
    default:
      break;
  }
}

void Session::send(const Request& request) {
  if (loop_->commands().push(request) || request.kind == Request::Kind::MoveTool) return;
  log_.warning("the loop did not take a request: it has not run for a long time");
}

void Session::setFriction(double coefficient) {
  friction_ = coefficient;
  send(Request::setFriction(coefficient));
}

void Session::setMaterial(int index, const Material& material) {
  const auto m = static_cast<std::size_t>(index);
  if (material == materials_[m]) return;
  sent_before_[m] = materials_[m];
  materials_[m] = material;
  send(Request::setMaterial(index, material));
}

void Session::giveWay(bool yes) {
  if (yes == gives_way_ || latest_->status.ticks == 0) return;  // before its first tick it has not been set up
  gives_way_ = yes;
  palpate::giveWay(loop_->summary().rt_setup, yes);
}

void Session::loadedSettings() {
  setFriction(scene_.tools[0].friction);
  for (std::size_t m = 0; m < materials_.size(); ++m) setMaterial(static_cast<int>(m), scene_materials_[m]);
}

ToolDriver Session::driver() const { return track_over_ ? ToolDriver::User : track_driver_; }

}  // namespace palpate::app
