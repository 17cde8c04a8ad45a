// The real window on a screen of its own, under a hand that uses mouse and keyboard as a person does. It waits for what
// each event brings about, picture by picture, and never for a time: pictures may come as seldom as they like.
#include <imgui.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "app/panels/widgets.h"
#include "app/run/gl_window.h"
#include "app/run/session.h"
#include "app/run/viewer.h"
#include "app/run/window.h"
#include "contact/tools/tool_list.h"
#include "support/block_text.h"
#include "support/temp_folder.h"
#include "window/virtual_screen.h"

using namespace palpate;
using namespace palpate::app;

namespace {

namespace fs = std::filesystem;

/// What a person does, and what that brings about.
struct Step {
  std::string name;
  std::function<void(Session&, Viewer&)> act;
  std::function<bool(Session&, Viewer&)> until;
};

/// Does the steps one after the other, each once its picture has shown what the one before brings about.
class Hand {
 public:
  explicit Hand(std::vector<Step> steps) : steps_(std::move(steps)) {}

  void watch(Session& session, Viewer& viewer) {
    if (next_ > 0 && !steps_[next_ - 1].until(session, viewer)) {
      if (std::chrono::steady_clock::now() - begin_ > patience)
        throw std::runtime_error("nothing came of: " + steps_[next_ - 1].name);
      return;
    }
    if (next_ == steps_.size()) return;
    begin_ = std::chrono::steady_clock::now();
    steps_[next_++].act(session, viewer);
  }
  bool done() const { return next_ == steps_.size(); }

  static constexpr std::chrono::minutes patience{3};  // with one step: what is broken must end

 private:
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  std::chrono::steady_clock::time_point begin_;
};

/// In a folder of its own, as what is saved goes to out/.
class OwnFolder {
 public:
  OwnFolder() : before_(fs::current_path()) {
    fs::current_path(folder_.path(""));
    setenv("XDG_CONFIG_HOME", folder_.path("config").c_str(), 1);  // for the list of scenes that were opened
    setenv("PALPATE_CACHE_DIR", folder_.path("cache").c_str(), 1);
  }
  ~OwnFolder() { fs::current_path(before_); }
  std::string write(const std::string& name, const std::string& text) const { return folder_.write(name, text); }

 private:
  TempFolder folder_;
  fs::path before_;
};

constexpr int window_width = 1280, window_height = 800;  // with both columns

Eigen::Vector2d pixelOf(const Viewer& viewer, const Vec3& world) {
  return viewer.shownCamera().project(world, window_width, window_height).head<2>();
}

void drive(test::VirtualScreen&, const std::string& scene, std::vector<Step> steps, double idle_seconds = 1000) {
  Options options;
  options.scene = scene;
  options.idle_seconds = idle_seconds;
  options.width = window_width;
  options.height = window_height;
  Log log;
  Hand hand(std::move(steps));
  const std::string failure = runWindow(options, readScene(options), log,
                                        [&](Session& session, Viewer& viewer) { hand.watch(session, viewer); });
  CHECK(failure.empty());
  CHECK(hand.done());
}

/// The screen of all tests of this program; null where there is none.
test::VirtualScreen* screen() {
  static std::string why;
  static const std::unique_ptr<test::VirtualScreen> one = test::VirtualScreen::open(1280, 800, why);
  if (!one) WARN("skipped: " << why);
  return one.get();
}

/// Clicks the middle of the button with this label.
void clickButton(test::VirtualScreen& person, const std::string& label) {
  const Rect place = buttonPlaces().at(label);
  person.click(place.x + 0.5F * place.width, place.y + 0.5F * place.height);
}

}  // namespace

