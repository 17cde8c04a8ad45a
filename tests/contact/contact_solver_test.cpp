#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "contact/bed_motion.h"

using namespace palpate;

// The contact law, against closed forms.

namespace {

/// Presses the tool 1 mm into a coarse and a fine Winkler foundation: the force over the foundation's stiffness is
/// `volume(depth)` with an error below `bound(node_spacing, depth)`, of which the fine one has less than `share`.
template <class Volume, class Bound>
void checkOnWinklerBeds(const char* name, const ToolShape& tool, double half_width, double share, Volume&& volume,
                        Bound&& bound) {
  double error[2];
  for (int fine : {0, 1}) {
    const SpringBed::Spec spec = winkler(half_width, fine == 0 ? 0.0025 : 0.00125);
    SpringBed bed(spec);
    bed.place(tool, tipAt(0.0003, 0.0007, 0));
    move(bed, tool, 25, 0.02 * kDown);
    const Vec3 force = move(bed, tool, 250, Vec3::Zero());
    const double d = -bed.pose.position.z();
    error[fine] = force.z() / (spec.foundation * volume(d)) - 1.0;
    CHECK(std::abs(error[fine]) < bound(spec.node_spacing, d));
    CHECK((force - bed.springForce()).norm() < 1e-3 * force.z());
  }
  std::printf("%s on Winkler bed: error %.2f %% -> %.2f %%\n", name, 100 * error[0], 100 * error[1]);
  CHECK(std::abs(error[1]) < share * std::abs(error[0]));
}

}  // namespace

TEST_CASE("A plate on the whole bed: springs and contact layer in series", "[contact][whole]") {
  // Every vertex is under the flat end, so p = kappa (d - p / k) everywhere: F = A d kappa k / (kappa + k).
  const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
  SpringBed bed(damped({}));
  bed.place(plate, tipAt(0, 0, 0.001));
  move(bed, plate, 100, 0.02 * kDown);  // to 3 mm depth
  const Vec3 force = move(bed, plate, 300, Vec3::Zero());
  const double depth = -bed.pose.position.z(), k = bed.layer(), kappa = bed.spec.foundation;
  const double area = std::pow(2.0 * bed.spec.half_width, 2);
  REQUIRE(depth == Approx(0.003).epsilon(1e-9));
  CHECK(force.z() == Approx(area * depth * kappa * k / (kappa + k)).epsilon(1e-4));
  CHECK(force.head<2>().norm() < 1e-6 * force.z());
  CHECK(bed.contact.max_penetration == Approx(depth * kappa / (kappa + k)).epsilon(1e-2));
  CHECK(bed.contact.contact_count == bed.skin.vertexCount());
}

TEST_CASE("A sphere on a Winkler foundation", "[contact][whole]") {
  // F = kappa * (volume of the cap below the surface) = kappa pi (R d^2 - d^3 / 3). The discrete bed gives
  // way a node's width h beyond the contact's radius a: an error of order (h / a)^2, a^2 = 2 R d.
  const ToolShape tool = toolOf(ToolKind::Sphere, 0.02);
  checkOnWinklerBeds(
      "sphere", tool, 0.015, 0.4, [&](double d) { return M_PI * (tool.radius * d * d - d * d * d / 3.0); },
      [&](double h, double d) { return 1.3 * h * h / (2.0 * tool.radius * d); });
}

TEST_CASE("A flat punch on a Winkler foundation", "[contact][whole]") {
  // F = kappa pi R^2 d. Splines can't break off at the rim: the bed gives way over half their
  // width (1.5 h) more, by half the depth on average: an error of at most 2 * 0.75 h / R.
  const ToolShape tool{ToolKind::FlatCylinder, 0.01, 0.06, {0.0005}};
  checkOnWinklerBeds(
      "punch", tool, 0.02, 0.6, [&](double d) { return M_PI * tool.radius * tool.radius * d; },
      [&](double h, double) { return 1.5 * h / tool.radius; });
}

TEST_CASE("The contact law holds at the end of a step, vertex by vertex", "[contact]") {
  for (ToolKind kind : kKinds) {
    const ToolShape tool = toolOf(kind);
    SpringBed bed(tissueLike());
    bed.place(tool, tipAt(0.0003, 0.0007, 0.0));
    move(bed, tool, 200, {0.003, 0.0, -0.01}, 0.3);
    const Pose before = bed.pose;
    std::vector<double> was(bed.skin.vertexCount());
    Pose to = before;
    to.position += Vec3(6e-6, 0, -2e-6);
    std::vector<Vec3> start(bed.skin.vertexCount());
    for (int v = 0; v < bed.skin.vertexCount(); ++v) start[v] = skinPosition(bed.skin, v, bed.u.data());
    const std::vector<Float4> old_force(bed.contact.force.begin(), bed.contact.force.begin() + bed.contact.count);
    const Vec3 on_tool = bed.step(tool, to, 0.3);

    double largest = 0.0, sum_sticking = 0.0;
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < bed.contact.count; ++k) {
      largest = std::max(largest, toVec3(bed.contact.force[k]).norm());
      sum += toVec3(bed.contact.force[k]);
    }
    CHECK((on_tool + sum).norm() < 1e-12);
    REQUIRE(bed.contact.contact_count > 5);
    for (int k = 0; k < bed.contact.count; ++k) {
      const int v = bed.contact.vertex[k];
      const double K = bed.layer() * bed.skin.area[v];
      const Vec3 end = skinPosition(bed.skin, v, bed.u.data()), local = to.toLocal(end);
      const ToolDistance d = toolDistance(tool, local);
      const Vec3 normal = to.orientation * d.normal, force = toVec3(bed.contact.force[k]);
      const double normal_force = normal.dot(force);
      const Vec3 tangential = force - normal_force * normal;
      // Positions are known to ~1e-9 m (float32 displacements), which the layer turns into K times that.
      const double tolerance = 2e-3 * largest + 2e-9 * K;
      CHECK(std::abs(normal_force - K * std::max(0.0, -d.distance)) < tolerance);
      CHECK(tangential.norm() <= 0.3 * normal_force + tolerance);
      if (tangential.norm() < 0.29 * normal_force && k < static_cast<int>(old_force.size())) {  // sticks
        Vec3 slip = (end - start[v]) - (to.toWorld(local) - before.toWorld(local));
        slip -= normal.dot(slip) * normal;
        Vec3 old_tangential = toVec3(old_force[k]);
        old_tangential -= normal.dot(old_tangential) * normal;
        CHECK((tangential - (old_tangential - K * slip)).norm() < tolerance);
        sum_sticking += normal_force;
      }
    }
    std::printf("law: kind %d, %d in contact, %d sweeps, sticking share %.2f\n", static_cast<int>(kind),
                bed.contact.contact_count, bed.sweeps, sum_sticking / on_tool.norm());
  }
}

TEST_CASE("Points that move each other nearly as much as themselves settle in half of the sweeps", "[contact]") {
  // A row of points on soft ground, pressed into a rough wall that moves along: a force on one moves those around.
  constexpr int count = 60;
  const auto response = [](int i, int j) { return 1e-3F * std::exp(-std::pow(static_cast<float>(i - j) / 3, 2.0F)); };
  const auto sweepsToSettle = [&](bool goes_on, std::vector<Eigen::Vector4f>& forces) {
    std::vector<ContactRow> rows(count);
    std::vector<Eigen::Vector4f> increment(count, Eigen::Vector4f::Zero());
    for (int i = 0; i < count; ++i) {
      ContactRow& row = rows[static_cast<std::size_t>(i)];
      row.slot = i;
      row.normal = {0, 0, 1, 0};
      row.gap = -1e-4F - 2e-5F * std::sin(static_cast<float>(i));
      row.surface = {5e-5F, 0, 0, 0};
      row.stiffness = 1e5F;
      row.mobility = response(i, i);
      row.friction = 0.4F;
      row.change.setConstant(std::numeric_limits<float>::quiet_NaN());  // of a step that was lost
      row.course = row.change;
    }
    const auto rowAt = [&](std::size_t k) -> ContactRow& { return rows[k]; };
    const auto push = [&](const ContactRow& row, const Eigen::Vector4f& f) {
      for (int j = 0; j < count; ++j) increment[static_cast<std::size_t>(j)] += response(row.slot, j) * f;
    };
    Sweeps sweeps;
    int n = 0;
    for (bool settled = false; !settled && n < 1000; ++n) {
      if (goes_on) sweeps.goOn(count, rowAt, push);
      sweeps.sweepRows(
          count, n % 2 == 0, rowAt,
          [&](const ContactRow& row) { return increment[static_cast<std::size_t>(row.slot)]; }, push);
      settled = sweeps.end(1e-5F);
    }
    for (const ContactRow& row : rows) forces.push_back(row.force);
    return n;
  };
  std::vector<Eigen::Vector4f> plain_forces, forces;
  const int plain = sweepsToSettle(false, plain_forces), sweeps = sweepsToSettle(true, forces);
  std::printf("sweeps to settle: %d, plain ones %d\n", sweeps, plain);
  CHECK(sweeps <= plain / 2);
  float off = 0, size = 0;
  int sliding = 0;
  for (std::size_t i = 0; i < count; ++i) {
    off += (forces[i] - plain_forces[i]).squaredNorm();
    size += plain_forces[i].squaredNorm();
    sliding += std::hypot(forces[i].x(), forces[i].y()) > 0.399F * forces[i].z() ? 1 : 0;
  }
  CHECK(std::sqrt(off / size) < 1e-3F);
  CHECK(sliding > 0);
  CHECK(sliding < count);
}

TEST_CASE("Turning the whole world turns the forces", "[contact]") {
  const ToolShape tool = toolOf(ToolKind::FlatCylinder);
  SpringBed bed(tissueLike());
  bed.place(tool, tipAt(0.0003, 0.0007, 0.0));
  move(bed, tool, 150, {0.002, 0.0, -0.01}, 0.4);
  Pose to = bed.pose;
  to.position += Vec3(1e-5, 0, -1e-5);
  to.orientation = Quat(Eigen::AngleAxisd(2e-3, Vec3(1, 2, 3).normalized()));

  SpringBed turned = bed;
  const Quat turn(Eigen::AngleAxisd(1.1, Vec3(3, -1, 2).normalized()));
  auto turnAll = [&](auto& field) {
    for (Float4& a : field) a = toFloat4(turn * toVec3(a));
  };
  for (Vec3& X : turned.skin.surface.vertices) X = turn * X;
  turnAll(turned.u), turnAll(turned.du), turnAll(turned.contact.force);
  auto turnPose = [&](const Pose& p) { return Pose{turn * p.position, turn * p.orientation}; };

  auto solve = [&](SpringBed& b, const Pose& from, const Pose& p) { return b.solve(tool, p, from, 0.4, 4e-8); };
  const Vec3 force = solve(bed, bed.pose, to), turned_force = solve(turned, turnPose(bed.pose), turnPose(to));
  CHECK(force.norm() > 0.05);
  CHECK(force.head<2>().norm() > 0.005);  // friction takes part
  // Displacements of ~5 mm are rounded to 2e-10 m; the layer, ~1e3 N/m per vertex, makes ~1e-6 N of it. The
  // sweeps stop at 1e-4, and not at the same iterate.
  CHECK((turn * force - turned_force).norm() < 1e-3 * force.norm());
}

TEST_CASE("Moving at 10 mm/s the raw force changes smoothly, in, across and out", "[contact][whole]") {
  struct Case {
    ToolKind kind;
    double friction;
  };
  for (const Case& c : {Case{ToolKind::Sphere, 0.0},
                        {ToolKind::Sphere, 0.3},
                        {ToolKind::FlatCylinder, 0.0},
                        {ToolKind::FlatCylinder, 0.3},
                        {ToolKind::Capsule, 0.3},
                        {ToolKind::Cone, 0.0},
                        {ToolKind::Cone, 0.3}}) {
    const ToolShape tool = toolOf(c.kind);
    SpringBed bed(tissueLike());
    bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
    double peak = 0.0, change[4] = {}, deepest = 0.0;
    Vec3 last = Vec3::Zero(), velocity = Vec3::Zero();
    int sweeps = 0, ticks = 0, most = 0;
    // In, hold, across, out; the hand takes 50 ms to change its speed.
    const Vec3 phases[4] = {0.01 * kDown, Vec3::Zero(), 0.01 * Vec3::UnitX(), -0.01 * kDown};
    for (int phase = 0; phase < 4; ++phase) {
      const Vec3 from = velocity;
      for (int k = 0; k < (phase == 1 ? 100 : 300); ++k) {
        velocity = from + std::min(1.0, k / 25.0) * (phases[phase] - from);
        const Vec3 force = move(bed, tool, 1, velocity, c.friction);
        change[phase] = std::max(change[phase], (force - last).norm());
        peak = std::max(peak, force.norm());
        last = force;
        deepest = std::max(deepest, bed.deepest(tool));
        sweeps += bed.sweeps, ticks += bed.contact.contact_count > 0 ? 1 : 0;
        most = std::max(most, bed.contact.contact_count);
      }
    }
    std::printf(
        "smooth: kind %d mu %.1f peak %.3f N; worst tick: in %.2f hold %.2f across %.2f out %.2f %%; "
        "penetration %.2f %% R; %.2f sweeps, %d vertices\n",
        static_cast<int>(c.kind), c.friction, peak, 100 * change[0] / peak, 100 * change[1] / peak,
        100 * change[2] / peak, 100 * change[3] / peak, 100 * deepest / tool.radius,
        static_cast<double>(sweeps) / ticks, most);
    CHECK(*std::max_element(change, change + 4) < 0.03 * peak);
    CHECK(deepest < 0.02 * tool.radius);
    CHECK(sweeps <= 3 * ticks);
    CHECK(last.norm() == 0.0);  // out is out: no adhesion
  }
}
