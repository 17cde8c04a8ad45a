#include "contact/samples/face_samples.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "contact/bed_motion.h"
#include "support/realtime_guard.h"

using namespace palpate;

namespace {

/// Stretches a whole bed, nodes and skin.
void stretch(SpringBed& bed, double x, double y) {
  const double h = bed.spec.node_spacing, middle = 0.5 * (bed.side - 1);
  for (int i = 0; i < bed.side * bed.side; ++i)
    bed.u[i] = toFloat4(h * Vec3((x - 1.0) * (i % bed.side - middle), (y - 1.0) * (i / bed.side - middle), 0.0));
}

/// A bed that keeps its stretch: springs pull its nodes up and down only.
SpringBed::Spec stretchable() {
  SpringBed::Spec spec = damped(tissueLike());
  spec.lateral = 0.0;
  spec.tension = 0.0;
  return spec;
}

/// The same little by little, so that the searches can follow.
void stretchSlowly(SpringBed& bed, const ToolShape& tool, double x, double y) {
  constexpr int steps = 60;
  for (int k = 1; k <= steps; ++k) {
    stretch(bed, std::pow(x, static_cast<double>(k) / steps), std::pow(y, static_cast<double>(k) / steps));
    findContactCandidates(bed.skin, bed.u.data(), tool, bed.pose, 0.004, bed.contact, bed.scratch);
    findFaceSamples(bed.skin, bed.u.data(), tool, bed.pose, 0.004, bed.contact, bed.scratch);
  }
}

using Place = std::array<long, 3>;  // in 10 nm

Place placeOf(const Vec3& x) { return {std::lround(1e8 * x.x()), std::lround(1e8 * x.y()), std::lround(1e8 * x.z())}; }

bool isNear(const Place& a, const Place& b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) < 4;
}

/// Where samples should be: on a grid of `pieces` pieces a face without its corners, within `reach` of the tool.
std::vector<Place> expected(const SpringBed& bed, const ToolShape& tool, const Pose& pose, double reach, int pieces) {
  std::set<Place> places;
  for (const auto& corner : bed.skin.surface.triangles) {
    Vec3 x[3];
    for (int c = 0; c < 3; ++c) x[c] = skinPosition(bed.skin, corner[c], bed.u.data());
    for (int a = 0; a <= pieces; ++a) {
      for (int b = 0; a + b <= pieces; ++b) {
        const int c = pieces - a - b;
        if (std::max({a, b, c}) == pieces) continue;
        const Vec3 p = (a * x[0] + b * x[1] + c * x[2]) / pieces;
        if (toolDistance(tool, pose.toLocal(p)).distance <= reach) places.insert(placeOf(p));
      }
    }
  }
  std::vector<Place> all;  // an edge's from both sides, but for rounding
  for (const Place& p : places)
    if (std::none_of(all.begin(), all.end(), [&](const Place& q) { return isNear(p, q); })) all.push_back(p);
  return all;
}

}  // namespace

TEST_CASE("The skin's edges join faces and vertices", "[contact][face_samples]") {
  const SpringBed bed(tissueLike());
  const SkinTopology& t = *bed.skin.topology;
  CHECK(bed.skin.vertexCount() - t.edgeCount() + t.faceCount() == 1);  // Euler, of a disc
  REQUIRE(t.face_of.size() == 3 * bed.skin.surface.triangles.size());
  for (int f = 0; f < t.faceCount(); ++f) {
    const auto& corner = bed.skin.surface.triangles[f];
    for (int c = 0; c < 3; ++c) {
      const auto& ends = t.edge[t.face_edge[f][c]];
      REQUIRE(ends[0] < ends[1]);
      REQUIRE(std::set<int>{corner[c], ends[0], ends[1]} == std::set<int>(corner.begin(), corner.end()));
      const double length = (bed.skin.surface.vertices[ends[0]] - bed.skin.surface.vertices[ends[1]]).norm();
      REQUIRE(t.edge_length[t.face_edge[f][c]] == Approx(length).epsilon(1e-6));
      const auto first = t.face_of.begin() + t.face_begin[corner[c]],
                 last = t.face_of.begin() + t.face_begin[corner[c] + 1];
      REQUIRE(std::count(first, last, f) == 1);
      REQUIRE(ends[0] < bed.skin.vertexCount());
      const int e = t.face_edge[f][c];
      REQUIRE((t.edge_begin[ends[0]] <= e && e < t.edge_begin[ends[0] + 1]));
    }
  }
}

TEST_CASE("Stretched skin gets samples where its vertices have spread, and only there", "[contact][face_samples]") {
  struct Case {
    double stretch;
    int pieces;  // of an edge
  };
  const ToolShape tool = toolOf(ToolKind::Sphere);
  for (const Case& c : {Case{1.0, 1}, {1.49, 1}, {1.51, 2}, {2.9, 2}, {3.1, 4}, {5.9, 4}, {6.1, 8}, {9.0, 8}}) {
    CAPTURE(c.stretch);
    SpringBed bed(stretchable());
    const Pose pose = tipAt(0.0003, 0.0007, -0.001);
    bed.place(tool, pose);
    stretchSlowly(bed, tool, c.stretch, c.stretch);
    const FaceSamples& samples = bed.contact.samples;
    CHECK_FALSE(bed.contact.overflow);
    CHECK(std::is_sorted(samples.id.begin(), samples.id.begin() + samples.count));
    std::vector<Place> found;
    for (int k = 0; k < samples.count; ++k) {
      found.push_back(placeOf(skinPosition(bed.skin, samples.point[k], bed.u.data())));
      CHECK(samples.area[k] > 0.0F);
      CHECK(samples.lift[k] >= 0.0F);
    }
    const std::vector<Place> wanted = expected(bed, tool, pose, 0.004 + kTissueTravel * tool.radius, c.pieces);
    CHECK(found.size() == wanted.size());
    for (const Place& p : wanted)
      REQUIRE(std::any_of(found.begin(), found.end(), [&](const Place& q) { return isNear(p, q); }));
    CHECK(found.empty() == (c.pieces == 1));
  }
}

