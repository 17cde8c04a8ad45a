#include "app/panels/panels.h"
#include "app/panels/widgets.h"

#include <imgui.h>
#include <imgui_internal.h>
#include <catch2/catch.hpp>

#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

using namespace palpate;
using namespace palpate::app;

namespace {

/// Dear ImGui without a screen: panels are laid out, nothing reaches a screen.
class Panels {
 public:
  Panels() : context_(ImGui::CreateContext()), theme_(makeTheme(1)) {
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
    model_.scene.name = "test organ";
    model_.scene.materials.emplace_back();
    model_.X.resize(1234);
    model_.point_X.resize(5678);
    model_.dt = 1e-4;
    model_.dt_critical = 2e-4;
    model_.substeps_per_tick = 20;
    model_.surface_volume = 1;
    model_.cell_volume = 0.99;
    timing_.rate_hz = 500;
    timing_.histogram.assign(80, 1.0F);
    timing_.histogram_end = 2200;
  }
  ~Panels() { ImGui::DestroyContext(context_); }

  /// Draws until the layout has settled; returns the names of the windows that are shown.
  std::string draw(int width, int height, int pictures = 3) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
    io.MousePos = mouse_;
    std::string names;
    asked_.clear();
    for (int k = 0; k < pictures; ++k) {
      ImGui::NewFrame();
      const PanelData data = this->data();
      if (state_.demo) demo_place_ = demoForcePlace(theme_, data);
      names = drawPanels(data, width, height);
      ImGui::Render();
    }
    return names;
  }

  /// What stands in the cards.
  std::string cards() {
    ImGui::GetIO().DisplaySize = {1280, 3000};  // with room for all: what is clipped is not written
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({400, 2900});
    ImGui::Begin("cards");
    ImGui::LogToBuffer();
    const PanelData data = this->data();
    UserActions asked;
    drawToolCard(theme_, data, state_, asked);
    drawViewCard(theme_, data, state_, view_, asked);
    drawMaterialCard(theme_, data, state_, asked);
    drawForceCard(theme_, data, 700, state_, asked);
    const std::string written = context_->LogBuffer.c_str();
    ImGui::End();
    ImGui::Render();
    return written;
  }

  Body model_;
  Snapshot snapshot_;
  ForceHistory forces_{8};
  std::vector<LogLine> log_;
  TimingView timing_;
  ForceReading force_{{}, 0, true};
  PanelState state_;
  std::optional<Notice> notice_;
  double pull_N_ = -1;
  bool out_of_view_ = false;
  View view_;
  UserActions asked_;  // in the pictures of one draw()
  std::optional<TimelineView> timeline_;
  Rect demo_place_;
  ImVec2 mouse_{-1e6F, -1e6F};
  std::optional<TaskScore> task_;
  std::string certified_;
  double certified_error_ = 0;

  /// A press of the left button there, and what it asks for.
  UserActions click(float x, float y, int width, int height) {
    mouse_ = {x, y};
    draw(width, height);
    UserActions all;
    for (const bool down : {true, false}) {
      ImGui::GetIO().MouseDown[0] = down;
      draw(width, height);
      all.insert(all.end(), asked_.begin(), asked_.end());
    }
    return all;
  }

 private:
  PanelData data() const {
    PanelData data{
        .model = model_, .snapshot = snapshot_, .forces = forces_, .log = log_, .timing = timing_, .force = force_};
    data.materials.push_back({Material::neoHookean(3000, 0.49, 1000), 1.0, "capsule", 2, true, 3000, 6000, 0.495});
    data.notice = notice_;
    data.pull_N = pull_N_;
    data.out_of_view = out_of_view_;
    data.timeline = timeline_;
    data.task = task_ ? &*task_ : nullptr;
    data.certified = certified_;
    data.certified_error = certified_error_;
    data.frozen_reason = "12 integration points are inverted";
    return data;
  }

  std::string drawPanels(const PanelData& data, int width, int height) {
    for (const UserAction& action :
         palpate::app::drawPanels(theme_, data, layoutFor(width, height, 1, state_.panels_shown), state_, view_))
      asked_.push_back(action);
    std::string names;
    for (const ImGuiWindow* window : context_->Windows)
      if (window->Active) names += std::string(window->Name) + "\n";
    return names;
  }

  ImGuiContext* context_;
  Theme theme_;
};

const ImGuiWindow* windowNamed(const char* name) { return ImGui::FindWindowByName(name); }

