#include "mtled/bench/bench_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mechanics/internal_forces.h"
#include "mtled/bench/bench_run.h"
#include "mtled/bench/kernel_cost.h"
#include "mtled/bench/plain_kernel.h"
#include "mtled/bench/roofline.h"
#include "mtled/bench/timing.h"
#include "support/temp_folder.h"
#include "support/test_body.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Four points with the same five nodes: one block of two groups in a batch of 16, of which 12 points are padding.
struct TinyBody {
  ShapeTable shape;
  std::vector<Vec3> X{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 1)};
  std::vector<Vec3> point_X;
  std::vector<double> volume = std::vector<double>(4, 1.0);
  std::vector<int> point_material = std::vector<int>(4, 0);
  std::vector<Material> materials{Material::neoHookean(3000, 0.49, 1000)};
  NodePatches patches;
  TinyBody() {
    shape.begin = {0};
    for (int q = 0; q < 4; ++q) {
      point_X.emplace_back(q, 0, 0);
      for (int n = 0; n < 5; ++n) {
        shape.node.push_back(n);
        shape.gradN.emplace_back(n - 2, 0, 0);
      }
      shape.begin.push_back(static_cast<int>(shape.node.size()));
      patches.node.push_back({0, 1, 2, 3});
      patches.weight.push_back({0.25, 0.25, 0.25, 0.25});
    }
    patches.volume = patches.bulk_modulus = {1, 1, 1, 1, 0};
  }
  template <class Real>
  KernelCost cost(const NodePatches& with = {}, GradientPrecision precision = GradientPrecision::Float32) const {
    return blockKernelCost(
        makeKernelLayout<Real>(shape, point_X, volume, point_material, materials, 5, with, precision, X), shape);
  }
};

/// Ceilings as if measured: 100 GFLOP/s on each instruction set and thread, L2 of 1 MB, no L3.
Ceilings ceilingsOf(int threads) {
  return {threads, {100.0 * threads, 100.0 * threads, 100.0 * threads}, {{"L2", 1000000, 50}, {"DRAM", 0, 10}}};
}

BenchRow rowOf(const std::string& kernel, const std::string& precision, int threads, double ns) {
  BenchRow row;
  row.kernel = kernel;
  row.precision = precision;
  row.instruction_set = nameOf(InstructionSet::Avx512);
  row.threads = threads;
  row.best_ns = row.median_ns = ns;
  row.error_limit = 1e-6;
  row.ceiling = "L3";
  row.ceiling_ns = 20;
  row.share = 20 / ns;
  return row;
}

/// A report whose float32 kernel keeps all promises at 50 ns.
BenchReport goodReport() {
  BenchReport report;
  report.build = "build";
  report.machine = {"processor", 2, 1 << 20, 32 << 20};
  report.ceilings = {ceilingsOf(1), ceilingsOf(2)};
  report.bodies = {{"5k", 4922, 25562, 28.9, 3.0, {}}};
  report.bodies[0].rows = {rowOf("plain Eigen", "double", 1, 260), rowOf("blocks", "float32", 1, 40),
                           rowOf("blocks", "float32", 2, 22), rowOf("blocks, node patches", "float32", 1, 54),
                           rowOf("blocks, node patches", "float32", 2, 30)};
  return report;
}

std::string verdict(const BenchReport& report, const std::string& quantity) {
  for (const Verdict& v : verdictsOf(report))
    if (v.bound.quantity == quantity) return v.text();
  throw std::logic_error("no such promise: " + quantity);
}

}  // namespace

