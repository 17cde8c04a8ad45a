#include "imaging/repair_surface.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "base/input_error.h"
#include "base/parallel_for.h"
#include "discretization/surface/polygon_triangles.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/damaged_surfaces.h"
#include "imaging/signed_field.h"
#include "imaging/surface_distance.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

namespace {

/// Repairs, coarsely where it makes the surface anew, and holds what comes out to what checkSurface asks.
RepairedSurface repaired(const TriangleSurface& damaged) {
  RepairOptions coarse;
  coarse.body_nodes = 150;
  RepairedSurface result = repairSurface(damaged, {}, coarse);
  REQUIRE_NOTHROW(checkSurface(result.surface));
  return result;
}

TriangleSurface ballOf(double radius, double edge) { return ellipsoidSurface(Vec3::Constant(radius), edge); }

void turnAll(TriangleSurface& surface) {
  for (auto& t : surface.triangles) std::swap(t[1], t[2]);
}

double volumeOf(const TriangleSurface& surface) { return signedVolume(surface); }

}  // namespace

TEST_CASE("A surface that bounds a solid is kept as it is", "[imaging][repair]") {
  for (const test::NamedSurface& body : test::testBodies()) {
    INFO(body.name);
    const RepairedSurface kept = repaired(body.surface);
    CHECK(kept.report.changedNothing());
    CHECK(kept.surface.vertices == body.surface.vertices);
    CHECK(kept.surface.triangles == body.surface.triangles);
    CHECK(kept.report.parts == (body.name == "shell" || body.name == "two balls" ? 2 : 1));
    CHECK(kept.report.cavities == (body.name == "shell" ? 1 : 0));
  }
}

TEST_CASE("Each kind of damage at three sizes is repaired, and most of it face by face", "[imaging][repair][whole]") {
  const test::NamedSurface body = test::testBodies()[0];
  int mended = 0, cases = 0;
  for (const test::Damage& damage : test::allDamage()) {
    for (int size = 0; size < 3; ++size) {
      INFO(damage.name << " " << size);
      std::mt19937 random(7);
      TriangleSurface surface = body.surface;
      damage.apply(surface, size, random);
      const RepairedSurface result = repaired(surface);
      if (damage.name != "spikes") CHECK(!result.report.lines().empty());  // a few spikes alone pierce nothing
      CHECK(volumeOf(result.surface) > 0.95 * body.volume);
      if (damage.name != "overlap") CHECK(volumeOf(result.surface) < 1.05 * body.volume);
      ++cases;
      if (result.report.resampled()) continue;
      ++mended;
      // What was not damaged is where it was.
      const SurfaceTree tree(result.surface);
      int same = 0;
      for (const Vec3& x : body.surface.vertices) same += tree.closest(x).distance < 2e-3 ? 1 : 0;
      CHECK(same > 0.85 * static_cast<double>(body.surface.vertices.size()));
    }
  }
  CHECK(cases == 39);
  CHECK(mended >= 34);  // not: many spikes, large overlaps
}

TEST_CASE("Combinations of damage are repaired", "[imaging][repair]") {
  const auto bodies = test::testBodies();
  const auto& all = test::allDamage();
  const int kinds = static_cast<int>(all.size());
  int made_anew = 0;
  for (int k = 0; k < 10; ++k) {
    const test::NamedSurface& body = bodies[static_cast<std::size_t>(k) % bodies.size()];
    TriangleSurface surface = body.surface;
    std::mt19937 random(static_cast<unsigned>(k));
    std::string names = body.name;
    for (const int d : {k % kinds, (3 * k + 4) % kinds, (5 * k + 1) % kinds}) {
      all[static_cast<std::size_t>(d)].apply(surface, k % 2, random);
      names += ", " + all[static_cast<std::size_t>(d)].name;
    }
    INFO(names);
    const RepairedSurface result = repaired(surface);
    made_anew += result.report.resampled() ? 1 : 0;
    CHECK(volumeOf(result.surface) / body.volume == Approx(1).margin(0.15));
  }
  CHECK(made_anew > 0);
}