TEST_CASE("A person presses, tilts, cuts open, saves, marks, undoes, submits and opens another scene", "[window]") {
  test::VirtualScreen* const person = screen();
  if (person == nullptr) return;
  const OwnFolder folder;
  const std::string scene = folder.write("task.toml", test::lump_block_text);
  folder.write("other.toml", test::touched_block_text + "[dynamics]\nrate = 100\nthreads = 1\n");
  folder.write("broken.toml", "name = \"broken\"\n[organ]\nsolid = \"ball\"\n");
  const Vec3 spot(0.012, 0.004, 0.03);  // on the upper face
  double before = 0;
  Quat turned = Quat::Identity();
  const Session* first = nullptr;
  std::int64_t ticks = 0;

  const auto wait = [](Session&, Viewer&) {};
  drive(
      *person, scene,
      {{"the first picture", wait, [](Session& s, Viewer&) { return s.latest().status.ticks > 0; }},
       {"End, which presses", [&](Session&, Viewer&) { person->moveTo(640, 200), person->tap("End"); },
        [](Session& s, Viewer& v) { return v.hand().depth() > 0.002 && s.latest().force.force_raw.norm() > 0.01; }},
       {"Home, which lifts", [&](Session&, Viewer&) { person->tap("Home"); },
        [](Session& s, Viewer&) { return s.latest().toolPose().position.z() > 0.034; }},
       {"a click on Press", [&](Session&, Viewer&) { clickButton(*person, "Press"); },
        [](Session& s, Viewer& v) { return v.hand().depth() > 0.002 && s.latest().force.force_raw.norm() > 0.01; }},
       {"a click on Lift", [&](Session&, Viewer&) { clickButton(*person, "Lift"); },
        [](Session& s, Viewer&) { return s.latest().toolPose().position.z() > 0.034; }},
       {"E, B, which is shut during a search, and U",
        [&](Session&, Viewer&) {
          for (const char* key : {"e", "b", "u"}) person->tap(key);
        },
        [](Session&, Viewer& v) { return v.panels().engineer && v.panels().hardness == 3 && !v.panels().tool_edited; }},
       {"button down on the skin",
        [&](Session&, Viewer& v) {
          const Eigen::Vector2d at = pixelOf(v, spot);
          person->moveTo(at.x(), at.y());
          person->button(1, true);
        },
        [](Session&, Viewer& v) { return v.drag() == Drag::Glide && v.hand().onSkin(); }},
       {"button up", [&](Session&, Viewer&) { person->button(1, false); },
        [&](Session& s, Viewer& v) {
          return v.drag() == Drag::None && (s.latest().toolPose().position - spot).norm() < 0.003;
        }},
       {"a tap of PageDown that is shorter than a picture",
        [&](Session& s, Viewer&) {
          before = s.latest().toolPose().position.z();
          person->tap("Next");
        },
        [&](Session& s, Viewer&) { return s.latest().toolPose().position.z() < before - 8e-4; }},
       {"another",
        [&](Session& s, Viewer&) {
          before = s.latest().toolPose().position.z();
          person->tap("Next");
        },
        [&](Session& s, Viewer&) {
          return s.latest().toolPose().position.z() < before - 8e-4 && s.latest().force.force_raw.norm() > 0.01;
        }},
       {"a tap of PageUp that is shorter than a picture",
        [&](Session& s, Viewer&) {
          before = s.latest().goal_pose.position.z();
          person->tap("Prior");
        },
        [&](Session& s, Viewer&) {  // on a busy machine the hand is still on its way down
          before = std::min(before, s.latest().goal_pose.position.z());
          return s.latest().goal_pose.position.z() > before + 5e-4;
        }},
       {"J held",
        [&](Session& s, Viewer&) {
          turned = s.latest().toolPose().orientation;
          person->key("j", true);
        },
        [&](Session& s, Viewer&) { return s.latest().toolPose().orientation.angularDistance(turned) > 0.1; }},
       {"J up", [&](Session&, Viewer&) { person->key("j", false); }, [](Session&, Viewer&) { return true; }},
       {"a tap of X", [&](Session&, Viewer&) { person->tap("x"); },
        [](Session&, Viewer& v) { return v.view().section.on; }},
       {"three taps of X between two pictures",
        [&](Session&, Viewer&) {
          for (int k = 0; k < 3; ++k) person->tap("x");
        },
        [](Session&, Viewer& v) { return !v.view().section.on; }},
       {"a tap of F12", [&](Session&, Viewer&) { person->tap("F12"); },
        [](Session&, Viewer&) { return fs::exists("out/task/picture-1.png"); }},
       {"Ctrl+S", [&](Session&, Viewer&) { person->tapWith("Control_L", "s"); },
        [](Session&, Viewer&) { return fs::exists("out/task/force-1/force.csv"); }},
       {"Ctrl+Z", [&](Session&, Viewer&) { person->tapWith("Control_L", "z"); },
        [](Session& s, Viewer&) { return s.latest().status.undo_count == 1; }},
       {"T, which looks back", [&](Session&, Viewer&) { person->tap("t"); },
        [](Session&, Viewer& v) { return v.panels().timeline_shown; }},
       {"a click into the past",
        [&](Session&, Viewer&) {
          const Rect play = buttonPlaces().at("Play");
          person->click(play.x + 20, play.y - 0.7F * play.height);
        },
        [](Session& s, Viewer& v) { return v.lookedAt() && s.latest().status.paused; }},
       {"Space, which goes on", [&](Session&, Viewer&) { person->tap("space"); },
        [](Session& s, Viewer& v) { return !v.lookedAt() && !s.latest().status.paused; }},
       {"a click on Save run", [&](Session&, Viewer&) { clickButton(*person, "Save run"); },
        [](Session&, Viewer&) { return fs::exists("out/task/recording-1.rec"); }},
       {"Escape after presses, without a mark", [&](Session&, Viewer&) { person->tap("Escape"); },
        [](Session&, Viewer& v) { return !v.panels().at_stake.empty(); }},
       {"Escape, which stays", [&](Session&, Viewer&) { person->tap("Escape"); },
        [](Session&, Viewer& v) { return v.panels().at_stake.empty(); }},
       {"a tap of M", [&](Session&, Viewer&) { person->tap("m"); },
        [](Session& s, Viewer&) { return s.task()->marks().size() == 1; }},
       {"Ctrl+O with a mark", [&](Session&, Viewer&) { person->tapWith("Control_L", "o"); },
        [](Session&, Viewer& v) { return v.panels().open_shown && ImGui::GetIO().WantTextInput; }},
       {"a scene's name and Return", [&](Session&, Viewer&) { person->type("other.toml"), person->tap("Return"); },
        [pictures = 0](Session&, Viewer& v) mutable {  // its place settles
          return !v.panels().at_stake.empty() && ++pictures > 3;
        }},
       {"a click on Stay", [&](Session&, Viewer&) { clickButton(*person, "Stay"); },
        [](Session& s, Viewer& v) { return v.panels().at_stake.empty() && s.task()->marks().size() == 1; }},
       {"a click on Submit", [&](Session&, Viewer&) { clickButton(*person, "Submit"); },
        [](Session& s, Viewer&) {
          return s.revealed() && fs::exists("out/task/score-1.json") && fs::exists("out/task/score-1.png") &&
                 fs::exists("out/task/score-1-pressure.csv");
        }},
       {"Escape before the answers were looked at", [&](Session&, Viewer&) { person->tap("Escape"); },
        [](Session&, Viewer& v) { return !v.panels().at_stake.empty(); }},
       {"Escape, which stays once more", [&](Session&, Viewer&) { person->tap("Escape"); },
        [](Session&, Viewer& v) { return v.panels().at_stake.empty(); }},
       {"Save run with the answers", [&](Session&, Viewer&) { clickButton(*person, "Save run"); },
        [](Session&, Viewer&) { return fs::exists("out/task/recording-2.rec"); }},
       {"the score", wait, [](Session&, Viewer&) { return buttonPlaces().count("Search again") > 0; }},
       {"a click on Search again", [&](Session&, Viewer&) { clickButton(*person, "Search again"); },
        [](Session& s, Viewer&) {
          return !s.revealed() && s.task()->marks().empty() && s.conditions().answers_seen == 1;
        }},
       {"a click on File", [&](Session&, Viewer&) { clickButton(*person, "File"); },
        [](Session&, Viewer&) { return menuOpen(); }},
       {"Escape, which closes the menu", [&](Session&, Viewer&) { person->tap("Escape"); },
        [](Session&, Viewer&) { return !menuOpen(); }},
       {"Ctrl+O", [&](Session&, Viewer&) { person->tapWith("Control_L", "o"); },
        [](Session&, Viewer& v) { return v.panels().open_shown && ImGui::GetIO().WantTextInput; }},
       {"the name of a broken scene",
        [&](Session& s, Viewer&) {
          first = &s;
          person->type("broken.toml");
        },
        [](Session&, Viewer& v) { return v.panels().path == "broken.toml"; }},
       {"Return", [&](Session&, Viewer&) { person->tap("Return"); },
        [](Session&, Viewer& v) { return !v.panels().problem.empty(); }},
       {"Escape",
        [&](Session& s, Viewer&) {
          ticks = s.latest().status.ticks;
          person->tap("Escape");
        },
        [&](Session& s, Viewer& v) {  // the old one is still there, and runs
          return v.panels().problem.empty() && &s == first && s.latest().status.ticks > ticks;
        }},
       {"Ctrl+O again", [&](Session&, Viewer&) { person->tapWith("Control_L", "o"); },
        [](Session&, Viewer& v) { return v.panels().open_shown && ImGui::GetIO().WantTextInput; }},
       {"the name of another scene", [&](Session&, Viewer&) { person->type("other.toml"); },
        [](Session&, Viewer& v) { return v.panels().path == "other.toml"; }},
       {"Return again", [&](Session&, Viewer&) { person->tap("Return"); },
        [](Session& s, Viewer&) { return s.task() == nullptr && s.latest().status.ticks > 0; }},
       {"B", [&](Session&, Viewer&) { person->tap("b"); },
        [](Session&, Viewer& v) { return v.panels().tool_edited && v.panels().tool.kind == ToolKind::FlatCylinder; }},
       {"its place", wait, [](Session&, Viewer&) { return buttonPlaces().count("Keep the old") > 0; }},
       {"a click on Keep the old", [&](Session&, Viewer&) { clickButton(*person, "Keep the old"); },
        [](Session&, Viewer& v) { return !v.panels().tool_edited; }},
       {"B, + and Enter",
        [&](Session&, Viewer&) {
          for (const char* key : {"b", "equal", "Return"}) person->tap(key);
        },
        [](Session& s, Viewer&) {
          const ToolShape& tool = s.model().scene.tools[0].shape;
          return tool.kind == ToolKind::FlatCylinder && tool.radius > 0.0105 && s.latest().status.ticks > 0;
        }},
       {"Escape, which quits", [&](Session&, Viewer&) { person->tap("Escape"); },
        [](Session&, Viewer&) { return false; }}});
}