TEST_CASE("Bytes and flops of the block kernel are those counted by hand", "[bench_command]") {
  const TinyBody body;
  // Two groups of 48 gradients and of 4 node numbers, 4 blocks, 16 volumes, 1 material; 5 nodes' u and f.
  const double tables = 2 * 48 * 4 + 8 * 2 + 4 * sizeof(PointBlock), vectors = 2 * 5 * 16;
  const KernelCost plain = body.cost<float>();
  CHECK(plain.streamed_bytes == tables + 16 * 4 + 4 + vectors);
  CHECK(plain.working_set == plain.streamed_bytes);
  CHECK(plain.useful_flops == 4 * (36 * 5 + 95));
  CHECK(plain.executed_flops == 2 * 592 + 4 * 108 + 16 * 140);

  // Twice the tables; gradients of F and J - 1 written and read; 16 shares with their points in 5 patches; nodes and
  // weights of
  // 64 corners; pressures written and read, bulk moduli read.
  const KernelCost patched = body.cost<float>(body.patches);
  const double tensors = 9 * 16 * 4, dilatation = 16 * 4, shares = 16 * (4 + 4) + 6 * 4, corners = 64 * (4 + 4),
               patch = 5 * 4;
  CHECK(patched.streamed_bytes ==
        plain.streamed_bytes + tables + 2 * (tensors + dilatation) + shares + corners + 3 * patch);
  CHECK(patched.working_set == plain.working_set + tensors + dilatation + shares + corners + 2 * patch);
  CHECK(patched.useful_flops == plain.useful_flops);
  CHECK(patched.executed_flops == plain.executed_flops + 16 * 42);

  // 16-bit: of two groups, one in float for each block, padding too, and one of 2 bytes; 3 scales for 16 points.
  const KernelCost rounded = body.cost<float>({}, GradientPrecision::Int16);
  CHECK(rounded.streamed_bytes == plain.streamed_bytes - 2 * 48 * 4 + (4 * 48 * 4 + 48 * 2) + 48 * 4);
  CHECK(rounded.useful_flops == plain.useful_flops);
  CHECK(rounded.executed_flops == plain.executed_flops + 16 * 18);

  // Only what is a number doubles: blocks and the material stay, and node numbers have 4 bytes in double.
  CHECK(body.cost<double>().streamed_bytes == 2 * plain.streamed_bytes - (4 * sizeof(PointBlock) + 4));
}

TEST_CASE("The plain Eigen kernel equals the reference on any number of threads", "[bench_command]") {
  const test::TestBody body(5, 0.1, 1);
  const auto u = benchDisplacement(body.X);
  std::vector<Vec3> exact, f;
  referenceInternalForces(body.shape, body.volume, body.point_material, body.materials, u, exact);
  std::vector<int> order;
  for (int q = body.shape.rowCount(); q-- > 0;) order.insert(order.end(), {q, -1});  // any order, with padding
  PlainKernel kernel(order, body.shape, body.volume, body.materials[0]);
  for (const int threads : {1, 3, 2}) {
    SpinTeam team(threads);
    kernel.forces(u, f, team);
    double error = 0, norm = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      error += (f[i] - exact[i]).squaredNorm();
      norm += exact[i].squaredNorm();
    }
    REQUIRE(norm > 0);
    CHECK(std::sqrt(error / norm) < 1e-12);  // rounding, times K/mu = 50
  }

  const double mu = 1000, alpha = 2;
  const Material ogden = Material::ogden(&mu, &alpha, 1, 1e-5, 1000);
  CHECK_THROWS_AS(PlainKernel(order, body.shape, body.volume, ogden), std::invalid_argument);
}

TEST_CASE("Calls are timed in turns, the first of each turn not counted", "[bench_command][timed]") {
  SpinTeam team(1);
  int first = 0, second = 0;
  std::vector<TimedCall> calls(2);
  calls[0] = {&team, [&] { ++first; }};
  calls[1] = {&team, [&] { ++second; }};
  timeInTurns(calls, 0.001);
  CHECK(calls[0].seconds.size() + 3 == static_cast<std::size_t>(first));
  CHECK(calls[1].seconds.size() + 3 == static_cast<std::size_t>(second));
  CHECK(calls[0].seconds.size() >= 3);

  calls[0].seconds = {5, 1, 3};
  CHECK(calls[0].best() == 1);
  CHECK(calls[0].median() == 3);
  CHECK(std::isnan(TimedCall().best()));
  CHECK(std::isnan(TimedCall().median()));
}

TEST_CASE("Ceilings are of this world: positive, and not those of loops that were optimised away",
          "[bench_command][timed]") {
  Machine machine = thisMachine();
  CHECK(machine.cores >= 1);
  machine.l2_bytes = 256 << 10;  // any sizes will do here
  machine.l3_bytes = 4 << 20;
  const auto ceilings = measureCeilings(machine, {1, 2}, 0.001);
  REQUIRE(ceilings.size() == 2);
  for (const Ceilings& c : ceilings) {
    for (const InstructionSet set : supportedInstructionSets()) {
      const double gflops = c.fma_gflops[static_cast<std::size_t>(set)];
      CHECK(gflops > 0);
      CHECK(gflops < 1000.0 * c.threads);  // two units of 16 lanes at 7 GHz do 448
    }
    REQUIRE(c.levels.size() == 3);
    for (const MemoryLevel& level : c.levels) {
      CHECK(level.gb_per_s > 0);
      CHECK(level.gb_per_s < 1000.0 * c.threads);  // two loads of 64 bytes a cycle at 7 GHz are 896
    }
    CHECK(c.levels[0].capacity == machine.l2_bytes * c.threads);
    CHECK(c.levels[2].capacity == 0);
    CHECK(c.levelOf(1000).name == "L2");
    CHECK(c.levelOf(3e6).name == "L3");
    CHECK(c.levelOf(1e9).name == "DRAM");
  }

  machine.l2_bytes = machine.l3_bytes = 0;  // a machine that does not say
  const auto unknown = measureCeilings(machine, {1}, 0.001);
  REQUIRE(unknown[0].levels.size() == 1);
  CHECK(unknown[0].levelOf(1).name == "DRAM");
}