TEST_CASE("What was repaired is counted", "[imaging][repair]") {
  TriangleSurface surface = ballOf(1, 0.3);
  const int count = static_cast<int>(surface.triangles.size());
  SECTION("doubled") {
    for (int k = 0; k < 3; ++k) surface.triangles.push_back(surface.triangles[static_cast<std::size_t>(5 * k)]);
    CHECK(repaired(surface).report.doubled_faces == 3);
  }
  SECTION("turned") {
    for (int k = 0; k < 4; ++k)
      std::swap(surface.triangles[static_cast<std::size_t>(7 * k)][0],
                surface.triangles[static_cast<std::size_t>(7 * k)][1]);
    CHECK(repaired(surface).report.turned_faces == 4);
  }
  SECTION("inside out") {
    turnAll(surface);
    const RepairReport report = repaired(surface).report;
    CHECK(report.inside_out);
    CHECK(report.turned_faces == count);
  }
  SECTION("holes") {
    surface.triangles.erase(surface.triangles.begin() + 40);
    surface.triangles.erase(surface.triangles.begin());
    const RepairReport report = repaired(surface).report;
    CHECK(report.holes == 2);
    CHECK(report.hole_edges == 6);
    CHECK_THAT(report.lines().back(), Contains("2 holes (6 open edges): closed"));
  }
  SECTION("small parts") {
    test::append(surface, ballOf(0.1, 0.1), {2, 0, 0});
    const RepairReport report = repaired(surface).report;
    CHECK(report.small_parts == 1);
    CHECK(report.small_volume_share == Approx(1 - volumeOf(ballOf(1, 0.3)) / volumeOf(surface)));
  }
}

TEST_CASE("A closed surface inside is a cavity where it faces inward, and is removed where it does not",
          "[imaging][repair]") {
  const TriangleSurface outer = ballOf(1, 0.25);
  TriangleSurface inward = ballOf(0.5, 0.2);
  turnAll(inward);
  const double ball = volumeOf(outer), hollow = ball + volumeOf(inward);
  for (const bool all_turned : {false, true}) {
    INFO(all_turned);
    TriangleSurface with_cavity = outer, with_shell = outer;
    test::append(with_cavity, inward, Vec3::Zero());
    test::append(with_shell, ballOf(0.5, 0.2), Vec3::Zero());
    if (all_turned) turnAll(with_cavity), turnAll(with_shell);
    const RepairedSurface cavity = repaired(with_cavity), shell = repaired(with_shell);
    CHECK(cavity.report.cavities == 1);
    CHECK(volumeOf(cavity.surface) == Approx(hollow));
    CHECK(shell.report.inner_sheets == 1);
    CHECK(volumeOf(shell.surface) == Approx(ball));
  }
}

TEST_CASE("An open sheet is refused, with what an organ needs", "[imaging][repair][refusal]") {
  const auto isRefused = [](const TriangleSurface& surface) {
    const std::string said = refusal([&] { repaired(surface); });
    CHECK_THAT(said, Contains("does not enclose a volume"));
    CHECK_THAT(said, Contains("cap the opening"));
    CHECK_THAT(said, Contains("solidify"));
  };
  TriangleSurface half = ballOf(1, 0.2), lidless = boxSurface({1, 1, 1}, 0.25), cap = ballOf(1, 0.1);
  const auto removeAbove = [](TriangleSurface& s, double height) {
    std::erase_if(s.triangles, [&](const auto& t) {
      return std::min({s.vertices[t[0]].z(), s.vertices[t[1]].z(), s.vertices[t[2]].z()}) > height - 1e-9;
    });
  };
  removeAbove(half, 0);
  removeAbove(lidless, 1);
  isRefused(half);
  isRefused(lidless);
  isRefused(test::damage::sheet(1, 8));
  // A bust with an open base is not.
  removeAbove(cap, 0.75);
  const RepairedSurface bust = repaired(cap);
  CHECK(bust.report.holes == 1);
  CHECK(volumeOf(bust.surface) > 0.9 * 4 / 3 * M_PI);
}