TEST_CASE("A rough person drags, turns the wheel, resizes to nothing and presses everything, and it goes on",
          "[window]") {
  test::VirtualScreen* const person = screen();
  if (person == nullptr) return;
  OwnFolder folder;
  const std::string scene =
      folder.write("block.toml", test::touched_block_text + "[dynamics]\nrate = 100\nthreads = 1\n");
  std::int64_t ticks = 0;
  const auto goesOn = [&](Session& s, Viewer&) { return s.latest().status.ticks > ticks && !s.latest().status.frozen; };
  const auto seen = [&](Session& s) { ticks = s.latest().status.ticks; };
  std::vector<Step> steps = {
      {"the first picture", [](Session&, Viewer&) {}, [](Session& s, Viewer&) { return s.latest().status.ticks > 0; }}};
  for (const auto& [w, h] : {std::pair{100u, 100u}, {1u, 1u}, {640u, 400u}, {1280u, 60u}, {1280u, 800u}})
    steps.push_back({"size " + std::to_string(w) + "x" + std::to_string(h),
                     [&, w = w, h = h](Session& s, Viewer&) {
                       person->moveTo(0, 0);
                       person->resize(w, h);
                       seen(s);
                     },
                     goesOn});
  for (int button = 1; button <= 3; ++button)
    steps.push_back({"a wild drag with button " + std::to_string(button),
                     [&, button](Session& s, Viewer&) {
                       person->moveTo(300, 300);
                       person->button(button, true);
                       for (int k = 0; k < 20; ++k) person->moveTo((k * 397) % 1270, (k * 211) % 790);
                       person->button(button, false);
                       seen(s);
                     },
                     goesOn});
  steps.push_back({"the wheel, a hundred notches each way",
                   [&](Session& s, Viewer&) {
                     for (int k = 0; k < 200; ++k) {
                       person->button(k < 100 ? 4 : 5, true);
                       person->button(k < 100 ? 4 : 5, false);
                     }
                     seen(s);
                   },
                   goesOn});
  steps.push_back({"every letter and function key, with and without Ctrl",
                   [&](Session& s, Viewer&) {
                     for (char c = 'a'; c <= 'z'; ++c) {
                       person->tap(std::string(1, c));
                       person->tapWith("Control_L", std::string(1, c));
                     }
                     for (const char* key : {"F1", "F2", "F10", "F10", "F12", "1", "2", "3", "4", "Tab"})
                       person->tap(key);
                     seen(s);
                   },
                   [](Session&, Viewer& v) { return v.panels().open_shown || v.panels().help_shown; }});
  for (int k = 0; k < 2; ++k)
    steps.push_back(
        {"Escape closes what is open", [&](Session& s, Viewer&) { seen(s), person->tap("Escape"); },
         [k](Session&, Viewer& v) { return k == 0 || (!v.panels().open_shown && !v.panels().help_shown); }});
  steps.push_back(
      {"Escape quits", [&](Session&, Viewer&) { person->tap("Escape"); }, [](Session&, Viewer&) { return false; }});
  drive(*person, scene, std::move(steps));
}

