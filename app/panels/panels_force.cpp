// The right column: force and timing.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "app/figures/round_ticks.h"
#include "app/panels/panels.h"
#include "app/panels/plot.h"
#include "app/panels/widgets.h"
#include "step/trust.h"

namespace palpate::app {

namespace {

constexpr double min_force_axis = 0.05;  // N; below that an axis would show rounding as if it were signal
constexpr double min_depth_axis = 1;     // mm

/// Least and greatest y of two curves.
PlotAxes axesOver(std::span<const PlotPoint> a, std::span<const PlotPoint> b) {
  PlotAxes axes;
  axes.x_min = axes.y_min = 0;
  axes.x_max = axes.y_max = 0;
  for (const auto& curve : {a, b})
    for (const PlotPoint& p : curve) {
      axes.x_min = std::min<double>(axes.x_min, p.x);
      axes.x_max = std::max<double>(axes.x_max, p.x);
      axes.y_min = std::min<double>(axes.y_min, p.y);
      axes.y_max = std::max<double>(axes.y_max, p.y);
    }
  widenToRound(axes.y_min, axes.y_max, min_force_axis);
  return axes;
}

void bigNumber(const Theme& theme, const char* name, const char* unit, double value, ImU32 colour, float width) {
  const float left = ImGui::GetCursorPosX();
  ImGui::BeginGroup();
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::PushFont(theme.big);
  const std::string number = format("%.*f", std::abs(value) < 100 && *unit == 'N' ? 3 : 1, value);
  ImGui::TextUnformatted(number.c_str());
  const float baseline = ImGui::GetItemRectMax().y;
  ImGui::PopFont();
  ImGui::PopStyleColor();
  ImGui::SameLine(0, 4 * theme.scale);
  ImGui::SetCursorScreenPos({ImGui::GetCursorScreenPos().x, baseline - 1.45F * ImGui::GetFontSize()});
  ImGui::TextDisabled("%s", unit);
  ImGui::SetCursorScreenPos({ImGui::GetWindowPos().x + left, baseline - 2 * theme.scale});
  note(theme, name);
  ImGui::EndGroup();
  ImGui::SameLine(left + width);
}

}  // namespace

namespace {

constexpr std::size_t shown_presses = 8;  // of the session, behind the present one
constexpr ImU32 press_colour = IM_COL32(170, 142, 200, 130);

std::vector<std::reference_wrapper<const Press>> lastOf(const std::deque<Press>& all, std::size_t count) {
  return {all.end() - static_cast<std::ptrdiff_t>(std::min(count, all.size())), all.end()};
}

const ForceHistory& shownForces(const PanelData& data) {
  return data.past_forces != nullptr ? *data.past_forces : data.forces;
}

/// Force over depth: the present course, the presses before it, and what they are held against.
void drawDepthPlot(const PanelData& data, float height, const PanelState& state) {
  const ForceHistory& forces = shownForces(data);
  const auto raw = forces.rawOverDepth(), filtered = forces.filteredOverDepth();
  PlotAxes axes = axesOver(raw, filtered);
  axes.x_label = "mm";
  axes.y_label = "N over depth";
  axes.x_min = std::min(0.0, std::max(axes.x_min, -0.25 * axes.x_max));  // little of the way to the skin
  widenToRound(axes.x_min, axes.x_max, min_depth_axis);
  std::vector<PlotSeries> series;
  if (data.presses != nullptr)
    for (const Press& press : lastOf(data.presses->all(), shown_presses)) {
      for (const PlotPoint& p : press.curve) axes.x_max = std::max<double>(axes.x_max, p.x);
      axes.y_max = std::max(axes.y_max, 1.02 * press.peak_N);
      series.push_back({"", press.curve, press_colour, 1.0F});
    }
  if (state.reference) {
    for (const PlotPoint& p : state.reference->curve) {
      axes.x_max = std::max<double>(axes.x_max, p.x);
      axes.y_max = std::max<double>(axes.y_max, p.y);
    }
    series.push_back({"file", state.reference->curve, colours::warning, 1.6F});
  }
  widenToRound(axes.x_min, axes.x_max, min_depth_axis);
  widenToRound(axes.y_min, axes.y_max, min_force_axis);
  std::optional<ReferenceCurve> hertz;
  if (state.hertz && state.engineer && data.materials.size() == 1)
    hertz = hertzCurve(data.model, data.materials[0].material, axes.x_max);
  if (hertz) series.push_back({"Hertz", hertz->curve, colours::good, 1.6F});
  if (state.engineer) series.push_back({"raw", raw, colours::raw, 1.2F});
  series.push_back({state.engineer ? "filtered" : "", filtered, colours::accent, 1.8F});
  drawPlot("##depth", height, axes, series);
}

/// Which references lie over the plot.
void drawReferenceChoice(const PanelData& data, PanelState& state) {
  if (data.timeless) return;
  const float left = ImGui::GetCursorPosX(), half = 0.5F * ImGui::GetContentRegionAvail().x;
  if (state.engineer) {
    const bool possible = data.materials.size() == 1 && hertzCurve(data.model, data.materials[0].material, 1);
    ImGui::BeginDisabled(!possible);
    ImGui::Checkbox("Hertz", &state.hertz);
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
      ImGui::SetTooltip(possible
                            ? "a rigid sphere on an elastic half-space (Hertz 1882): what a press should begin like"
                            : "the closed form is for a spherical probe on tissue of one material");
  }
  if (!state.reference) return;
  if (state.engineer) ImGui::SameLine(left + half);
  bool shown = true;
  if (ImGui::Checkbox(fitted(state.reference->label, 0.75F * half).c_str(), &shown)) state.reference.reset();
}

/// What is known of the last press beside those before it, and what can be done with all.
void drawPresses(const Theme& theme, const PressCurves& presses, UserActions& asked) {
  const Press& last = presses.all().back();
  row(format("Press %d", last.number).c_str(), format("%.3f N at %.2f mm", last.peak_N, last.peak_mm), colours::text,
      "largest force and depth of the last press; violet curves are the presses before it");
  // More than was put in comes back only of a tool that was dragged, whose work over its depth is not all of it.
  constexpr double rounding = 0.02;
  if (last.loaded_mJ > 0 && last.lost_mJ > -rounding * last.loaded_mJ && !presses.underWay())
    row("Hysteresis", format("%.0f %% of %.3g mJ", 100 * std::max(0.0, last.lost_mJ) / last.loaded_mJ, last.loaded_mJ),
        colours::text, "of the work done on the tissue while it was pressed in, what did not come back");
  const float half = 0.5F * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  ImGui::PushFont(theme.small);
  if (button("Save the curves", half)) asked.push_back({UserAction::SavePresses});
  ImGui::SameLine();
  if (button("Clear them", half)) asked.push_back({UserAction::ClearPresses});
  ImGui::PopFont();
}

/// Of now; while that is good, of what the plots and the peak are made of.
void drawTrust(Doubt now, const ForceHistory& forces) {
  const Doubt before = forces.trust().doubt();
  if (now != Doubt::None)
    return row("Trust", std::string("doubt: ") + doubtName(now), colours::warning, doubtText(now));
  if (before == Doubt::None)
    return row("Trust", "good", colours::good,
               "volume, smallest J, energy balance and time step are within their limits");
  const std::string share =
      format("%.0f %% doubted: %s", std::max(1.0, 100 * forces.doubtedShare()), doubtName(before));
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize("Trust  ").x;
  row("Trust", lastThatFits({share, "good now, " + share}, room), colours::warning,
      (std::string("of the ticks since the last reset: ") + doubtText(before)).c_str());
}

}  // namespace

std::string staleMark(const ForceReading& force, const LoopStatus& status) {
  if (force.fresh) return {};
  if (status.paused || force.sample.tick == 0) return "paused";
  return force.age_s < 1 ? format("stale, %.0f ms old", 1e3 * force.age_s) : format("stale, %.1f s old", force.age_s);
}

/// On tools that nobody holds, what other organs do to each, and rigid bodies to the tissue.
void drawBodyForces(const PanelData& data) {
  const Scene& scene = data.model.scene;
  const StepReport& report = data.snapshot.report;
  const auto show = [](const std::string& name, const Vec3& force, const char* about, double error = 0) {
    row(name.c_str(), format("%.3f N", force.norm()) + (error > 0 ? format(" \xC2\xB1%.0f %%", 100 * error) : ""),
        error > TrustLimits::expected_error ? colours::warning : colours::text, about);
  };
  for (std::size_t t = 1; t < scene.tools.size(); ++t) {
    const ToolReading& tool = data.snapshot.tools.tool[t];
    const std::string name = "On tool " + std::to_string(t + 1);
    show(name, Vec3(tool.force[0], tool.force[1], tool.force[2]), "force of the tissue on this tool",
         tool.contact_count > 0 ? tool.expected_error : 0);
    if (tool.opening > 0 || tool.pinch > 0)
      row((name + ", pinch").c_str(), format("%.3f N, %.1f mm open", tool.pinch, 1e3 * tool.opening));
  }
  if (scene.organs.size() > 1) {
    const std::vector<OrganSpec>& organs = scene.organs;
    for (std::size_t k = 0; k < organs.size(); ++k)
      show("On " + organs[k].name, report.organ_force[k], "force of the other organs on it");
  }
  for (std::size_t k = 0; k < scene.rigid.size(); ++k)
    show("By " + scene.rigid[k].name, report.rigid[k].force, "force of this rigid body on the tissue",
         report.rigid[k].expected_error);
}

void drawForceCard(const Theme& theme, const PanelData& data, float height, PanelState& state, UserActions& asked) {
  if (!beginCard(theme, "Force on the tool")) return;
  const ForceSample& force = data.force.sample;
  const bool fresh = data.force.fresh;
  const std::string mark = staleMark(data.force, data.snapshot.status);
  // Amber before it goes wrong: whoever feels or reads the number sees the doubt in it.
  // A coarse cloud's error stands beside it, and is no reason to stop.
  const bool coarse = force.doubt == Doubt::Resolution, doubted = force.doubt != Doubt::None && !coarse;
  const ImU32 filtered_colour = !fresh ? colours::stale : doubted ? colours::warning : colours::accent;
  const ImU32 raw_colour = !fresh ? colours::stale : doubted ? colours::warning : colours::raw;
  const float half = 0.5F * ImGui::GetContentRegionAvail().x;
  const bool engineer = state.engineer;
  const char* const name = engineer ? "filtered" : "force";
  if (data.pull_N >= 0)  // the force of the hand, which then holds no probe
    bigNumber(theme, "pull on the tissue", "N", data.pull_N, colours::good, half);
  else
    bigNumber(theme, fresh ? name : mark.c_str(), "N", force.force_filtered.norm(), filtered_colour, half);
  if (engineer)
    bigNumber(theme, fresh ? "raw" : mark.c_str(), "N", force.force_raw.norm(), raw_colour, half);
  else
    bigNumber(theme, force.depth_m < 0 ? "from the skin" : "deep", "mm", 1e3 * std::abs(force.depth_m), colours::text,
              half);
  ImGui::NewLine();
  const Vec3& f = force.force_filtered;
  const ForceHistory& forces = shownForces(data);
  if (engineer) {
    row("Components", format("%+.3f  %+.3f  %+.3f N", f.x(), f.y(), f.z()), fresh ? colours::text : colours::stale,
        "x, y, z of the filtered force");
    row("Peak", format("%.3f N filtered, %.3f N raw", forces.peakFiltered(), forces.peakRaw()));
  } else {
    row("Peak", format("%.3f N", forces.peakFiltered()), colours::text, "since the last reset");
  }
  if (const ToolReading& jaws = data.snapshot.tools.tool[0]; jaws.opening > 0 || jaws.pinch > 0)
    row("Pinch", format("%.3f N, %.1f mm open", jaws.pinch, 1e3 * jaws.opening));
  drawBodyForces(data);

  if (!data.certified.empty())
    row("Force error", data.certified, colours::text,
        "the largest that mtled certify measured at about this depth, against two finer clouds");
  // Of a certificate's place another moment may be worse than the one that was measured.
  if (force.contact_count > 0 && (data.certified_error == 0 || force.expected_error > data.certified_error))
    row("Expected error",
        force.error_force > 0
            ? format(force.expected_error < 0.1 ? "\xC2\xB1%.2g %%" : "\xC2\xB1%.0f %%", 100 * force.expected_error)
            : "not known yet",
        force.expected_error > TrustLimits::expected_error ? colours::warning : colours::text,
        "by how much forces are off because nodes are no closer; of some tenths of a second ago");
  const StepReport& report = data.snapshot.report;
  drawTrust(force.doubt, forces);
  if (engineer)
    note(theme, format("volume %+.2f %%   J %.2f   energy %.1f %%   dt/limit %.2f", 100 * report.volume_change,
                       report.min_J, 100 * report.energy_error, report.step_share));

  const float plot_height = std::clamp((engineer ? 0.138F : 0.2F) * height, 92 * theme.scale, 320 * theme.scale);
  ImGui::PushFont(theme.small);
  {
    const auto raw = forces.rawOverTime(), filtered = forces.filteredOverTime();
    PlotAxes axes = axesOver(raw, filtered);
    axes.x_label = "s";
    axes.y_label = "N over time";
    axes.x_max = std::max(data.snapshot.force.time_s, data.forces.seconds());  // the run's time: a reset keeps it
    axes.x_min = axes.x_max - data.forces.seconds();
    const std::array series{PlotSeries{"raw", raw, colours::raw, 1.2F},
                            PlotSeries{engineer ? "filtered" : "", filtered, colours::accent, 1.8F}};
    drawPlot("##time", plot_height, axes, std::span(series).subspan(engineer ? 0 : 1));
  }
  drawDepthPlot(data, plot_height, state);
  ImGui::PopFont();
  if (data.presses != nullptr && !data.presses->all().empty()) drawPresses(theme, *data.presses, asked);
  drawReferenceChoice(data, state);
  ImGui::Spacing();
}

void drawTimingCard(const Theme& theme, const PanelData& data, bool open) {
  if (!beginCard(theme, "Timing", open)) return;
  const TimingView& timing = data.timing;
  const LoopStatus& status = data.snapshot.status;
  const double budget = 1e6 / timing.rate_hz;  // us

  const bool slow = timing.histogram_end >= 2e4;
  const double unit = slow ? 1e-3 : 1;  // of the plot per us
  ImGui::PushFont(theme.small);
  PlotAxes axes;
  axes.x_label = slow ? "ms" : "us";
  axes.y_label = "Ticks by computing time";
  axes.x_max = timing.histogram_end * unit;
  const std::array marks{
      PlotMark{"p50", timing.step_p50 * unit, colours::text}, PlotMark{"p99", timing.step_p99 * unit, colours::accent},
      PlotMark{"p99.9", timing.step_p999 * unit, colours::warning}, PlotMark{"tick", budget * unit, colours::bad}};
  drawHistogram("##steps", 92 * theme.scale, axes, timing.histogram, colours::raw, marks);
  ImGui::PopFont();

  row("p50 / 99 / 99.9 / max",
      timing.step_max < 9999.5
          ? format("%.0f / %.0f / %.0f / %.0f us", timing.step_p50, timing.step_p99, timing.step_p999, timing.step_max)
          : format("%.1f / %.1f / %.1f / %.1f ms", 1e-3 * timing.step_p50, 1e-3 * timing.step_p99,
                   1e-3 * timing.step_p999, 1e-3 * timing.step_max),
      timing.step_max < budget ? colours::text : colours::warning,
      format("of the %.0f us that a tick has", budget).c_str());
  row("Cost of 1 ms of physics",
      timing.step_p50 > 0
          ? format("%.0f us, x%.2f possible", timing.step_p50 * timing.rate_hz * 1e-3, budget / timing.step_p50)
          : "not known yet",
      colours::text,
      "what mtled frontier compares settings by: the median tick's, and the real-time factor that it could reach");
  row("Wake-up late, p99 / max", format("%.0f / %.0f us", timing.late_p99, timing.late_max));
  const auto periods = static_cast<long long>(status.ticks + status.overrun_count - status.caught_up_count);
  const double share =
      periods > 0 ? 100.0 * static_cast<double>(status.overrun_count) / static_cast<double>(periods) : 0;
  const auto overruns = static_cast<long long>(status.overrun_count);
  const auto caught_up = static_cast<long long>(status.caught_up_count);
  row("Overruns",
      caught_up > 0 ? format("%lld, %lld made good", overruns, caught_up)
                    : format("%lld of %lld (%.3f %%)", overruns, periods, share),
      share < 0.1 ? colours::good : colours::warning,
      format("%.3f %% of the grid times went by while the loop was busy; those not made good at once were skipped",
             share)
          .c_str());
  row("Real-time factor", format("%.4f", status.realtime_factor),
      status.realtime_factor >= 0.999 ? colours::good : colours::warning,
      "physics time over wall time since the start or the last pause");
  row("Rate", format("%.0f Hz x %d steps, %d thread%s", timing.rate_hz, data.model.substeps_per_tick, timing.threads,
                     timing.threads == 1 ? "" : "s"));
  for (const SetupLine& line : timing.setup)
    row(line.name.c_str(), line.text, line.done ? colours::good : colours::faint, line.text.c_str());
  ImGui::Spacing();
}

}  // namespace palpate::app