TEST_CASE("Thread counts are powers of two and all cores", "[bench_command]") {
  CHECK(benchThreadCounts(1) == std::vector<int>{1});
  CHECK(benchThreadCounts(2) == std::vector<int>{1, 2});
  CHECK(benchThreadCounts(6) == std::vector<int>{1, 2, 4, 6});
}

TEST_CASE("A body's kernels agree with the reference and have times and ceilings", "[bench_command][timed]") {
  const BenchBodyResult body = benchBody({"tiny", 0.025, 1.9}, {ceilingsOf(1), ceilingsOf(2)}, 0.001, true);
  CHECK(body.nodes > 50);
  CHECK(body.points > body.nodes);
  CHECK(body.setup_seconds > 0);
  std::size_t kernels = 0;
  for (const BenchRow& row : body.rows) {
    INFO(row.kernel << ", " << row.precision << ", " << row.threads << " threads: error " << row.force_error);
    CHECK(row.best_ns > 0);
    CHECK(row.median_ns >= row.best_ns);
    CHECK(std::isfinite(row.median_ns));
    if (row.kernel == "whole step") continue;
    ++kernels;
    CHECK(row.force_error <= row.error_limit);
    CHECK_FALSE(row.wrong());
    if (row.kernel == "ten-line reference") continue;
    CHECK(row.executed_flops >= row.useful_flops);
    CHECK(row.useful_flops == Approx(36 * body.mean_support + 95));
    CHECK(row.gb_per_s == Approx(row.bytes / row.best_ns));
    // The lower of both ceilings, which the test made up: 50 or 100 GFLOP/s a thread, 50 GB/s.
    const double by_arithmetic = row.useful_flops / ((row.precision == "double" ? 50 : 100) * row.threads);
    const double working_set = row.bytes * body.points;
    CHECK(row.ceiling_ns >= Approx(by_arithmetic));
    if (working_set < 9e5 && row.kernel != "blocks, node patches")
      CHECK(row.ceiling_ns == Approx(std::max(by_arithmetic, row.bytes / 50)));
    CHECK(row.share == Approx(row.ceiling_ns / row.best_ns));
  }
  // The reference; two thread counts of the plain kernel and of the blocks in double; of those in float32 and with
  // 16-bit gradients without and with patches; these without patches once for each narrower instruction set.
  CHECK(kernels == 1 + 2 + 2 + 2 * (2 + 2 + supportedInstructionSets().size() - 1));
  const char* widest = nameOf(supportedInstructionSets().back());
  for (const int threads : {1, 2}) {
    CHECK(body.plain(threads) != nullptr);
    for (const char* kernel : {"blocks", "blocks, node patches"})
      for (const char* precision : {"float32", "int16"})
        CHECK(body.find(kernel, precision, widest, threads) != nullptr);
    CHECK(body.find("whole step", "float32", nameOf(chosenInstructionSet()), threads) != nullptr);
  }
  CHECK(body.find("blocks", "float32", widest, 3) == nullptr);
  for (const InstructionSet set : supportedInstructionSets())
    CHECK(body.find("blocks", "int16", nameOf(set), 1) != nullptr);
}