/// Corners of what is drawn in this colour in a window; a letter has four.
int countOf(ImU32 colour, const char* window) {
  int count = 0;
  for (const ImDrawVert& v : windowNamed(window)->DrawList->VtxBuffer) count += v.col == colour ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("At 1280x800 and larger the columns show all of their content without scrolling", "[panels]") {
  Panels panels;
  for (int k = 0; k < 4; ++k) panels.timing_.setup.push_back({"Scheduling", "SCHED_FIFO 40", true});
  for (const auto& [width, height, engineer] : {std::tuple{1280, 800, true}, {1600, 1000, true}, {1280, 800, false}}) {
    panels.state_.engineer = engineer;
    panels.draw(width, height);
    for (const char* name : {"##left", "##right", "##bar"}) {
      const ImGuiWindow* window = windowNamed(name);
      REQUIRE(window != nullptr);
      INFO(name << " at " << width << "x" << height << ": content " << window->ContentSize.y << " in "
                << window->InnerRect.GetHeight());
      CHECK(window->ScrollMax.y == 0);
      CHECK(window->ScrollMax.x == 0);
      CHECK(window->ContentSize.x <= window->InnerRect.GetWidth());
    }
  }
}

TEST_CASE("Hidden panels leave nothing but what must be said", "[panels]") {
  Panels panels;
  panels.state_.panels_shown = false;
  const std::string hidden = panels.draw(1280, 800);
  CHECK(hidden.find("##left") == std::string::npos);
  CHECK(hidden.find("##right") == std::string::npos);
  CHECK(hidden.find("##frozen") == std::string::npos);
  panels.snapshot_.status.frozen = true;
  CHECK(panels.draw(1280, 800).find("##frozen") != std::string::npos);
}

TEST_CASE("The help lies inside the window and above all else", "[panels]") {
  Panels panels;
  panels.state_.help_shown = true;
  for (const auto& [width, height] : {std::pair{1280, 800}, {1024, 640}, {640, 400}}) {
    panels.draw(width, height);
    const ImGuiWindow* help = windowNamed("##help");
    REQUIRE(help != nullptr);
    CHECK(help->Pos.x >= 0);
    CHECK(help->Pos.y >= 0);
    CHECK(help->Pos.x + help->Size.x <= static_cast<float>(width));
    CHECK(help->Pos.y + help->Size.y <= static_cast<float>(height));
  }
}

TEST_CASE("During a search the File menu does not save the tissue's state, which shows the lumps", "[panels]") {
  Model model;
  model.skin.surface.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  model.skin.surface.triangles = {{0, 1, 2}};
  for (const bool searching : {false, true}) {
    Panels panels;
    if (searching) panels.task_.emplace(model, std::vector<Lump>());
    panels.draw(1280, 800);
    const Rect file = buttonPlaces().at("File");
    bool saved_state = false, saved_run = false;
    for (float y = file.bottom() + 10; y < 420; y += 12) {  // each line of the menu
      panels.click(file.x + 5, file.y + 5, 1280, 800);
      const UserActions asked = panels.click(file.x + 30, y, 1280, 800);
      saved_state |= asks(asked, UserAction::SaveState);
      saved_run |= asks(asked, UserAction::SaveRecording);
      panels.state_ = {};
    }
    CHECK(saved_run);
    CHECK(saved_state != searching);
  }
}

TEST_CASE("Numbers that are not finite are drawn, not fatal", "[panels]") {
  Panels panels;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  panels.force_.sample.force_raw = {nan, nan, nan};
  ForceSample sample;
  for (int k = 0; k < 10; ++k) {
    sample.time_s = 0.1 * k;
    sample.force_raw = {0, 0, k == 5 ? nan : 1.0};
    panels.forces_.add(sample);
  }
  panels.draw(1280, 800);
  CHECK(windowNamed("##right")->Active);
}

TEST_CASE("A force that is not the present one is marked and greyed", "[panels]") {
  ForceReading force;
  force.sample.tick = 5;
  LoopStatus status;
  force.age_s = 0.009;
  force.fresh = true;
  CHECK(staleMark(force, status).empty());
  force.fresh = false;
  force.age_s = 0.023;
  CHECK(staleMark(force, status) == "stale, 23 ms old");
  force.age_s = 2.34;
  CHECK(staleMark(force, status) == "stale, 2.3 s old");
  status.paused = true;
  CHECK(staleMark(force, status) == "paused");

  Panels panels;
  const auto has = [&panels](ImU32 colour) {  // anything drawn in that colour in the right column
    panels.draw(1280, 800);
    return countOf(colour, "##right") > 0;
  };
  CHECK_FALSE(has(colours::stale));
  panels.force_ = {panels.force_.sample, 0.5, false};
  CHECK(has(colours::stale));
}

TEST_CASE("Nothing is requested unless something is clicked", "[panels]") {
  Panels panels;
  panels.draw(1280, 800);
  CHECK(panels.asked_.empty());
}

TEST_CASE("A force that is not to be trusted is amber, and nothing is while it is", "[panels]") {
  Panels panels;
  panels.state_.engineer = true;
  panels.force_.sample.force_filtered = Vec3(0, 0, 1.234);
  // The lines of the plots have colours of their own; letters are quads of one colour.
  const auto amber = [&panels] {
    panels.draw(1280, 800);
    return countOf(colours::warning, "##right");
  };
  const int without = amber();
  panels.force_.sample.doubt = Doubt::Energy;
  CHECK(amber() >= without + 2 * 4 * 5);  // two numbers of five signs
}

TEST_CASE("While the force is good, what was doubted of it before is told, unless it does not count", "[panels]") {
  Panels panels;
  ForceSample sample;
  const auto add = [&](int ticks, Doubt doubt, double error) {
    for (int k = 0; k < ticks; ++k) {
      sample.time_s += 0.1;
      sample.doubt = doubt;
      sample.expected_error = error;
      sample.error_force = error > 0.3 ? 0.001 : 1;
      panels.forces_.add(sample);
    }
  };
  const auto told = [&](const char* what) { return panels.cards().find(what) != std::string::npos; };
  add(3, Doubt::Resolution, 0.4);  // at first touch, of next to no force
  add(3, Doubt::None, 0.01);
  CHECK_FALSE(told("doubted"));
  add(3, Doubt::Resolution, 0.08);
  add(1, Doubt::None, 0);
  CHECK(told("60 % doubted: resolution"));
  panels.force_.sample.doubt = Doubt::Energy;
  CHECK(told("doubt: energy"));
  panels.forces_.clear();
  panels.force_.sample.doubt = Doubt::None;
  CHECK_FALSE(told("doubt"));

  // A light touch of a rigid body's beside a tool that presses: its error is of its own force.
  sample = {};
  sample.error_by = 0;
  add(1, Doubt::None, 0.01);
  sample.error_by = max_tools;
  sample.time_s += 0.1;
  sample.doubt = Doubt::Resolution;
  sample.expected_error = 0.2;
  sample.error_force = 0.02;
  panels.forces_.add(sample);
  sample.error_by = 0;
  add(1, Doubt::None, 0.01);
  CHECK(told("doubted: resolution"));
}

TEST_CASE("A certificate stands beside the force, and does not hide a larger error that is expected", "[panels]") {
  Panels panels;
  const auto told = [&](const char* what) { return panels.cards().find(what) != std::string::npos; };
  ForceSample& force = panels.snapshot_.force;
  force.contact_count = panels.force_.sample.contact_count = 5;
  panels.force_.sample.error_force = 0.1;
  panels.force_.sample.expected_error = 0.02;
  CHECK(told("Expected error"));
  CHECK_FALSE(told("Force error"));
  panels.certified_ = "±3 % (certified to 7 mm)";
  panels.certified_error_ = 0.03;
  CHECK(told("Force error"));
  CHECK_FALSE(told("Expected error"));
  panels.force_.sample.expected_error = 0.85;
  CHECK(told("Force error"));
  CHECK(told("Expected error"));
  panels.force_.sample.expected_error = 0.02;
  panels.certified_ = "beyond the certified 7 mm";
  panels.certified_error_ = 0;
  CHECK(told("Expected error"));
}

TEST_CASE("A slider's value stands above it, where no handle hides it, and is rounded to what is told", "[panels]") {
  Panels panels;
  ImGui::GetIO().DisplaySize = {640, 400};
  ImGui::NewFrame();
  ImGui::Begin("sliders");
  ImGui::LogToBuffer();
  float value = 4.5F;
  slider("Radius", value, 3, 6, "%.1f mm", "");
  const Rect all{ImGui::GetItemRectMin().x, ImGui::GetItemRectMin().y, ImGui::GetItemRectSize().x, 0};
  const std::string written = ImGui::GetCurrentContext()->LogBuffer.c_str();
  const auto letters = ImGui::GetWindowDrawList()->VtxBuffer;
  ImGui::End();
  ImGui::Render();
  CHECK(written.find("4.5 mm") == written.rfind("4.5 mm"));
  for (const ImDrawVert& v : letters)
    if (v.col == colours::text) CHECK(v.pos.y < all.y);
}

TEST_CASE("In a small window nothing is wider than its column, and the force is on the screen", "[panels]") {
  Panels panels;
  for (const auto& [width, height] : {std::pair{900, 600}, {640, 400}}) {
    panels.draw(width, height);
    CHECK(windowNamed("##left") == nullptr);
    const ImGuiWindow* column = windowNamed("##right");
    REQUIRE(column->Active);
    INFO(width << "x" << height);
    CHECK(column->ContentSize.x <= column->InnerRect.GetWidth());
    CHECK(column->Pos.y + 110 < static_cast<float>(height));  // heading and both numbers
    CHECK(windowNamed("##bar")->ContentSize.x <= windowNamed("##bar")->Size.x);
  }
}

TEST_CASE("The demo's force, the timeline and the legend lie beside or above each other", "[panels]") {
  Panels panels;
  panels.state_.panels_shown = false;
  panels.state_.demo = panels.state_.timeline_shown = true;
  panels.timeline_ = TimelineView{0, 10, 10, false};
  for (const auto& [width, height] : {std::pair{1600, 1000}, {900, 600}, {640, 400}, {480, 400}}) {
    panels.draw(width, height);
    const ImGuiWindow* timeline = windowNamed("##timeline");
    REQUIRE(timeline != nullptr);
    INFO(width << "x" << height);
    const Rect& force = panels.demo_place_;
    CHECK((timeline->Pos.x + timeline->Size.x <= force.x || timeline->Pos.y + timeline->Size.y <= force.y));
    CHECK(timeline->Pos.x >= 0);
    CHECK(force.x >= 0);
    CHECK(force.bottom() <= static_cast<float>(height));
  }
}

TEST_CASE("A figure that has no room is left out, not cut", "[panels]") {
  Panels panels;
  ImGui::GetIO().DisplaySize = {640, 400};
  ImGui::NewFrame();
  const std::vector<std::string> figures{"", "t 1.00 s", "t 1.00 s   real time x1.000"};
  const float first = ImGui::CalcTextSize(figures[1].c_str()).x, both = ImGui::CalcTextSize(figures[2].c_str()).x;
  CHECK(lastThatFits(figures, both) == figures[2]);
  CHECK(lastThatFits(figures, both - 1) == figures[1]);
  CHECK(lastThatFits(figures, first - 1).empty());
  ImGui::Render();
}

TEST_CASE("Panels are drawn in windows of any size, with all that can be open", "[panels]") {
  Panels panels;
  panels.state_.open_shown = panels.state_.help_shown = true;
  panels.state_.at_stake = "The sheet would be lost.";
  panels.state_.problem = "out/broken.toml:3:9: no such solid";
  panels.notice_ = Notice{"The tissue gives no further.", "the tool yields", 1, false};
  for (const auto& [width, height] : {std::pair{1, 1}, {20, 400}, {100, 100}, {1280, 60}, {3840, 2160}})
    CHECK(panels.draw(width, height).find("##problem") != std::string::npos);
}

TEST_CASE("What the tissue can't take is said in a banner that offers a way back", "[panels]") {
  Panels panels;
  panels.notice_ = Notice{"The tissue gives no further.", "the tool yields", 1, false};
  CHECK(panels.draw(1280, 800).find("##notice") != std::string::npos);
  panels.notice_.reset();
  CHECK(panels.draw(1280, 800).find("##notice") == std::string::npos);
}

TEST_CASE("Whether it runs stands in the bar of the smallest window, too", "[panels]") {
  Panels panels;
  for (const auto& [width, height] : {std::pair{1280, 800}, {950, 700}, {640, 400}}) {
    panels.draw(width, height);
    INFO(width << "x" << height);
    CHECK(countOf(colours::good, "##bar") >= 4 * 7);  // "RUNNING"
  }
}

TEST_CASE("While the hand pulls, the large number is the pull's", "[panels]") {
  Panels panels;
  panels.draw(1280, 800);
  const int without = countOf(colours::good, "##right"), blue = countOf(colours::accent, "##right");
  panels.pull_N_ = 0.42;
  panels.draw(1280, 800);
  CHECK(countOf(colours::good, "##right") >= without + 4 * 5);
  CHECK(countOf(colours::accent, "##right") <= blue - 4 * 5);
}

TEST_CASE("The log shows its newest line in the first picture after the window's size has changed", "[panels]") {
  Panels panels;
  panels.log_.resize(60);
  for (LogLine& line : panels.log_) line.text = "a line that is long enough to be wrapped where the log is narrow";
  panels.log_.back().text = "the newest";
  panels.log_.back().level = LogLevel::Error;
  for (const auto& [width, height] :
       {std::pair{1280, 800}, {640, 400}, {1280, 60}, {1920, 1080}, {650, 420}, {100, 100}, {1280, 800}}) {
    const bool shown = panels.draw(width, height, 1).find("##log") != std::string::npos;
    INFO(width << "x" << height);
    if (shown) CHECK(countOf(colours::bad, "##log") >= 4 * 9);
  }
}

TEST_CASE("A log with nothing to list has no pane", "[panels]") {
  Panels panels;
  panels.log_.resize(1);
  panels.log_[0].level = LogLevel::Detail;
  panels.log_[0].text = "5011 nodes";
  CHECK(panels.draw(1280, 800).find("##log") == std::string::npos);
  panels.state_.engineer = true;
  CHECK(panels.draw(1280, 800).find("##log") != std::string::npos);
}

TEST_CASE("In the demo a notice is large and stands at the foot, beside the force", "[panels]") {
  Panels panels;
  panels.notice_ = Notice{"The tissue gives no further: the probe waits behind your hand.", "it yields", 1, false};
  panels.draw(1280, 800);
  const float plain = windowNamed("##notice")->Size.y;
  panels.state_.panels_shown = false;
  panels.state_.demo = true;
  for (const auto& [width, height] : {std::pair{1920, 1080}, {1280, 800}, {900, 600}}) {
    panels.draw(width, height);
    const ImGuiWindow* notice = windowNamed("##notice");
    INFO(width << "x" << height);
    CHECK(notice->Size.y > 1.3F * plain);
    CHECK(notice->Pos.y > 0.5F * static_cast<float>(height));
    CHECK(notice->Pos.y + notice->Size.y <= static_cast<float>(height));
    CHECK((notice->Pos.x + notice->Size.x <= panels.demo_place_.x ||
           notice->Pos.y + notice->Size.y <= panels.demo_place_.y));
  }
}

TEST_CASE("Engineers' numbers are shown to those who ask for them, and what anybody needs to all", "[panels]") {
  Panels panels;
  panels.log_.resize(2);
  panels.log_[0].level = LogLevel::Detail;
  panels.log_[0].text = "5011 nodes";
  panels.log_[1].text = "saved: picture-1.png";
  float column[2] = {};
  int log[2] = {};
  for (const bool engineer : {false, true}) {
    panels.state_.engineer = engineer;
    const std::string written = panels.cards();
    INFO(written);
    for (const char* word : {"   J ", "dt/limit", "raw", "Components", "Shear modulus", "Points", "Tip"}) {
      INFO(word);
      CHECK((written.find(word) != std::string::npos) == engineer);
    }
    for (const char* word : {"Press", "Lift", "Trust", "Peak", "Young's modulus", "Cut open"}) {
      INFO(word);
      CHECK(written.find(word) != std::string::npos);
    }
    panels.draw(1280, 800);
    column[engineer ? 1 : 0] = windowNamed("##right")->ContentSize.y;
    log[engineer ? 1 : 0] = windowNamed("##log")->DrawList->VtxBuffer.Size;
  }
  CHECK(column[0] < 0.75F * column[1]);  // how long ticks took, what the system granted
  CHECK(log[1] - log[0] >= 4 * static_cast<int>(sizeof("5011nodes") - 1));  // how the scene was made ready
}

TEST_CASE("What is out of view is said, and a click brings it back", "[panels]") {
  Panels panels;
  CHECK(panels.draw(1280, 800).find("##call") == std::string::npos);
  panels.out_of_view_ = true;
  for (const auto& [width, height] : {std::pair{1280, 800}, {640, 400}}) {
    panels.draw(width, height);
    const ImGuiWindow* call = windowNamed("##call");
    CHECK(call->Active);
    CHECK(call->Pos.x > 0);
    CHECK(call->Pos.x + call->Size.x < static_cast<float>(width));
    CHECK(buttonPlaces().count("The organ is out of view: F") == 1);
  }
}