TEST_CASE("Bodies that overlap are united, within half a cell for 95 % of the union's surface", "[imaging][repair]") {
  TriangleSurface surface = ballOf(1, 0.15);
  const Vec3 other(1.1, 0.2, 0);
  TriangleSurface second = ballOf(0.7, 0.1);
  turnAll(second);  // as files of several parts have them
  test::append(surface, second, other);
  const RepairedSurface result = repaired(surface);
  REQUIRE(result.report.resampled());
  CHECK(result.report.even_triangles);
  CHECK(result.report.turned_faces > 0);
  const SurfaceTree made(result.surface);
  std::vector<Vec3> outside;
  for (const Vec3& x : pointsOn(surface, 3000).x)
    if (x.norm() > 0.999 && (x - other).norm() > 0.699) outside.push_back(x);
  CHECK(distanceTo(made, outside).p95 < 0.5 * result.report.cell);
  CHECK(distanceTo(SurfaceTree(surface), pointsOn(result.surface, 3000).x).p95 < 0.5 * result.report.cell);
}

TEST_CASE("Parts that touch face on face become one", "[imaging][repair]") {
  TriangleSurface stacked = boxSurface({2, 2, 1}, 0.7);
  test::append(stacked, boxSurface({1, 1, 1}, 0.3), {0.1, 0, 1});
  CHECK_NOTHROW(checkSurface(stacked));
  const RepairedSurface result = repaired(stacked);
  CHECK(result.report.parts == 1);
  CHECK_THAT(result.report.resampled_because, Contains("touch"));
  CHECK(volumeOf(result.surface) == Approx(5).epsilon(0.05));
}

TEST_CASE("A small part that is joined to a body is kept with it, however little they overlap",
          "[imaging][repair][whole]") {
  const double side = 0.35, height = 4;  // 0.9 % of the base's volume
  for (const double overlap : {0.004, 0.0}) {
    INFO(overlap);
    TriangleSurface surface = boxSurface({6, 6, 1.5}, 0.6);
    test::append(surface, boxSurface({side, side, height}, 0.2), {1, 1, 1.5 - overlap});
    RepairOptions options;
    options.body_nodes = 2000;
    const RepairedSurface result = repairSurface(surface, {}, options);
    CHECK(result.report.resampled());
    CHECK(result.report.small_parts == 0);
    CHECK(result.report.parts == 1);
    CHECK(boundingBox(result.surface).max().z() > 1.5 + height - 0.2);
  }
  // What does not touch the body is another part, and too small for one.
  TriangleSurface apart = boxSurface({6, 6, 1.5}, 0.6);
  test::append(apart, boxSurface({side, side, height}, 0.2), {1, 1, 1.51});
  CHECK(repaired(apart).report.small_parts == 1);
  // One too thin to be united is no reason to make all anew.
  TriangleSurface fin = boxSurface({6, 6, 1.5}, 0.6);
  test::append(fin, boxSurface({2, 0.02, 2}, 0.5), {0, 0, 1});
  const RepairReport report = repaired(fin).report;
  CHECK(report.thin_parts == 1);
  CHECK(!report.resampled());
  CHECK_THAT(report.lines().back(), Contains("1 part joined to the body, but too thin"));
}

TEST_CASE("Bodies that little joins are not cut apart with the faces that pierce", "[imaging][repair]") {
  TriangleSurface surface = ballOf(1, 0.12);
  test::append(surface, ballOf(0.5, 0.1), {1.48, 0, 0});
  const RepairedSurface result = repaired(surface);
  CHECK(result.report.piercing_faces == 0);
  CHECK(result.report.parts == 1);
}