TEST_CASE("Promises are held, missed or not measured", "[bench_command]") {
  BenchReport report = goodReport();
  CHECK(verdict(report, "float32, one core") == "held");
  CHECK(verdict(report, "int16, one core") == "not measured");
  CHECK(verdict(report, "node patches, float32, one core") == "held");
  CHECK(verdict(report, "two threads, float32") == "held");
  CHECK(verdict(report, "two threads, float32, node patches") == "held");
  CHECK(verdict(report, "float32 beside the plain double kernel") == "held");
  CHECK(verdict(report, "float32, time over what the ceiling allows") == "held");
  CHECK(benchExitCode(report, true) == 0);

  BenchReport slow = report;
  slow.bodies[0].rows[1] = rowOf("blocks", "float32", 1, 61);
  slow.bodies[0].rows[2] = rowOf("blocks", "float32", 2, 40);
  slow.bodies[0].rows[3] = rowOf("blocks, node patches", "float32", 1, 90);
  CHECK(verdict(slow, "float32, one core") == "missed");
  CHECK(verdict(slow, "node patches, float32, one core") == "missed");
  CHECK(verdict(slow, "two threads, float32") == "missed");
  CHECK(verdict(slow, "float32 beside the plain double kernel") == "missed");
  CHECK(verdict(slow, "float32, time over what the ceiling allows") == "missed");
  CHECK(benchExitCode(slow, false) == 0);
  CHECK(benchExitCode(slow, true) == 1);

  for (BenchRow& row : report.bodies[0].rows) row.instruction_set = nameOf(InstructionSet::Avx2);
  CHECK(verdict(report, "float32, one core") == "not measured");  // promised of AVX-512
  CHECK(verdict(report, "float32 beside the plain double kernel") == "held");
  report.bodies[0].nodes = 1000;
  for (const Verdict& v : verdictsOf(report)) CHECK(v.text() == "not measured");
}

TEST_CASE("A kernel with wrong forces fails the benchmark whatever its speed", "[bench_command]") {
  for (const double error : {2e-6, std::numeric_limits<double>::infinity()}) {
    BenchReport report = goodReport();
    report.bodies[0].rows[2].force_error = error;
    CHECK_FALSE(report.right());
    CHECK(benchExitCode(report, false) == 1);
    std::ostringstream out;
    printBody(out, report.bodies[0]);
    CHECK_THAT(out.str(), Contains("WRONG"));
  }
  std::ostringstream out;
  printMachine(out, goodReport());
  printBody(out, goodReport().bodies[0]);
  printVerdicts(out, goodReport());
  CHECK_THAT(out.str(), !Contains("WRONG") && Contains("FMA") && Contains("DRAM") && Contains("held"));
}

TEST_CASE("The roofline has its roofs where the ceilings are and a point per row of one thread", "[bench_command]") {
  BenchReport report = goodReport();
  for (BenchRow& row : report.bodies[0].rows) {
    row.bytes = 500;
    row.useful_flops = 1000;
    row.gflop_per_s = 1000 / row.best_ns;
  }
  const Figure figure = rooflineOf(report);
  REQUIRE(figure.series.size() == 3);
  CHECK(figure.series[0].label == "L2 roof");
  CHECK(figure.series[0].x[1] == 2);  // 100 GFLOP/s over 50 GB/s
  CHECK(figure.series[0].y == std::vector<double>{25, 100, 100});
  CHECK(figure.series[1].x[1] == 10);  // over 10 GB/s
  CHECK(figure.series[1].y == std::vector<double>{5, 100, 100});
  CHECK(figure.series[2].x == std::vector<double>{2, 2, 2});
  CHECK(figure.series[2].y == std::vector<double>{1000.0 / 260, 25, 1000.0 / 54});
}

TEST_CASE("A benchmark in JSON holds what was measured", "[bench_command]") {
  BenchReport report = goodReport();
  report.command = "mtled bench";
  report.bodies[0].rows[0].bytes = not_a_number;
  report.bodies[0].rows[1].force_error = 1.0 / 3;
  const auto json = nlohmann::json::parse(jsonOf(report));
  CHECK(json.at("machine").at("processor") == "processor");
  CHECK(json.at("ceilings")[1].at("memory")[0].at("capacity_bytes") == 1000000);
  CHECK(json.at("ceilings")[1].at("fma_float32_gflop_per_s").at(nameOf(InstructionSet::Avx512)) == 200);
  CHECK(json.at("bodies")[0].at("rows")[1].at("force_error") == 1.0 / 3);
  CHECK(json.at("verdicts").size() == verdictsOf(report).size());
  CHECK(json.at("verdicts")[0].at("verdict") == "held");
  CHECK(json.at("bodies")[0].at("rows")[0].at("bytes_per_point").is_null());
}

TEST_CASE("Unusable options of bench are refused before the work", "[bench_command]") {
  for (const double seconds : {-1.0, 61.0, not_a_number}) {
    BenchOptions options;
    options.seconds = seconds;
    CHECK_THAT(refusal([&] { benchCommand(options); }), Contains("--seconds"));
  }
  const TempFolder folder;
  BenchOptions options;
  options.json = folder.path("missing/results.json");
  CHECK_THROWS_WITH(benchCommand(options), Contains("missing/results.json"));
}
