#include "realtime/recording/run_report.h"

#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "realtime/fakes.h"

using namespace palpate;
using nlohmann::json;

TEST_CASE("report.json has the keys that other tools read", "[run_report]") {
  const json report = json::parse(toJson({}));
  for (const char* key : {"scene",
                          "nodes",
                          "integration_points",
                          "mean_support",
                          "cells_per_point",
                          "gradient_precision",
                          "dt_s",
                          "dt_critical_s",
                          "rate_hz",
                          "substeps_per_tick",
                          "ticks",
                          "overruns",
                          "caught_up",
                          "restored_count",
                          "let_go_count",
                          "largest_yield_m",
                          "yielding_seconds",
                          "longest_overrun_streak",
                          "late_ticks",
                          "physics_seconds",
                          "wall_seconds",
                          "realtime_factor",
                          "step_us",
                          "wakeup_late_us",
                          "rt_setup",
                          "threads",
                          "min_J",
                          "volume_change",
                          "peak_force_N",
                          "peak_depth_m",
                          "base_reaction_N",
                          "state_hash",
                          "flags",
                          "setup_seconds",
                          "build"}) {
    INFO(key);
    CHECK(report.contains(key));
  }
  for (const char* key : {"p50", "p99", "p999", "max"}) {
    CHECK(report["step_us"].contains(key));
    CHECK(report["wakeup_late_us"].contains(key));
  }
  CHECK(!report.contains("follow"));
  RunReport following;
  following.ticks = 200;
  following.follow = FollowTotals{3, 50, 120, 0.01, 0.004};
  const json follow = json::parse(toJson(following))["follow"];
  CHECK(follow["swaps"] == 3);
  CHECK(follow["late_share"] == 0.25);
  CHECK(follow["largest_jump_N"] == 0.01);
  CHECK(follow["largest_jump_share"] == 0.004);
  CHECK(follow["longest_swap_us"] == 120);
  for (const char* key : {"scheduling", "memory_lock", "affinity"}) CHECK(report["rt_setup"].contains(key));
  RunReport held;
  held.regions = {{"base", {Vec3(1, 2, 3), Vec3(4, 5, 6)}}};
  const json base = json::parse(toJson(held))["reactions"]["base"];
  CHECK(base["force_N"] == json({1, 2, 3}));
  CHECK(base["moment_Nm"] == json({4, 5, 6}));
}

TEST_CASE("A report tells what the run was", "[run_report]") {
  const Model model = test::smallModel();
  const auto statistics = std::make_unique<DeadlineStatistics>();
  statistics->step.add(500'000);
  statistics->overrun_count = 3;
  statistics->caught_up_count = 1;
  statistics->longest_overrun_streak = 2;
  statistics->late_ticks[1] = 2;
  RunSummary summary;
  summary.ticks = 997;
  summary.totals = {1.994, 2.0, 0.997};
  summary.state_hash = 0xabcULL;
  summary.flags = kInvertedPoints | kDeepContact;
  summary.min_J = -0.5F;
  summary.base_reaction = Vec3(1, 2, 3);
  summary.rt_setup.scheduling = "done: of course";

  const json report = json::parse(toJson(makeRunReport(model, summary, *statistics, 2, 0.01)));
  CHECK(report["scene"] == "small");
  CHECK(report["nodes"] == 4);
  CHECK(report["integration_points"] == 3);
  CHECK(report["substeps_per_tick"] == 4);
  CHECK(report["ticks"] == 997);
  CHECK(report["overruns"] == 3);
  CHECK(report["caught_up"] == 1);
  CHECK(report["longest_overrun_streak"] == 2);
  CHECK(report["late_ticks"]["core_taken"] == 2);
  CHECK(report["realtime_factor"] == 0.997);
  CHECK(report["step_us"]["max"] == 500.0);
  CHECK(report["state_hash"] == "0000000000000abc");
  CHECK(report["flags"] == json({"inverted_points", "deep_contact"}));
  CHECK(report["min_J"] == -0.5);
  CHECK(report["volume_change"] == 0.01);
  CHECK(report["base_reaction_N"] == json({1.0, 2.0, 3.0}));
  CHECK(report["threads"] == 2);
  CHECK(report["rt_setup"]["scheduling"] == "done: of course");
  CHECK(report["build"].get<std::string>().size() > 10);
}

TEST_CASE("A report of a run gone wrong is still JSON", "[run_report]") {
  RunReport broken;
  broken.volume_change = std::numeric_limits<double>::quiet_NaN();
  broken.base_reaction_N.x() = std::numeric_limits<double>::infinity();
  broken.scene = "quote \" and \xff";
  const json report = json::parse(toJson(broken));
  CHECK(report["volume_change"].is_null());
  CHECK(report["base_reaction_N"][0].is_null());
}