TEST_CASE("Left alone the window comes back from the past, and the demo plays by itself until somebody comes",
          "[window]") {
  test::VirtualScreen* const person = screen();
  if (person == nullptr) return;
  const OwnFolder folder;
  const std::string scene =
      folder.write("block.toml", test::touched_block_text + "[dynamics]\nrate = 100\nthreads = 1\n");
  const auto nobody = [](Session&, Viewer&) {};
  const char* const away = "The organ is out of view: F";
  int pictures = 0;
  drive(*person, scene,
        {{"the first picture", nobody, [](Session& s, Viewer&) { return s.latest().status.ticks > 0; }},
         {"T, which looks back", [&](Session&, Viewer&) { person->tap("t"); },
          [](Session& s, Viewer& v) { return v.panels().timeline_shown && s.latest().force.time_s > 1; }},
         {"a click into the past",
          [&](Session&, Viewer&) {
            const Rect play = buttonPlaces().at("Play");
            person->click(play.x + 20, play.y - 0.7F * play.height);
          },
          [](Session& s, Viewer& v) { return v.lookedAt() && s.latest().status.paused; }},
         {"nobody", nobody, [](Session& s, Viewer& v) { return !v.lookedAt() && !s.latest().status.paused; }},
         {"the right button", [&](Session&, Viewer&) { person->moveTo(320, 200), person->button(3, true); },
          [](Session&, Viewer& v) { return v.drag() == Drag::Pan; }},
         {"a drag of the organ under the panels",
          [&](Session&, Viewer&) { person->moveTo(1150, 200), person->button(3, false); },
          [&](Session&, Viewer&) { return buttonPlaces().count(away) > 0; }},
         {"its place", [&](Session&, Viewer&) { pictures = 0; }, [&](Session&, Viewer&) { return ++pictures > 2; }},
         {"a click on what says so", [&](Session&, Viewer&) { clickButton(*person, away); },
          [](Session&, Viewer& v) {
            const double x = pixelOf(v, Vec3(0, 0, 0.015)).x();
            return x > 400 && x < 850;
          }},
         {"F10", [&](Session&, Viewer&) { person->tap("F10"); }, [](Session&, Viewer& v) { return v.panels().demo; }},
         {"what the demo locks",
          [&](Session&, Viewer&) {
            for (const char* key : {"t", "n", "p", "h", "e", "b", "Escape"}) person->tap(key);
            pictures = 0;
          },
          [&](Session&, Viewer& v) {
            const PanelState& p = v.panels();
            CHECK_FALSE((p.timeline_shown || v.view().show_nodes || v.view().show_points || p.panels_shown));
            CHECK_FALSE((p.engineer || p.tool_edited || !p.demo));
            return ++pictures > 3;
          }},
         {"nobody", nobody,
          [](Session& s, Viewer& v) { return v.attracts() && s.latest().force.force_raw.norm() > 0.01; }},
         {"somebody", [&](Session&, Viewer&) { person->moveTo(500, 300); },
          [](Session& s, Viewer& v) { return !v.attracts() && !s.latest().status.paused; }},
         {"F10 again", [&](Session&, Viewer&) { person->tap("F10"); },
          [](Session&, Viewer& v) { return !v.panels().demo; }},
         {"Escape, which quits", [&](Session&, Viewer&) { person->tap("Escape"); },
          [](Session&, Viewer&) { return false; }}},
        3);  // s: on a busy machine pictures are a second apart
}
