// What features cost by counts; their times are for `mtled bench --features` on a quiet machine.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/float4.h"
#include "mtled/bench/bare_loop.h"
#include "mtled/bench/bench_features.h"
#include "simulation/build_model.h"
#include "support/realtime_guard.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

FeatureBench tinyBench() {
  return FeatureBench({"tiny", 0.025, 1.9}, [](const std::string&, double) {});
}

const Meter nothing = [] { return 0.0; };

/// The pair that shows what is left of a feature that is off.
FeaturePair& pairOf(FeatureBench& bench, const std::string& name) {
  for (FeaturePair& pair : bench.pairs())
    if (pair.row.name == name && std::isfinite(pair.row.limit)) return pair;
  throw std::logic_error("no such pair: " + name);
}

/// How far a pair's displacements lie apart, m.
struct Apart {
  double largest = 0, most = 0;
};
Apart apartOf(const FeaturePair& pair) {
  const auto &a = pair.with->state().u, &b = pair.without->state().u;
  Apart apart;
  for (std::size_t i = 0; i < a.size(); ++i) {
    apart.largest = std::max(apart.largest, toVec3(a[i]).norm());
    apart.most = std::max(apart.most, (toVec3(a[i]) - toVec3(b[i])).norm());
  }
  return apart;
}

FeatureReport madeUp() {
  FeatureReport report;
  report.no_instructions = "no counter";
  FeatureRow price;
  price.name = "contact";
  price.with_us = 1100;
  price.without_us = 1000;
  price.more = 0.1;
  FeatureRow rest = price;
  rest.more = 0.004;
  rest.limit = 0.01;
  rest.uncertainty = 0.002;
  report.rows = {price, rest};
  return report;
}

}  // namespace

TEST_CASE("No feature allocates or locks in a tick, on or off", "[bench_features]") {
  if (!test::guardAvailable()) return;  // under a sanitizer; the release preset has it
  FeatureBench bench = tinyBench();
  for (FeaturePair& pair : bench.pairs())
    for (FeatureLoop* loop : {pair.with.get(), pair.without.get()}) {
      loop->prepare(3);
      test::startGuard();
      loop->run(3, nothing);
      const test::GuardCounts counts = test::stopGuard();
      INFO(pair.row.name << ", " << (loop == pair.with.get() ? pair.row.with : pair.row.without));
      CHECK(counts.total() == 0);
    }
}

TEST_CASE("A tick with everything off computes what a loop and a kernel do that know nothing of it",
          "[bench_features]") {
  FeatureBench bench = tinyBench();
  FeaturePair& off = pairOf(bench, "contact, friction, pull, Ogden, node patches");
  off.with->run(20, nothing);
  off.without->run(20, nothing);
  CHECK(off.with->state().contact.count == 0);
  const Apart apart = apartOf(off);
  CHECK(apart.largest > 1e-3);
  CHECK(apart.most < 1e-6 * apart.largest);  // float32 rounds, and the compiler fuses multiply-adds elsewhere
  CHECK(off.with->state().step == off.without->state().step);
}

TEST_CASE("Contact without friction presses as contact that knows no friction", "[bench_features]") {
  FeatureBench bench = tinyBench();
  FeaturePair& off = pairOf(bench, "friction");
  off.with->run(50, nothing);
  off.without->run(50, nothing);
  CHECK(off.with->state().contact.contact_count > 0);
  CHECK(off.with->state().contact.contact_count == off.without->state().contact.contact_count);
  const Apart apart = apartOf(off);
  CHECK(apart.largest > 1e-3);
  CHECK(apart.most < 1e-6 * apart.largest);  // float32 rounds
}

TEST_CASE("What is off leaves nothing in the data that a step reads", "[bench_features]") {
  const FeatureBench bench = tinyBench();
  const Model &plain = bench.plain(), &adaptive = bench.adaptive();
  CHECK(plain.kernel.patch_begin.empty());
  CHECK(plain.kernel.patch_weight.empty());
  CHECK(plain.pointCount() == static_cast<int>(plain.cells.size()));  // one point a cell
  CHECK(adaptive.pointCount() > plain.pointCount());
  CHECK(adaptive.nodeCount() == plain.nodeCount());
}

TEST_CASE("The bare loop refuses what it does not know", "[bench_features]") {
  const FeatureBench bench = tinyBench();
  const Model& model = bench.plain();
  Workspace workspace(model, 1);
  State start = initialState(model);
  const double mu = 1000, alpha = 2;
  setMaterial(model, 0, Material::ogden(&mu, &alpha, 1, 1e-5, 1000), start.live);
  CHECK_THROWS_AS(BareLoop(model, workspace, start, BareLoop::Contact::None), std::invalid_argument);
}

TEST_CASE("Every pair is timed, and its ratio is that of its times", "[bench_features][timed][whole]") {
  FeatureBench bench = tinyBench();
  auto& pairs = bench.pairs();
  timePairs(pairs, 0.01, [](double) {});
  for (const FeaturePair& pair : pairs) {
    INFO(pair.row.name);
    CHECK(pair.row.with_us > 0);
    CHECK(pair.row.without_us > 0);
    CHECK(std::isfinite(pair.row.more));
    CHECK(pair.row.uncertainty > 0);
  }
}

TEST_CASE("A feature that is off is judged by instructions where they are counted, else by time; a price is not judged",
          "[bench_features]") {
  FeatureReport report = madeUp();
  CHECK(report.held());
  report.rows[1].more = 0.02;
  CHECK_FALSE(report.held());
  report.rows[1].more_instructions = 0.002;
  CHECK(report.held());
  report.rows[1].more_instructions = 0.011;
  CHECK_FALSE(report.held());
  report.rows[1].more = std::numeric_limits<double>::quiet_NaN();
  report.rows[1].more_instructions = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(report.held());  // nothing was measured
  report.rows[1].more = 0.004;
  CHECK(report.held());
  report.rows[1].uncertainty = 0.006;
  CHECK(report.rows[1].verdict() == "too noisy");
  CHECK_FALSE(report.held());
  CHECK(report.rows[0].verdict().empty());
}

TEST_CASE("A feature report prints both tables and survives as JSON", "[bench_features]") {
  std::ostringstream out;
  printFeatures(out, madeUp());
  CHECK_THAT(out.str(), Contains("when it is on") && Contains("when it is off") && Contains("+10.00 %") &&
                            Contains("+0.40 %") && Contains("held") && Contains("no counter"));
  const auto json = nlohmann::json::parse(jsonOf(madeUp()));
  CHECK(json.at("features").size() == 2);
  CHECK(json.at("features")[0].at("limit").is_null());
  CHECK(json.at("features")[1].at("more") == 0.004);
  CHECK(json.at("features")[1].at("verdict") == "held");
}
