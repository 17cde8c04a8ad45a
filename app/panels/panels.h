#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/panels/force_history.h"
#include "app/panels/layout.h"
#include "app/panels/log.h"
#include "app/panels/notice.h"
#include "app/panels/press_curves.h"
#include "app/panels/reference_curve.h"
#include "app/panels/tool_choice.h"
#include "app/panels/user_action.h"
#include "app/render/colour_map.h"
#include "app/render/theme.h"
#include "app/render/view.h"
#include "app/trainer/task_score.h"
#include "model/body.h"
#include "realtime/channels/force_output.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// One thing that the loop asked of the system and what came of it.
struct SetupLine {
  std::string name;  // "scheduling", "memory lock", ...
  std::string text;  // "SCHED_FIFO 80", or why not
  bool done = false;
};

/// How long ticks took, for the Timing panel. Times in us.
struct TimingView {
  double rate_hz = 0;
  int threads = 1;
  double step_p50 = 0, step_p99 = 0, step_p999 = 0, step_max = 0;
  double late_p99 = 0, late_max = 0;  // waking up after the deadline
  std::vector<float> histogram;       // ticks per bin, equal bins from 0 to histogram_end
  double histogram_end = 1;           // us
  std::vector<SetupLine> setup;
};

/// What moves the tool.
enum class ToolDriver { User, Script, Replay };

/// A material as it is now, and as far as it can be changed while it runs: the time step bounds how stiff it may get.
struct MaterialView {
  Material material;               // at present
  double stiffness = 1;            // times that of the scene
  std::string name{};              // "" where the scene gives none
  double most_stiffness = 1;       // likewise
  bool elastic_constants = false;  // it has Young's modulus and Poisson's ratio, which these bound, each by itself
  double scene_young = 0, most_young = 0, most_poisson = 0;  // Pa, 1
  int mixtures = 0;  // > 0: an image mixes it into so many materials, which stay as they are while it runs
};

/// The last minute, to look back at.
struct TimelineView {
  double begin_s = 0, now_s = 0, shown_s = 0;  // of the run
  bool past = false;                           // an earlier picture is shown
};

/// What the panels show: gathered afresh for each picture, never kept.
struct PanelData {
  const Body& model;
  const Snapshot& snapshot;
  const ForceHistory& forces;
  std::span<const LogLine> log;
  TimingView timing{};
  ForceReading force{};  // the snapshot's, and how old it is
  std::vector<MaterialView> materials{};
  double friction = 0;         // Coulomb coefficient at present
  std::string certified{};     // how exact the force was found to be (io/certificate.h); empty: not known
  double certified_error = 0;  // as a share; 0: not known
  std::string input_note{};    // why material and friction can't be changed now; empty: they can
  ColourScale colour_scale{};  // of the picture behind the panels
  ToolDriver driver = ToolDriver::User;
  std::string script{};                       // name of the script or recording; empty: none at hand
  std::string frozen_reason{};                // what the watchdog saw, and where; used while frozen
  double frames_per_second = 0;               // 0: not shown
  std::optional<Notice> notice{};             // what has to be said
  const PressCurves* presses = nullptr;       // of the session; null: none are kept
  const TaskScore* task = nullptr;            // the search for lumps; null: there is none
  bool revealed = false;                      // it is over
  bool timeless = false;                      // nothing that the clock says of this machine
  bool out_of_view = false;                   // nothing of the organ is seen
  bool attracts = false;                      // the demo plays by itself
  double pull_N = -1;                         // of the spring under the pointer; < 0: nothing is pulled
  bool hand_on_skin = false;                  // it glides
  bool hand_presses = false;                  // at a depth of its own
  double widest_jaws_m = 0;                   // that it can open; 0: it holds none
  std::optional<TimelineView> timeline{};     // null: nothing is kept
  const ForceHistory* past_forces = nullptr;  // of the earlier moment that is looked at; null: of the present
  std::string conditions{};                   // of the search
  std::span<const std::string> scenes{};      // to open: the program's own, then those of late

  /// Nothing may show the inside, or change what is felt.
  bool searching() const { return task != nullptr && !revealed; }
};

/// What the user sets in the panels and keeps from frame to frame.
struct PanelState {
  bool panels_shown = true;
  bool engineer = false;  // also what only those who build scenes and programs need
  bool help_shown = false;
  double tool_speed_mm_s = 20;  // of the tool when moved by keys or buttons
  double press_mm = 0;          // that "Press" presses; 0: not set yet
  bool glide = true;            // the probe glides over the skin; else it is moved freely
  bool demo = false;            // full picture, large force, no panels
  bool open_shown = false;      // the dialog that opens a file
  OpenKind open_kind = OpenKind::Scene;
  bool timeline_shown = false;  // the last minute can be looked at
  bool timeline_plays = false;  // it goes by
  std::string at_stake;         // what leaving would lose, while that is asked; else empty
  std::string problem;          // why something could not be opened, until it is closed
  std::string path;             // typed there
  ToolChoice tool;              // as set in the panel, until it is applied
  bool tool_edited = false;
  int hardness = 2;                         // of the next mark
  std::string trainee;                      // who searches; may be empty
  bool hertz = false;                       // the closed form lies over the presses
  std::optional<ReferenceCurve> reference;  // of a file, likewise
};

/// Draws all panels of one frame between ImGui::NewFrame and ImGui::Render; the same
/// in the window and off-screen. Settings of the picture are edited in `view`. @return what was clicked
UserActions drawPanels(const Theme& theme, const PanelData& data, const Layout& layout, PanelState& state, View& view);

/// What stands beside a force that is not the present one: "stale, 23 ms old", "paused"; empty: it is.
std::string staleMark(const ForceReading& force, const LoopStatus& status);

// The parts, each in a file of its own.
void drawBar(const Theme&, const PanelData&, const Rect&, PanelState&, UserActions&);
void drawViewCard(const Theme&, const PanelData&, const PanelState&, View&, UserActions&);
void drawTaskCard(const Theme&, const PanelData&, PanelState&, View&, UserActions&);
void drawNumbersCard(const Theme&, const PanelData&);
void drawToolCard(const Theme&, const PanelData&, PanelState&, UserActions&);
void drawMaterialCard(const Theme&, const PanelData&, const PanelState&, UserActions&);
void drawForceCard(const Theme&, const PanelData&, float height, PanelState&, UserActions&);
void drawTimingCard(const Theme&, const PanelData&, bool open);
void drawLog(const Theme&, const PanelData&, bool engineer, const Rect&);
void drawLegend(const Theme&, const PanelData&, const Rect& view);
void drawNotice(const Theme&, const PanelData&, const Rect& view, bool large, UserActions&);
void drawTimeline(const Theme&, const PanelData&, const Rect& view, PanelState&, UserActions&);
void drawPullForce(const Theme&, const PanelData&);
void drawDemoForce(const Theme&, const PanelData&);
/// In the middle of the view: a sentence that can be clicked.
bool drawCall(const Theme&, const char* sentence, const Rect& view);
/// Where that stands: in the lower right corner.
Rect demoForcePlace(const Theme&, const PanelData&);
/// What it leaves of the view for what lies at its foot: the part beside it or, in a narrow window, above it.
Rect besideDemoForce(const Rect& view, const Rect& force, float scale);
/// What the demo that plays by itself asks of who comes near.
void drawInvitation(const Theme&, const Rect& view);
void drawFileMenu(const Theme&, const PanelData&, PanelState&, UserActions&);
void drawOpenDialog(const Theme&, const PanelData&, PanelState&, UserActions&);
void drawQuitDialog(const Theme&, PanelState&, UserActions&);
void drawProblem(const Theme&, PanelState&);
void drawHelp(const Theme&, PanelState&);

}  // namespace palpate::app
