#pragma once

#include <memory>
#include <string>

#include "app/run/attract_loop.h"
#include "app/run/composition.h"
#include "app/run/gl_window.h"
#include "app/run/grasp.h"
#include "app/run/input.h"
#include "app/run/past_pictures.h"
#include "app/run/tool_hand.h"

namespace palpate::app {

/// One session in the window: what the user sees, holds and sets. Main thread.
class Viewer {
 public:
  /// @param panels  what was set before, in another session; kept between sessions by the caller
  Viewer(Session& session, GlWindow& window, Interface& ui, PanelState& panels);

  /// One frame: input, requests to the loop, picture. @return what leaves the session
  UserActions frame(double seconds, const std::vector<std::string>& scenes);
  /// Whether quitting would lose something; then the user is asked.
  bool asksBeforeQuit();
  /// The wish, or none until the user has agreed to lose what leaving this session would lose.
  UserActions withConsent(const UserActions& wish);

  /// The picture that is seen, drawn once more.
  Picture picture();

  /// What is set, held and seen: for who watches the window (FrameWatch).
  const View& view() const { return view_; }
  const PanelState& panels() const { return panels_; }
  std::optional<double> lookedAt() const { return looked_at_; }
  const ToolHand& hand() const { return hand_; }
  Drag drag() const { return controls_.drag(); }
  /// Nobody has been there for a while, and no script or device moves the probe: the picture need not come often.
  bool rests() const;
  bool attracts() const { return attract_.has_value(); }
  /// The camera as it is drawn, in the middle of what the panels leave free.
  Camera shownCamera() const;

 private:
  const Snapshot& shownSnapshot() const;
  Layout layout(const CanvasSize& size) const;
  void carryOut(const UserAction& action, const Snapshot& snapshot, const CanvasSize& size);
  void moveRun(UserAction::Kind kind, bool paused);
  void moveByHand(const UserAction& action, const Snapshot& snapshot);
  void chooseProbe(UserAction::Kind next);
  void useFile(const UserAction& action);
  void closeTopmost();
  void lookAt(double run_s, const Snapshot& snapshot);
  void moveCamera(const Motion& motion, const CanvasSize& size);
  void moveTool(const Motion& motion, const Camera& camera, const Snapshot& snapshot, const Input& input,
                const CanvasSize& size, double seconds);
  void pull(const Motion& motion, const Camera& camera, const Eigen::Vector2d& mouse, const CanvasSize& size);
  void passTime(bool somebody, double seconds);
  void leavePast();
  void startAttracting();
  bool byHand() const;
  void send(const std::vector<Request>& requests);
  void reset();
  void showAnswers();
  std::string atStake() const;

  Session& session_;
  GlWindow& window_;
  OrganView organ_;
  Interface& ui_;
  ToolHand hand_;
  Controls controls_;
  View view_;
  PanelState& panels_;
  std::int64_t undo_count_ = 0;  // of the last snapshot
  double frame_seconds_ = 0;     // mean of the last ones
  bool answers_shown_ = false;   // of the search
  bool sheet_lost_ = false;      // it could not be written
  double answers_seconds_ = 0;   // that they were
  Shown shown_;
  PastPictures past_;
  UserActions leaving_;                      // what leaves the session, of this frame
  UserActions asked_;                        // the same, that waits for consent
  std::optional<double> looked_at_;          // s of the run, of the earlier picture that is shown
  std::optional<ForceHistory> past_forces_;  // up to then
  bool paused_for_past_ = false;             // the run goes on when it is left
  double nobody_s_ = 0;                      // since a hand was last at mouse or keys
  std::optional<Grasp> grasp_;               // under way
  std::optional<AttractLoop> attract_;       // while the demo plays by itself
};

}  // namespace palpate::app
