#include "realtime/recording/run_report.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/build_info.h"
#include "base/number_text.h"
#include "scene/scene_rigid.h"
#include "step/trust.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<StepFlag, const char*>, 6> kFlagNames{{
    {kNotFinite, "not_finite"},
    {kBlowUp, "blow_up"},
    {kInvertedPoints, "inverted_points"},
    {kContactOverflow, "contact_overflow"},
    {kDeepContact, "deep_contact"},
    {kLetsGo, "lets_go"},
}};

}  // namespace

Json percentilesJson(const Percentiles& p) {
  return {{"p50", p.p50}, {"p99", p.p99}, {"p999", p.p999}, {"max", p.max}};
}

Json lateTicksJson(const std::array<std::int64_t, kLateCauseCount>& late_ticks) {
  return {{"woken_late", late_ticks[static_cast<std::size_t>(LateCause::LateWakeUp)]},
          {"core_taken", late_ticks[static_cast<std::size_t>(LateCause::CoreTaken)]},
          {"worker_late", late_ticks[static_cast<std::size_t>(LateCause::WorkerLate)]},
          {"long_computation", late_ticks[static_cast<std::size_t>(LateCause::LongComputation)]}};
}

std::vector<std::string> flagNames(std::uint32_t flags) {
  std::vector<std::string> names;
  for (const auto& [flag, name] : kFlagNames) {
    if (flags & flag) names.emplace_back(name);
  }
  return names;
}

RunReport makeRunReport(const Model& model, const RunSummary& summary, const DeadlineStatistics& statistics,
                        int threads, double volume_change) {
  RunReport report;
  report.scene = model.scene.name;
  report.nodes = model.nodeCount();
  report.integration_points = model.pointCount();
  report.mean_support = model.point_shape.meanSupport();
  report.cells_per_point = static_cast<double>(model.cells.size()) / model.pointCount();
  report.gradient_precision = model.scene.dynamics.gradient_precision;
  report.dt_s = model.dt;
  report.dt_critical_s = model.dt_critical;
  report.added_mass = model.addedMass();
  report.rate_hz = model.scene.dynamics.rate_hz;
  report.substeps_per_tick = model.substeps_per_tick;
  report.ticks = summary.ticks;
  report.overruns = statistics.overrun_count.load(std::memory_order_relaxed);
  report.caught_up = statistics.caught_up_count.load(std::memory_order_relaxed);
  report.longest_overrun_streak = statistics.longest_overrun_streak.load(std::memory_order_relaxed);
  for (std::size_t c = 0; c < kLateCauseCount; ++c) {
    report.late_ticks[c] = statistics.late_ticks[c].load(std::memory_order_relaxed);
  }
  report.physics_seconds = summary.totals.simulated_seconds;
  report.wall_seconds = summary.totals.wall_seconds;
  report.realtime_factor = summary.totals.realtime_factor;
  report.step_us = statistics.step.percentiles();
  report.wakeup_late_us = statistics.wakeup_late.percentiles();
  report.rt_setup = summary.rt_setup;
  report.threads = threads;
  report.min_J = static_cast<double>(summary.min_J);
  report.volume_error = model.cell_volume / model.surface_volume - 1;
  report.volume_change = volume_change;
  report.peak_force_N = summary.peak_force;
  for (std::size_t k = 0; model.tools.several() && k < model.tools.tool.size(); ++k)
    report.tools.push_back({summary.peak_tool_force[k], summary.peak_pinch[k], model.tools.tool[k].jaws});
  report.peak_depth_m = summary.peak_depth;
  report.base_reaction_N = summary.base_reaction;
  if (model.scene.organs.size() > 1)
    for (const OrganSpec& organ : model.scene.organs)
      report.organs.push_back({organ.name, summary.organ_force[report.organs.size()]});
  report.organ_penetration_m = summary.skin_penetration;
  for (std::size_t b = 0; b < model.rigid.body.size(); ++b) {
    const RigidLoad& load = summary.rigid[b];
    report.rigid.push_back({model.rigid.body[b].name, load.force, load.max_penetration, {}});
    if (load.expected_error > 0) report.rigid.back().expected_error = load.expected_error;
  }
  report.state_hash = summary.state_hash;
  report.flags = summary.flags;
  report.doubt = summary.trust.doubt();
  report.first_doubt_s = summary.trust.firstTime();
  report.expected_error = summary.trust.expectedError();
  report.restored_count = summary.restored_count;
  report.let_go_count = summary.let_go_count;
  report.largest_yield_m = summary.largest_yield;
  report.yielding_seconds = static_cast<double>(summary.yielding_ticks) / model.scene.dynamics.rate_hz;
  report.follow = summary.follow;
  report.frozen = summary.frozen;
  report.setup_seconds = model.setup_seconds;
  report.build = buildInfo();
  return report;
}

