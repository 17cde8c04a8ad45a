#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/panels/force_history.h"
#include "app/panels/log.h"
#include "app/panels/panels.h"
#include "app/run/certified_watch.h"
#include "app/run/device_watch.h"
#include "app/run/kept_changes.h"
#include "app/run/options.h"
#include "app/run/result_folder.h"
#include "app/run/script_motion.h"
#include "app/run/soak.h"
#include "app/trainer/task_score.h"
#include "app/trainer/trainee.h"
#include "io/tool_script.h"
#include "model/model.h"
#include "realtime/device/device_thread.h"
#include "realtime/loop/cloud_follower.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/recording_file.h"
#include "realtime/recording/run_report.h"

namespace palpate::app {

/// How far the making of a model is, 0 .. 1; may throw to end it.
using LoadProgress = std::function<void(const std::string& stage, double fraction)>;

/// The scene that the options name, with what they say instead. Throws InputError.
/// @param layout  of the lumps at random, in place of the scene's
Scene readScene(const Options& options, std::optional<int> layout = {});

/// A scene's model; where its cloud follows the tool, that of the place at which it starts.
struct LoadedModel {
  std::shared_ptr<const Model> model;
  std::unique_ptr<FollowingTissue> following;  // null: the cloud stays

  TaskBody body() const;
};

/// The same of the scene as it is, whether its lumps can be felt or not.
LoadedModel loadAsItIs(const Options& options, const Scene& scene, Log& log, const LoadProgress& progress = {});

/// The scene's model, ready to run; a task's lumps can be felt in it (makeTask). Throws InputError.
/// @param scene  receives the layout of its lumps
LoadedModel loadedModelOf(const Options& options, Scene& scene, Log& log, const LoadProgress& progress = {});

/// Whether the scene hides lumps that are to be found.
bool isTask(const Scene& scene);

/// Of the bytes of the scene's file, as hexadecimal digits.
std::string sceneHash(const Options& options);

/// Reads scene and tool script, and throws InputError where they can't be used: before a running session is given up.
void checkOptions(const Options& options);

/// A run as window and off-screen program share it: scene, model and loop, and all that
/// the loop tells while it runs (forces, messages, changes to record).
/// All functions belong to the main thread; the loop has its own.
class Session {
 public:
  /// Reads the tool script or the recording, opens the result files, builds the model (seconds).
  /// Throws InputError for what can't be used, std::runtime_error for what can't be written.
  /// @param scene  as readScene(options) gives it
  Session(const Options& options, const Scene& scene, Log& log, const LoadProgress& progress = {});
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The result files take their places, and the loop runs. Throws std::runtime_error where they can't.
  void start();
  bool finished() const { return loop_->finished(); }

  /// Takes the newest tick and what the loop has told up to it, so that all that is shown is of one moment; what is
  /// newer waits for the next call. At least once a second.
  void gather();

  /// Ends the loop, takes the rest, and writes recording and forces. Once. What can't be written is told by failure().
  void finish();

  /// The tick that was taken last; valid until the next one is.
  const Snapshot& latest() const { return *latest_; }

  /// Hands a request to the loop; says so in the log where the loop does not take it.
  void send(const Request& request);
  void setFriction(double coefficient);
  void setMaterial(int index, const Material& material);

  /// Friction and materials as the scene has them.
  void loadedSettings();

  /// While nobody needs it, the loop's threads have no real-time priority.
  void giveWay(bool yes);

  /// What the run has to say to who holds the probe; empty: nothing.
  const std::optional<Notice>& notice() const { return notice_; }
  void dismissNotice() { notice_.reset(); }

  /// The search for the scene's lumps; null where it has none that are hidden.
  const TaskScore* task() const { return task_ ? &*task_ : nullptr; }
  /// The answers are in: lumps may be seen, and nothing more counts.
  bool revealed() const { return revealed_; }
  /// They are not yet: nothing may show the inside, and what is felt stays as the scene has it.
  bool searching() const { return task_ && !revealed_; }
  /// A mark, that it is taken back, that these are the answers. Nothing while a recording says that itself.
  void say(const Request& said);
  /// The lumps may be seen, and nobody has searched: of a run that shows what it hides at its end.
  void giveUpSearch() { revealed_ = task_.has_value(); }
  Conditions conditions() const;
  /// Who searched, when, where, under which conditions.
  SheetHead sheetHead(const std::string& trainee) const;
  /// Lumps were shown, by these or without a search (--answers).
  bool answersShown() const { return revealed_ || options_.answers; }
  const std::string& sceneHash() const { return scene_hash_; }

  /// The last minutes' forces (not in a soak), and the presses of the session.
  const std::deque<ForceSample>& samples() const { return samples_; }
  /// What the plots showed at an earlier tick, as far as it is kept.
  ForceHistory forcesUntil(const Snapshot& past) const;
  const PressCurves& presses() const { return presses_; }
  void clearPresses() { presses_.clear(); }

  /// The run from its start to the present tick, to be repeated bit for bit.
  /// Throws std::runtime_error where changes were lost, or came to more than are kept.
  Recording recordingSoFar();

  /// What the panels show besides the picture. Refers to this session and `snapshot`.
  PanelData panelData(const Snapshot& snapshot) const;
  ToolDriver driver() const;

  /// (after finish) All that report.json says.
  RunReport report();

  const Model& model() const { return model_; }
  const Options& options() const { return options_; }
  /// (after finish) Why the run counts as failed though its files are kept, a line for each reason; empty: it does not.
  const std::string& failure() const { return failure_; }
  /// Writes one of the run's outputs. Where that throws it is a reason of failure(), and the others are still written.
  /// @return  whether it was written
  bool attempt(const std::function<void()>& output);

  ResultFolder* results() { return results_ ? &*results_ : nullptr; }
  Log& log() { return log_; }

 private:
  void chooseInput(SimulationLoopOptions& loop_options);
  std::vector<double> exportTimes(std::int64_t ticks) const;
  void followScript(const ToolScript& script, SimulationLoopOptions& loop_options);
  void takeForces(std::int64_t until_tick);
  void fail(const std::string& reason);
  void takeEvent(const LogEvent& event);
  void readCertificateOf(const std::string& scene_file);
  void beginSearch();
  void followSearch();
  void takeSaid(const LogEvent& event);
  void submitForTrainee();
  std::string withNames(std::string text, const LogEvent& event) const;
  void finishDevice();
  void finishFollowing();
  TimingView timing(const Snapshot& snapshot) const;
  MaterialView materialView(std::size_t index) const;

  Options options_;
  Log& log_;
  Scene scene_;  // as loaded; the model's copy is the loop's to change
  std::string scene_hash_;
  std::optional<ToolScript> tool_script_;
  std::optional<Recording> replay_;
  std::optional<ResultFolder> results_;
  std::string failure_;
  const LoadedModel loaded_;
  const Model& model_;
  std::vector<Material> scene_materials_;
  std::vector<Material> materials_;    // (material_count) present
  std::vector<Material> sent_before_;  // (material_count) before the last request, should it be refused
  double friction_ = 0;
  std::optional<CertifiedWatch> certified_;  // of this very model
  std::optional<Soak> soak_;
  std::optional<ScriptMotion> script_motion_;
  std::optional<Trainee> trainee_;
  std::optional<TaskScore> task_;
  bool revealed_ = false, revealed_by_recording_ = false;
  std::vector<ForceSample> felt_;               // to be scored
  std::deque<LogEvent> said_;                   // likewise
  std::int64_t felt_until_ = 0;                 // tick of the last sample that was scored
  Conditions conditions_;                       // as far as they change during the search
  std::unique_ptr<TissuePhysics> own_physics_;  // where the cloud stays
  TissuePhysics* physics_ = nullptr;
  std::unique_ptr<CoupledTool> coupled_tool_;  // a haptic device's end in the loop, and its thread
  std::unique_ptr<SimulationLoop> loop_;
  std::unique_ptr<DeviceThread> device_;
  std::optional<DeviceWatch> device_watch_;
  const Snapshot* latest_ = nullptr;
  std::int64_t latest_ns_ = 0;             // CLOCK_MONOTONIC, when it was taken
  std::optional<ForceSample> next_force_;  // of a tick after it
  std::optional<LogEvent> next_event_;     // likewise
  std::optional<Recording> recording_;
  KeptChanges changes_;        // in the window
  bool changes_lost_ = false;  // likewise
  ForceHistory forces_;
  std::deque<ForceSample> samples_;
  PressCurves presses_;
  std::optional<Notice> notice_;
  std::string script_;  // name of tool script or recording
  ToolDriver track_driver_ = ToolDriver::User;
  bool track_over_ = true;
  std::string frozen_reason_;
  bool ended_ = false;
  bool gives_way_ = false;
};

/// Relative change of the organ's volume: sum_q V_q (J_q - 1) / sum_q V_q, with J_q = det F_q
/// and F_q = I + sum_i u_i (x) gradN_i(X_q) (X of paper eqs. 9, 31).
/// @param u  displacement parameters, m  (node_count)
double volumeChange(const Model& model, const Float4* u);

}  // namespace palpate::app
