#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "contact/spring_bed.h"
#include "contact/tools/tool_list.h"

using namespace palpate;

namespace {

const ToolShape kTools[] = {{ToolKind::Sphere, 0.01, 0.06, {0.0}},
                            {ToolKind::FlatCylinder, 0.006, 0.06, {0.0}},
                            {ToolKind::Capsule, 0.004, 0.06, {0.0}}};

std::vector<int> allWithin(const SpringBed& bed, const ToolShape& tool, const Pose& pose, double margin) {
  std::vector<int> found;
  for (int v = 0; v < bed.skin.vertexCount(); ++v) {
    const Vec3 x = pose.toLocal(skinPosition(bed.skin, v, bed.u.data()));
    if (toolDistance(tool, x).distance <= margin + kTissueTravel * tool.radius) found.push_back(v);
  }
  return found;
}

std::vector<int> listed(const ContactState& contact) {
  return {contact.vertex.begin(), contact.vertex.begin() + contact.count};
}

SpringBed::Spec fineBed() {
  SpringBed::Spec spec;
  spec.skin_spacing = 0.001;  // 3721 vertices
  return spec;
}

}  // namespace

TEST_CASE("Skin areas add up and clusters hold every vertex once", "[skin]") {
  const SpringBed bed(fineBed());
  const SkinModel& skin = bed.skin;
  CHECK(std::accumulate(skin.area.begin(), skin.area.end(), 0.0) == Approx(0.06 * 0.06).epsilon(1e-12));
  std::vector<int> seen = skin.cluster_vertex;
  std::sort(seen.begin(), seen.end());
  for (int v = 0; v < skin.vertexCount(); ++v) REQUIRE(seen[v] == v);
  REQUIRE(skin.cluster_begin.back() == skin.vertexCount());
  for (int c = 0; c < skin.clusterCount(); ++c) {
    const int size = skin.cluster_begin[c + 1] - skin.cluster_begin[c];
    CHECK(size <= 32);
    CHECK(size >= 16);
    const Vec3& centre = skin.surface.vertices[skin.cluster_representative[c]];
    for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k) {
      const double away = (skin.surface.vertices[skin.cluster_vertex[k]] - centre).norm();
      REQUIRE(away <= skin.cluster_radius[c] * (1.0 + 1e-6));
    }
    CHECK(skin.cluster_radius[c] < 0.008);  // 32 vertices 1 mm apart: compact, not strips
  }
  REQUIRE(skin.regionCount() > 1);
  REQUIRE(skin.region_begin.back() == skin.clusterCount());
  for (int r = 0; r < skin.regionCount(); ++r) {
    REQUIRE(skin.region_begin[r] < skin.region_begin[r + 1]);
    const Vec3& centre = skin.surface.vertices[skin.region_representative[r]];
    for (int k = skin.cluster_begin[skin.region_begin[r]]; k < skin.cluster_begin[skin.region_begin[r + 1]]; ++k)
      REQUIRE((skin.surface.vertices[skin.cluster_vertex[k]] - centre).norm() <= skin.region_radius[r] * (1.0 + 1e-6));
  }
}

TEST_CASE("The broad phase finds what a search of all vertices finds", "[broad-phase]") {
  SpringBed bed(fineBed());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(-0.03, 0.03), height(-0.02, 0.02), unit(-1.0, 1.0);
  int nonempty = 0;
  for (int trial = 0; trial < 300; ++trial) {
    // Random smooth bumps; every third trial the whole skin is stretched to twice its size.
    const double stretch = trial % 3 == 0 ? 1.0 : 0.0;
    const Vec3 wave = 200.0 * Vec3(unit(random), unit(random), 0.0),
               amplitude = 0.003 * Vec3(unit(random), unit(random), unit(random));
    for (int i = 0; i < bed.side * bed.side; ++i) {
      const double h = bed.spec.node_spacing;
      const Vec3 X = h * Vec3(i % bed.side - 0.5 * (bed.side - 1), i / bed.side - 0.5 * (bed.side - 1), 0.0);
      bed.u[i] = toFloat4(stretch > 0.0 ? Vec3(stretch * X) : Vec3(amplitude * std::sin(wave.dot(X))));
    }
    const ToolShape& tool = kTools[trial % 3 == 0 ? (trial / 3) % 3 : trial % 3];
    Pose pose;
    pose.position = {side(random), side(random), height(random)};
    pose.orientation = Quat(unit(random), unit(random), unit(random), unit(random)).normalized();
    const double margin = 0.002 * (trial % 2);
    ContactState contact = makeContactState(bed.skin, tool);
    findContactCandidates(bed.skin, bed.u.data(), tool, pose, margin, contact, bed.scratch);
    REQUIRE(listed(contact) == allWithin(bed, tool, pose, margin));
    CHECK_FALSE(contact.overflow);
    nonempty += contact.count > 0 ? 1 : 0;
  }
  CHECK(nonempty > 100);
}