TEST_CASE("Vertices far off all others are left out and counted, a tip is not", "[imaging][repair]") {
  const TriangleSurface ball = ballOf(1, 0.2);
  SECTION("one of the surface's own") {
    TriangleSurface surface = ball;
    surface.vertices[40] = Vec3(70, 0, 0);
    const RepairedSurface result = repaired(surface);
    CHECK(result.report.stray_vertices == 1);
    CHECK(result.report.stray_sizes == Approx(35).epsilon(0.1));
    CHECK(result.report.holes == 1);
    CHECK(volumeOf(result.surface) == Approx(volumeOf(ball)).epsilon(0.02));
    CHECK_THAT(result.report.lines().front(), Contains("1 stray vertex, up to 3"));
  }
  SECTION("a face too many") {
    TriangleSurface surface = ball;
    surface.vertices.emplace_back(0, 9, 0);
    surface.triangles.push_back({3, 9, static_cast<int>(surface.vertices.size()) - 1});
    const RepairedSurface result = repaired(surface);
    CHECK(result.report.stray_faces == 1);
    CHECK(result.surface.triangles == ball.triangles);
  }
  SECTION("a needle on a broad base") {
    TriangleSurface cone;
    constexpr int count = 400;
    cone.vertices = {{0, 0, 0}, {0, 0, 30}};
    for (int k = 0; k < count; ++k)
      cone.vertices.emplace_back(std::cos(2 * M_PI * k / count), std::sin(2 * M_PI * k / count), 0);
    for (int k = 0; k < count; ++k) {
      cone.triangles.push_back({0, 2 + (k + 1) % count, 2 + k});
      cone.triangles.push_back({1, 2 + k, 2 + (k + 1) % count});
    }
    CHECK(repaired(cone).report.changedNothing());
  }
}

TEST_CASE("The field of a surface has its distance, its sign, and the same bits for any number of threads",
          "[imaging][repair]") {
  TriangleSurface surface = ballOf(1, 0.15);
  surface.triangles.erase(surface.triangles.begin() + 100);  // a hole does not matter
  const SurfaceTree tree(surface);
  setup_threads = 1;
  const SampledField one = signedField(tree, 0.1);
  setup_threads = 3;
  const SampledField three = signedField(tree, 0.1);
  setup_threads = 0;
  CHECK(one.value == three.value);
  double off = 0;
  int wrong = 0;
  for (int n = 0; n < static_cast<int>(one.value.size()); ++n) {
    const double exact = one.position(n).norm() - 1;
    if (std::abs(exact) > 0.25)
      wrong += (one.value[n] < 0) != (exact < 0) ? 1 : 0;
    else if ((one.position(n) - surface.vertices[0]).norm() > 0.5)
      off = std::max(off, std::abs(one.value[n] - exact));
  }
  CHECK(wrong == 0);
  CHECK(off < 0.35 * 0.15);  // beside the hole the distance is to its rim; elsewhere chords lie inside the ball
}

TEST_CASE("A concave polygon is cut at its ears, a hole filled by the smallest surface", "[imaging][repair]") {
  const std::vector<Vec3> u = {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  const auto sum = [&](const std::vector<std::array<int, 3>>& triangles, const std::vector<Vec3>& x) {
    double area = 0;
    for (const auto& [a, b, c] : triangles) {
      const Vec3 vector = 0.5 * (x[b] - x[a]).cross(x[c] - x[a]);
      CHECK(vector.z() > 0);
      area += vector.norm();
    }
    return area;
  };
  CutBudget budget;
  CHECK(sum(polygonTriangles(u, budget), u) == Approx(7));
  CHECK(sum(smallestFill(u), u) == Approx(7));
  // Corners on a line are no reason for triangles without area.
  const std::vector<Vec3> flat = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {0, 1, 0}};
  CHECK(sum(polygonTriangles(flat, budget), flat) == Approx(2));
  CHECK(sum(smallestFill(flat), flat) == Approx(2));
  CHECK(budget.visits > CutBudget{}.visits - 200);
}

TEST_CASE("A polygon that runs through itself a thousand times costs no more than was granted", "[imaging][repair]") {
  std::vector<Vec3> star;  // found by damaged inputs: a face of ten thousand corners took minutes
  for (int k = 0; k < 2001; ++k) star.emplace_back(std::cos(2.5 * k), std::sin(2.5 * k), 0);
  CutBudget budget{1'000'000};
  CHECK(polygonTriangles(star, budget).size() == star.size() - 2);
  CHECK(budget.visits <= 0);
  CHECK(budget.visits > -static_cast<std::int64_t>(star.size()));
  CHECK(polygonTriangles(star, budget).front() == std::array<int, 3>{0, 1, 2});  // a fan
}

TEST_CASE("A repair can be ended", "[imaging][repair]") {
  TriangleSurface surface = ballOf(1, 0.2);
  test::append(surface, ballOf(0.7, 0.2), {1, 0, 0});
  struct Ended {};
  RepairOptions options;
  int steps = 0;
  options.progress = [&](const std::string&, double share) {
    CHECK(share <= 1);
    if (++steps == 7) throw Ended();
  };
  CHECK_THROWS_AS(repairSurface(surface, {}, options), Ended);
}

// By hand, for who changes the repair: some minutes.
TEST_CASE("Every kind of damage, and pairs and triples of them, on every body", "[.][matrix]") {
  const char* const only = std::getenv("PALPATE_MATRIX");  // "body damage"
  const std::string wanted = only ? only : "";
  int cases = 0, opened = 0;
  const auto tryOne = [&](const test::NamedSurface& body, const std::vector<std::pair<int, int>>& damage) {
    std::string name = body.name;
    for (const auto& [d, size] : damage) name += ", " + test::allDamage()[d].name + " " + std::to_string(size);
    if (name.find(wanted) == std::string::npos) return;
    TriangleSurface surface = body.surface;
    std::mt19937 random(7);
    for (const auto& [d, size] : damage) test::allDamage()[d].apply(surface, size, random);
    ++cases;
    const auto start = std::chrono::steady_clock::now();
    std::string what;
    double volume = 0;
    try {
      const RepairedSurface result = repairSurface(surface, {});
      checkSurface(result.surface);
      volume = signedVolume(result.surface);
      what = result.report.resampled() ? "anew: " + result.report.resampled_because : "mended";
      if (result.report.resampled() && !result.report.even_triangles) what += " UNEVEN";
      ++opened;
    } catch (const InputError& error) {
      what = std::string("REFUSED ") + error.what();
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double off = volume / body.volume - 1;
    std::printf("%-60s %5.2f s volume %+5.1f %%%s %s\n", name.c_str(), seconds, 100 * off,
                std::abs(off) > 0.08 ? " OFF" : "", what.c_str());
    std::fflush(stdout);
  };
  const auto bodies = test::testBodies();
  const int kinds = static_cast<int>(test::allDamage().size());
  for (const auto& body : bodies)
    for (int d = 0; d < kinds; ++d)
      for (int size = 0; size < 3; ++size) tryOne(body, {{d, size}});
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b)
    for (int d = 0; d < kinds; ++d)
      for (int e = d + 1; e < kinds; ++e) {
        if ((d + e + b) % 5 != 0) continue;
        tryOne(bodies[b], {{d, (d + b) % 3}, {e, (e + b) % 3}});
        tryOne(bodies[b], {{d, (d + e) % 3}, {e, (e + 1) % 3}, {(d + 2 * e + 1) % kinds, 1}});
      }
  std::cout << opened << " of " << cases << " open\n";
  CHECK(opened == cases);
}