TEST_CASE("A ball can't pass between the vertices of stretched skin, and is dragged over it smoothly",
          "[contact][face_samples]") {
  // Edges of 2.5 mm are stretched to 20 mm; a ball with a radius of 7.5 mm stands over the middle of a face.
  const ToolShape tool = toolOf(ToolKind::Sphere, 0.0075);
  SpringBed::Spec spec = stretchable();
  spec.tool_radius = tool.radius;
  SpringBed bed(spec);
  bed.place(tool, tipAt(0.0, 0.0, 0.001));
  stretchSlowly(bed, tool, 8.0, 8.0);
  const auto& corner = bed.skin.surface.triangles[bed.skin.surface.triangles.size() / 2 + 12];
  Vec3 middle = Vec3::Zero();
  for (const int v : corner) middle += skinPosition(bed.skin, v, bed.u.data()) / 3.0;
  bed.pose = tipAt(middle.x(), middle.y(), 0.001);
  double peak = 0.0, change = 0.0, dragged_change = 0.0, least = 1.0;
  Vec3 last = Vec3::Zero(), velocity = Vec3::Zero();
  for (const Vec3& wanted : {Vec3(0.01 * kDown), Vec3(0.01 * Vec3(0.8, 0.6, 0.0))}) {
    const Vec3 from = velocity;
    for (int k = 0; k < 500; ++k) {  // 10 mm in, 10 mm across
      velocity = from + std::min(1.0, k / 25.0) * (wanted - from);
      const Vec3 force = move(bed, tool, 1, velocity);
      const bool drags = wanted.x() > 0.0;
      (drags ? dragged_change : change) = std::max(drags ? dragged_change : change, (force - last).norm());
      peak = std::max(peak, force.norm());
      if (drags) least = std::min(least, force.norm() / peak);
      last = force;
      REQUIRE(bed.contact.max_penetration < 0.2 * tool.radius);
    }
  }
  std::printf(
      "stretched bed: peak %.3f N, worst tick: in %.2f across %.2f %%, least force %.2f of the peak, %d points\n", peak,
      100 * change / peak, 100 * dragged_change / peak, least, bed.contact.contact_count);
  CHECK(dragged_change < 0.03 * peak);
  CHECK(least > 0.5);
  // No face is deep in the ball.
  const Vec3 centre = bed.pose.toWorld({0, 0, tool.radius});
  for (const auto& face : bed.skin.surface.triangles) {
    for (int a = 0; a <= 16; ++a) {
      for (int b = 0; a + b <= 16; ++b) {
        const Vec3 x =
            (a * skinPosition(bed.skin, face[0], bed.u.data()) + b * skinPosition(bed.skin, face[1], bed.u.data()) +
             (16 - a - b) * skinPosition(bed.skin, face[2], bed.u.data())) /
            16.0;
        REQUIRE((x - centre).norm() > 0.7 * tool.radius);
      }
    }
  }
}

TEST_CASE("Forces on samples reach the nodes whole", "[contact][face_samples]") {
  const ToolShape tool = toolOf(ToolKind::FlatCylinder);
  SpringBed bed(stretchable());
  bed.place(tool, tipAt(0.001, 0.002, 0.0002));
  stretchSlowly(bed, tool, 4.0, 2.0);
  Vec3 force = move(bed, tool, 100, 0.01 * kDown);
  REQUIRE(bed.contact.samples.count > 50);
  // In a step, what the nodes' momenta change by beside the springs' is the tool's force.
  const AlignedVector<Float4> u = bed.u, du = bed.du;
  const double h = bed.spec.dt, c = bed.spec.damping, alpha = 2.0 * h * h / (2.0 + c * h),
               beta = (2.0 - c * h) / (2.0 + c * h);
  Vec3 springs = Vec3::Zero();
  for (int i = 0; i < bed.side * bed.side; ++i) springs += bed.springForce(i);
  force = bed.step(tool, tipAt(0.001, 0.002, bed.pose.position.z() - 2e-6));
  Vec3 gained = Vec3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) gained += toVec3(bed.du[i]) - beta * toVec3(du[i]);
  const Vec3 on_tissue = bed.mass / alpha * gained - springs;
  CHECK(force.norm() > 0.01);
  CHECK((on_tissue + force).norm() < 1e-3 * force.norm());
}

TEST_CASE("More samples than there is memory for are told, and nothing is allocated", "[contact][face_samples]") {
  SpringBed::Spec spec = stretchable();
  spec.skin_spacing = 0.001;
  SpringBed bed(spec);
  const ToolShape tool = toolOf(ToolKind::FlatCylinder, 0.03);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
  stretchSlowly(bed, tool, 6.5, 6.5);
  if (test::guardAvailable()) test::startGuard();
  for (int k = 0; k < 3; ++k) bed.tick(tool, tipAt(0.0003, 0.0007, 0.001 - 0.0005 * k), 2, 0.3);
  CHECK((!test::guardAvailable() || test::stopGuard().total() == 0));
  CHECK(bed.contact.overflow);
  CHECK(bed.contact.samples.count == static_cast<int>(bed.contact.samples.id.size()));
  CHECK(allFinite(bed.u));
}