TEST_CASE("Vertices that stay near keep their forces, others start afresh", "[broad-phase]") {
  SpringBed bed(fineBed());
  const ToolShape& tool = kTools[0];
  ContactState contact = makeContactState(bed.skin, tool);
  findContactCandidates(bed.skin, bed.u.data(), tool, tipAt(0.0, 0.0, -0.001), 0.001, contact, bed.scratch);
  const std::vector<int> before = listed(contact);
  for (int k = 0; k < contact.count; ++k) {
    contact.force[k].z = static_cast<float>(-1 - contact.vertex[k]);
    contact.normal[k] = Vec3f(0, 0, -1);
  }
  findContactCandidates(bed.skin, bed.u.data(), tool, tipAt(0.003, 0.0, -0.001), 0.001, contact, bed.scratch);
  int kept = 0;
  for (int k = 0; k < contact.count; ++k) {
    const bool stays = std::binary_search(before.begin(), before.end(), contact.vertex[k]);
    CHECK(contact.force[k].z == (stays ? static_cast<float>(-1 - contact.vertex[k]) : 0.0F));
    CHECK(contact.normal[k].isZero() == !stays);
    kept += stays ? 1 : 0;
  }
  CHECK(kept > 50);
  CHECK(kept < contact.count);
}

TEST_CASE("Too many candidates: the nearest are kept and the overflow is told", "[broad-phase]") {
  SpringBed bed(fineBed());
  const ToolShape& tool = kTools[0];
  const Pose pose = tipAt(0.0, 0.0, -0.003);
  ContactState contact = makeContactState(bed.skin, tool);
  const int all = static_cast<int>(allWithin(bed, tool, pose, 0.002).size());
  const int capacity = all / 2;
  contact.vertex.resize(capacity), contact.force.resize(capacity), contact.normal.resize(capacity);
  bed.scratch.candidate.resize(capacity);
  findContactCandidates(bed.skin, bed.u.data(), tool, pose, 0.002, contact, bed.scratch);
  CHECK(contact.overflow);
  REQUIRE(contact.count == capacity);
  const std::vector<int> kept = listed(contact);
  CHECK(std::is_sorted(kept.begin(), kept.end()));
  auto distance = [&](int v) { return toolDistance(tool, pose.toLocal(bed.skin.surface.vertices[v])).distance; };
  double farthest = -1.0, nearest_dropped = 1.0;
  for (int v : allWithin(bed, tool, pose, 0.002)) {
    if (std::binary_search(kept.begin(), kept.end(), v)) {
      farthest = std::max(farthest, distance(v));
    } else {
      nearest_dropped = std::min(nearest_dropped, distance(v));
    }
  }
  CHECK(farthest <= nearest_dropped + 1e-12);
  // Dropped from where nothing touches before the next search, it is none.
  bed.scratch.candidate.resize(allWithin(bed, tool, pose, -0.5 * kTissueTravel * tool.radius).size());
  REQUIRE(bed.scratch.candidate.size() < allWithin(bed, tool, pose, 0).size());
  findContactCandidates(bed.skin, bed.u.data(), tool, pose, 0, contact, bed.scratch);
  CHECK_FALSE(contact.overflow);
  bed.scratch.candidate.resize(allWithin(bed, tool, pose, -kTissueTravel * tool.radius).size() / 2);
  findContactCandidates(bed.skin, bed.u.data(), tool, pose, 0, contact, bed.scratch);
  CHECK(contact.overflow);
  findContactCandidates(bed.skin, bed.u.data(), tool, tipAt(0.0, 0.0, 0.05), 0.002, contact, bed.scratch);
  CHECK_FALSE(contact.overflow);
  CHECK(contact.count == 0);
}

TEST_CASE("Vertices that are nowhere are not candidates", "[broad-phase]") {
  SpringBed bed(fineBed());
  for (Float4& a : bed.u) a.x = std::numeric_limits<float>::quiet_NaN();
  ContactState contact = makeContactState(bed.skin, kTools[0]);
  findContactCandidates(bed.skin, bed.u.data(), kTools[0], tipAt(0, 0, 0), 0.01, contact, bed.scratch);
  CHECK(contact.count == 0);
}