std::string toJson(const RunReport& r) {
  const auto listed = [](const Vec3& a) { return Json::array({a.x(), a.y(), a.z()}); };
  Json json = {
      {"scene", r.scene},
      {"nodes", r.nodes},
      {"integration_points", r.integration_points},
      {"mean_support", r.mean_support},
      {"cells_per_point", r.cells_per_point},
      {"gradient_precision", r.gradient_precision == GradientPrecision::Int16 ? "int16" : "float32"},
      {"dt_s", r.dt_s},
      {"dt_critical_s", r.dt_critical_s},
      {"added_mass", r.added_mass},
      {"rate_hz", r.rate_hz},
      {"substeps_per_tick", r.substeps_per_tick},
      {"ticks", r.ticks},
      {"overruns", r.overruns},
      {"caught_up", r.caught_up},
      {"longest_overrun_streak", r.longest_overrun_streak},
      {"late_ticks", lateTicksJson(r.late_ticks)},
      {"physics_seconds", r.physics_seconds},
      {"wall_seconds", r.wall_seconds},
      {"realtime_factor", r.realtime_factor},
      {"step_us", percentilesJson(r.step_us)},
      {"wakeup_late_us", percentilesJson(r.wakeup_late_us)},
      {"rt_setup",
       {{"scheduling", r.rt_setup.scheduling},
        {"memory_lock", r.rt_setup.memory_lock},
        {"affinity", r.rt_setup.affinity},
        {"denormals", r.rt_setup.denormals}}},
      {"threads", r.threads},
      {"min_J", r.min_J},
      {"volume_error", r.volume_error},
      {"volume_change", r.volume_change},
      {"peak_force_N", r.peak_force_N},
      {"peak_depth_m", r.peak_depth_m},
      {"base_reaction_N", listed(r.base_reaction_N)},
      {"state_hash", hex16(r.state_hash)},
      {"flags", flagNames(r.flags)},
      {"trust", doubtName(r.doubt)},
      {"expected_force_error", r.expected_error},
      {"first_doubt_s", r.first_doubt_s < 0 ? Json(nullptr) : Json(r.first_doubt_s)},
      {"restored_count", r.restored_count},
      {"let_go_count", r.let_go_count},
      {"largest_yield_m", r.largest_yield_m},
      {"yielding_seconds", r.yielding_seconds},
      {"frozen", r.frozen},
      {"setup_seconds", r.setup_seconds},
      {"build", r.build},
  };
  for (const RunReport::Region& region : r.regions)
    json["reactions"][region.name] = {{"force_N", listed(region.on_tissue.force)},
                                      {"moment_Nm", listed(region.on_tissue.moment)}};
  for (const RunReport::Tool& tool : r.tools) {
    Json entry = {{"peak_force_N", tool.peak_force_N}};
    if (tool.jaws) entry["peak_pinch_N"] = tool.peak_pinch_N;
    json["tools"].push_back(entry);
  }
  if (r.follow)
    json["follow"] = {
        {"swaps", r.follow->swaps},
        {"late_share", r.ticks > 0 ? static_cast<double>(r.follow->late_ticks) / static_cast<double>(r.ticks) : 0},
        {"largest_jump_N", r.follow->largest_jump_N},
        {"largest_jump_share", r.follow->largest_jump_share},
        {"longest_swap_us", r.follow->longest_swap_us}};
  for (const RunReport::Organ& organ : r.organs) {
    json["organs"].push_back({{"name", organ.name}, {"contact_force_N", listed(organ.contact_force_N)}});
  }
  if (r.device)
    json["device"] = {{"poses", r.device->poses},
                      {"silences", r.device->silences},
                      {"fades", r.device->fades},
                      {"refused", r.device->refused},
                      {"lowest_energy_J", r.device->lowest_energy_J},
                      {"slipped_m", r.device->slipped_m},
                      {"short_of_force_s", r.device->lacking_s}};
  if (!r.organs.empty()) json["organ_penetration_m"] = r.organ_penetration_m;
  for (const RunReport::Rigid& body : r.rigid) {
    const Json force = listed(body.force_N);
    json["rigid"].push_back({{"name", body.name},
                             {"force_N", force},
                             {"penetration_m", body.penetration_m},
                             {"expected_error", body.expected_error ? Json(*body.expected_error) : Json(nullptr)}});
    if (body.name != skull_name) continue;
    json["skull_force_N"] = force;
    json["skull_penetration_m"] = body.penetration_m;
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpate
