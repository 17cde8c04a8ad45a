#include <catch2/catch.hpp>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "discretization/bodies.h"
#include "discretization/cloud_statistics.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/surface_geometry.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

int countOnSurface(const NodeCloud& cloud) {
  int count = 0;
  for (std::uint8_t on : cloud.on_surface) count += on;
  return count;
}

bool hasNodeAt(const NodeCloud& cloud, const Vec3& x) {
  for (const Vec3& node : cloud.X) {
    if ((node - x).norm() < 1e-12) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("Clouds keep their spacing, in number and in distance", "[cloud][whole]") {
  for (const bodies::Body& c : bodies::variedBodies()) {
    DYNAMIC_SECTION(c.name) {
      const SurfaceTree tree(c.surface);
      const SpacingField field = uniform(c.h);
      const NodeCloud cloud = makeNodeCloud(tree, field, 1);
      const CloudStatistics statistics = cloudStatistics(cloud, tree, field);
      // The promise is 0.5; well-spread clouds do better than that by much.
      CHECK(statistics.closest > 0.6);
      CHECK(statistics.depth >= 0.5);
      CHECK(statistics.mean_nearest > 0.83);
      CHECK(statistics.mean_nearest < 0.95);

      // The law in the header, with its range of k.
      const double volume = signedVolume(c.surface), area = surfaceArea(c.surface);
      const double k = (static_cast<double>(cloud.X.size()) - volume / (0.7 * std::pow(c.h, 3))) / (area / (c.h * c.h));
      CHECK(k > 0.5);
      CHECK(k < 0.8);
      // A hexagonal lattice of edge h on the surface.
      CHECK(countOnSurface(cloud) * 0.866 * c.h * c.h / area == Approx(1.0).epsilon(0.04));

      for (std::size_t i = 0; i < cloud.X.size(); ++i) {
        const double distance = tree.closest(cloud.X[i]).distance;
        if (cloud.on_surface[i]) {
          REQUIRE(distance < 1e-12);
        } else {
          REQUIRE(tree.inside(cloud.X[i]));
        }
      }
    }
  }
}

TEST_CASE("Corners and sharp edges of a box carry nodes", "[cloud]") {
  const Vec3 size(0.1, 0.08, 0.05);
  const double h = 0.0099;
  const NodeCloud cloud = makeNodeCloud(SurfaceTree(boxSurface(size, 0.02)), uniform(h), 1);
  int along_x = 0;
  for (const Vec3& x : cloud.X) along_x += std::abs(x.y() + size.y() / 2) < 1e-12 && std::abs(x.z()) < 1e-12;
  CHECK(along_x == 11);  // 0.1 / 0.0099 rounds to 10 intervals
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side((corner & 1) - 0.5, ((corner >> 1) & 1) - 0.5, corner >> 2);
    CHECK(hasNodeAt(cloud, side.cwiseProduct(size)));
  }
}

TEST_CASE("The rim of a cylinder carries evenly spaced nodes", "[cloud]") {
  const NodeCloud cloud = makeNodeCloud(SurfaceTree(cylinderSurface(0.04, 0.03, 0.002)), uniform(0.008), 1);
  std::vector<double> angle;
  for (const Vec3& x : cloud.X) {
    if (std::abs(x.z()) < 1e-12 && x.head<2>().norm() > 0.0399) angle.push_back(std::atan2(x.y(), x.x()));
  }
  REQUIRE(angle.size() == 31);  // 2 pi 0.04 / 0.008 = 31.4
  std::sort(angle.begin(), angle.end());
  for (std::size_t k = 1; k < angle.size(); ++k) {
    CHECK(angle[k] - angle[k - 1] == Approx(2 * M_PI / 31).epsilon(0.01));
  }
}

TEST_CASE("The same seed gives the same bits, another one another cloud of the same size",
          "[cloud][determinism][whole]") {
  const SurfaceTree tree(bodies::liverLike());
  const NodeCloud first = makeNodeCloud(tree, uniform(0.012), 7);
  const NodeCloud again = makeNodeCloud(SurfaceTree(bodies::liverLike()), uniform(0.012), 7);
  const NodeCloud other = makeNodeCloud(tree, uniform(0.012), 8);
  CHECK(first.X == again.X);
  CHECK(first.on_surface == again.on_surface);
  CHECK(first.X != other.X);
  CHECK(static_cast<double>(other.X.size()) == Approx(first.X.size()).epsilon(0.02));
}

TEST_CASE("A refined sphere gets the spacing asked for, and the rest keeps its own", "[cloud]") {
  SpacingField field = uniform(0.0125);
  field.refinements.push_back({Vec3(0, 0, 0.1), 0.025, 0.005, 0.03, {}});
  const SurfaceTree tree(boxSurface({0.1, 0.1, 0.1}, 0.05));
  std::vector<double> told;
  const NodeCloud cloud = makeNodeCloud(tree, field, 1, {}, [&](double share) { told.push_back(share); });
  CHECK(told.size() > 100);
  CHECK((std::is_sorted(told.begin(), told.end()) && told.front() >= 0 && told.back() <= 1));
  CHECK_THROWS_AS(makeNodeCloud(tree, field, 1, {}, [](double) { throw std::length_error("enough"); }),
                  std::length_error);
  const CloudStatistics statistics = cloudStatistics(cloud, tree, field);
  CHECK(statistics.closest > 0.6);
  CHECK(statistics.depth >= 0.5);

  const auto meanNearest = [&](auto&& where) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < cloud.X.size(); ++i) {
      if (!where(cloud.X[i])) continue;
      double nearest = 1;
      for (std::size_t j = 0; j < cloud.X.size(); ++j) {
        if (j != i) nearest = std::min(nearest, (cloud.X[j] - cloud.X[i]).norm());
      }
      sum += nearest;
      ++count;
    }
    REQUIRE(count > 20);
    return sum / count;
  };
  const double fine = meanNearest([](const Vec3& x) { return (x - Vec3(0, 0, 0.1)).norm() < 0.02; });
  const double coarse = meanNearest([](const Vec3& x) { return x.z() < 0.03; });
  CHECK(fine == Approx(0.9 * 0.005).epsilon(0.06));
  CHECK(coarse == Approx(0.9 * 0.0125).epsilon(0.06));
}

TEST_CASE("The spacing field blends linearly and is never steeper than its limit", "[cloud]") {
  SpacingField field = uniform(0.010);
  field.refinements.push_back({Vec3::Zero(), 0.02, 0.004, 0, {}});  // blend: 3 x 6 mm
  CHECK(field.at({0.015, 0, 0}) == Approx(0.004));
  CHECK(field.at({0.029, 0, 0}) == Approx(0.007));
  CHECK(field.at({0.039, 0, 0}) == Approx(0.010));
  field.refinements[0].blend = 0.001;  // too narrow: widened to 6 mm / 0.5
  CHECK(field.at({0.026, 0, 0}) == Approx(0.007));
}

TEST_CASE("A body of one spacing's thickness is filled without conflicts", "[cloud]") {
  const SurfaceTree tree(boxSurface({0.1, 0.1, 0.011}, 0.02));
  const SpacingField field = uniform(0.01);
  const NodeCloud cloud = makeNodeCloud(tree, field, 1);
  CHECK(cloudStatistics(cloud, tree, field).closest >= 0.5);
}

TEST_CASE("Spacings that can't be used are refused with the place and what would do", "[cloud][input]") {
  const SurfaceTree tree(boxSurface({0.1, 0.1, 0.015}, 0.05));
  const auto problem = [&](SpacingField field) {
    field.place = {"gel.toml", 4, 11};
    return refusal([&] { makeNodeCloud(tree, field, 1); });
  };
  CHECK_THAT(problem(uniform(0)), Catch::Contains("gel.toml:4:11: the node spacing 0 m is not a positive"));
  CHECK_THAT(problem(uniform(-0.01)), Catch::Contains("not a positive length"));
  CHECK_THAT(problem(uniform(std::numeric_limits<double>::quiet_NaN())), Catch::Contains("not a positive length"));
  CHECK_THAT(problem(uniform(0.02)), Catch::Contains("0.02 m is larger than the body's smallest extent 0.015 m"));
  CHECK_THAT(problem(uniform(1e-5)), Catch::Contains("nodes; use at least 0.0007"));

  SpacingField coarser = uniform(0.01);
  coarser.refinements.push_back({Vec3::Zero(), 0.01, 0.02, 0, {"gel.toml", 9, 1}});
  CHECK_THAT(problem(coarser), Catch::Contains("gel.toml:9:1: the refined spacing 0.02 m"));
  SpacingField tiny = uniform(0.01);
  tiny.refinements.push_back({Vec3::Zero(), 0.01, 1e-6, 0, {"gel.toml", 9, 1}});
  CHECK_THAT(problem(tiny), Catch::Contains("gel.toml:9:1") && Catch::Contains("would need about"));
}
