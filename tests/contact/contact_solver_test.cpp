#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>

#include "contact/spring_bed.h"
#include "support/realtime_guard.h"

using namespace palpate;

namespace {

constexpr int kSubsteps = 10;  // of 0.2 ms: ticks of 2 ms, 500 Hz

ToolShape toolOf(ToolKind kind, double radius = 0.01) {
  ToolShape tool;
  tool.kind = kind;
  tool.radius = radius;
  return tool;
}

const ToolKind kKinds[] = {ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule};

/// A bed whose neighbours are coupled, as tissue's are.
SpringBed::Spec tissueLike() {
  SpringBed::Spec spec;
  spec.tension = 10.0;
  spec.skin_spacing = 0.0025;
  return spec;
}

/// Comes to rest quickly.
SpringBed::Spec damped(SpringBed::Spec spec) {
  spec.damping = 400.0;
  return spec;
}

/// Moves the tool at `velocity` for `ticks`; returns the last force.
Vec3 move(SpringBed& bed, const ToolShape& tool, int ticks, const Vec3& velocity, double friction = 0.0) {
  Vec3 force = Vec3::Zero();
  for (int k = 0; k < ticks; ++k) {
    Pose to = bed.pose;
    to.position += kSubsteps * bed.spec.dt * velocity;
    force = bed.tick(tool, to, kSubsteps, friction);
  }
  return force;
}

const Vec3 kDown = -Vec3::UnitZ();

bool allFinite(const AlignedVector<Float4>& u) {
  return std::all_of(u.begin(), u.end(), [](const Float4& a) { return toVec3(a).allFinite(); });
}

std::uint64_t hashOf(const SpringBed& bed) {
  std::uint64_t hash = 1469598103934665603ull;
  auto add = [&](const AlignedVector<Float4>& a) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(a.data());
    for (std::size_t i = 0; i < a.size() * sizeof(Float4); ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  };
  add(bed.u);
  add(bed.du);
  return hash;
}

}  // namespace

TEST_CASE("A plate on the whole bed: springs and contact layer in series", "[contact]") {
  // Every vertex is under the flat end, so p = kappa (d - p / k) everywhere: F = A d kappa k / (kappa + k).
  const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
  SpringBed bed(damped({}));
  bed.place(plate, tipAt(0, 0, 0.001));
  move(bed, plate, 100, 0.02 * kDown);  // to 3 mm depth
  const Vec3 force = move(bed, plate, 300, Vec3::Zero());
  const double depth = -bed.pose.position.z(), k = bed.skin.bulk_stiffness, kappa = bed.spec.foundation;
  const double area = std::pow(2.0 * bed.spec.half_width, 2);
  REQUIRE(depth == Approx(0.003).epsilon(1e-9));
  CHECK(force.z() == Approx(area * depth * kappa * k / (kappa + k)).epsilon(1e-4));
  CHECK(force.head<2>().norm() < 1e-6 * force.z());
  CHECK(bed.contact.max_penetration == Approx(depth * kappa / (kappa + k)).epsilon(1e-2));
  CHECK(bed.contact.contact_count == bed.skin.vertexCount());
}

TEST_CASE("A sphere on a Winkler foundation", "[contact]") {
  // F = kappa * (volume of the cap below the surface) = kappa pi (R d^2 - d^3 / 3). The discrete bed gives
  // way a node's width h beyond the contact's radius a: an error of order (h / a)^2, a^2 = 2 R d.
  const ToolShape tool = toolOf(ToolKind::Sphere, 0.02);
  double error[2];
  for (int fine : {0, 1}) {
    SpringBed::Spec spec = damped({});
    spec.half_width = 0.015;
    spec.node_spacing = fine == 0 ? 0.0025 : 0.00125;
    spec.skin_spacing = 0.5 * spec.node_spacing;
    spec.lateral = 100.0 * spec.foundation;  // the closed form is that of vertical springs
    spec.surface_density = 50.0;
    SpringBed bed(spec);
    bed.place(tool, tipAt(0.0003, 0.0007, 0));
    move(bed, tool, 25, 0.02 * kDown);
    const Vec3 force = move(bed, tool, 250, Vec3::Zero());
    const double d = -bed.pose.position.z();
    const double exact = spec.foundation * M_PI * (tool.radius * d * d - d * d * d / 3.0);
    const double h_over_a_squared = std::pow(spec.node_spacing, 2) / (2.0 * tool.radius * d);
    error[fine] = force.z() / exact - 1.0;
    CHECK(std::abs(error[fine]) < 1.3 * h_over_a_squared);
    CHECK((force - bed.springForce()).norm() < 1e-3 * force.z());
  }
  std::printf("sphere on Winkler bed: error %.2f %% -> %.2f %%\n", 100 * error[0], 100 * error[1]);
  CHECK(std::abs(error[1]) < 0.4 * std::abs(error[0]));
}

TEST_CASE("A flat punch on a Winkler foundation", "[contact]") {
  // F = kappa pi R^2 d. Splines can't break off at the rim: the bed gives way over half their
  // width (1.5 h) more, by half the depth on average: an error of at most 2 * 0.75 h / R.
  const ToolShape tool{ToolKind::FlatCylinder, 0.01, 0.06, 0.0005};
  double error[2];
  for (int fine : {0, 1}) {
    SpringBed::Spec spec = damped({});
    spec.half_width = 0.02;
    spec.node_spacing = fine == 0 ? 0.0025 : 0.00125;
    spec.skin_spacing = 0.5 * spec.node_spacing;
    spec.lateral = 100.0 * spec.foundation;
    spec.surface_density = 50.0;
    SpringBed bed(spec);
    bed.place(tool, tipAt(0.0003, 0.0007, 0));
    move(bed, tool, 25, 0.02 * kDown);
    const Vec3 force = move(bed, tool, 250, Vec3::Zero());
    const double d = -bed.pose.position.z();
    error[fine] = force.z() / (spec.foundation * M_PI * tool.radius * tool.radius * d) - 1.0;
    CHECK(std::abs(error[fine]) < 1.5 * spec.node_spacing / tool.radius);
    CHECK((force - bed.springForce()).norm() < 1e-3 * force.z());
  }
  std::printf("punch on Winkler bed: error %.2f %% -> %.2f %%\n", 100 * error[0], 100 * error[1]);
  CHECK(std::abs(error[1]) < 0.6 * std::abs(error[0]));
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
      const double K = bed.skin.bulk_stiffness * bed.skin.area[v];
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
                bed.contact.contact_count, bed.contact.sweep_count, sum_sticking / on_tool.norm());
  }
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

  auto solve = [&](SpringBed& b, const Pose& from, const Pose& p) {
    return solveContact(b.skin, tool, p, from, 0.4, 4e-8, b.inverse_mass.data(), b.u.data(), b.du.data(), b.contact);
  };
  const Vec3 force = solve(bed, bed.pose, to), turned_force = solve(turned, turnPose(bed.pose), turnPose(to));
  CHECK(force.norm() > 0.05);
  CHECK(force.head<2>().norm() > 0.005);  // friction takes part
  // Displacements of ~5 mm are rounded to 2e-10 m; the layer, ~1e3 N/m per vertex, makes ~1e-6 N of it. The
  // sweeps stop at 1e-4, and not at the same iterate.
  CHECK((turn * force - turned_force).norm() < 1e-3 * force.norm());
}

TEST_CASE("Moving at 10 mm/s the raw force changes smoothly, in, across and out", "[contact]") {
  struct Case {
    ToolKind kind;
    double friction;
  };
  for (const Case& c : {Case{ToolKind::Sphere, 0.0}, {ToolKind::Sphere, 0.3}, {ToolKind::FlatCylinder, 0.0},
                        {ToolKind::FlatCylinder, 0.3}, {ToolKind::Capsule, 0.3}}) {
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
        sweeps += bed.contact.sweep_count, ticks += bed.contact.contact_count > 0 ? 1 : 0;
        most = std::max(most, bed.contact.contact_count);
      }
    }
    std::printf("smooth: kind %d mu %.1f peak %.3f N; worst tick: in %.2f hold %.2f across %.2f out %.2f %%; "
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

TEST_CASE("Friction: drags with mu N, sticks below, and does not creep", "[contact]") {
  const double mu = 0.3;
  SECTION("a plate: closed form") {
    const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
    SpringBed bed(damped({}));
    bed.place(plate, tipAt(0, 0, 0));
    move(bed, plate, 50, 0.02 * kDown, mu);
    move(bed, plate, 200, Vec3::Zero(), mu);
    move(bed, plate, 100, 0.002 * Vec3::UnitX(), mu);  // 0.4 mm aside, gently
    const Vec3 stuck = move(bed, plate, 200, Vec3::Zero(), mu);
    const double k = bed.skin.bulk_stiffness, kappa = bed.spec.lateral, aside = bed.pose.position.x();
    const double area = std::pow(2.0 * bed.spec.half_width, 2);
    CHECK(-stuck.x() == Approx(area * aside * kappa * k / (kappa + k)).epsilon(1e-3));
    CHECK(-stuck.x() < mu * stuck.z());
    const Vec3 later = move(bed, plate, 2000, Vec3::Zero(), mu);  // 4 s
    CHECK((later - stuck).norm() < 1e-4 * stuck.norm());
    const Vec3 dragged = move(bed, plate, 300, 0.01 * Vec3::UnitX(), mu);
    CHECK(-dragged.x() == Approx(mu * dragged.z()).epsilon(1e-4));
    const Vec3 back = move(bed, plate, 300, -0.01 * Vec3::UnitX(), mu);
    CHECK(back.x() == Approx(mu * back.z()).epsilon(1e-4));
  }
  SECTION("a large ball: tractions tilt by up to a / R = 0.14, so mu N within its square") {
    const ToolShape ball = toolOf(ToolKind::Sphere, 0.05);
    SpringBed::Spec spec;
    spec.damping = 100.0;
    spec.lateral = 1e7;  // little dragging along of the bed, so little asymmetry
    spec.surface_density = 50;
    SpringBed bed(spec);
    bed.place(ball, tipAt(-0.01, 0, 0));
    move(bed, ball, 25, 0.01 * kDown, mu);
    const Vec3 dragged = move(bed, ball, 500, 0.001 * Vec3::UnitX(), mu);  // slow: the damping drags, too
    std::printf("ball: drag / (mu N) %.4f\n", -dragged.x() / (mu * dragged.z()));
    CHECK(-dragged.x() == Approx(mu * dragged.z()).epsilon(0.02));
    CHECK(std::abs(dragged.y()) < 1e-3 * dragged.z());
  }
  SECTION("a ball, part sticking and part slipping, holds its force for ten seconds") {
    const ToolShape ball = toolOf(ToolKind::Sphere);
    SpringBed bed(tissueLike());
    bed.place(ball, tipAt(0.0003, 0.0007, 0));
    move(bed, ball, 250, 0.01 * kDown, 0.5);
    move(bed, ball, 50, 0.01 * Vec3::UnitX(), 0.5);
    const Vec3 held = move(bed, ball, 1000, Vec3::Zero(), 0.5);
    const Vec3 later = move(bed, ball, 5000, Vec3::Zero(), 0.5);
    std::printf("ball: sideways %.3f of N, creep in 10 s %.1e\n", held.head<2>().norm() / held.z(),
                (later - held).norm() / held.norm());
    CHECK(held.head<2>().norm() > 0.1 * held.z());
    CHECK((later - held).norm() < 1e-3 * held.norm());
  }
  SECTION("a plate that turns about its axis drags by torque, not by force") {
    const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
    SpringBed bed(damped({}));
    bed.place(plate, tipAt(0, 0, 0));
    move(bed, plate, 50, 0.02 * kDown, mu);
    double torque = 0.0;
    Vec3 force;
    for (int k = 1; k <= 100; ++k) {
      Pose to = bed.pose;
      to.orientation = Quat(Eigen::AngleAxisd(2e-3 * k, Vec3::UnitZ()));
      force = bed.tick(plate, to, kSubsteps, mu);
    }
    for (int k = 0; k < bed.contact.count; ++k) {
      const Vec3 x = skinPosition(bed.skin, bed.contact.vertex[k], bed.u.data());
      torque += x.cross(toVec3(bed.contact.force[k])).z();
    }
    // Slipping everywhere but near the axis: mu p times the polar moment of a square, its mean radius
    // being 0.7652 times half its width.
    CHECK(torque == Approx(mu * force.z() * 0.7652 * bed.spec.half_width).epsilon(0.1));
    CHECK(force.head<2>().norm() < 1e-3 * force.z());
  }
}

TEST_CASE("Contact creates no energy", "[contact]") {
  for (ToolKind kind : kKinds) {
    for (double stiffer : {0.1, 1.0, 100.0}) {
      for (double friction : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(kind), stiffer, friction);
        SpringBed::Spec spec = tissueLike();
        spec.damping = 0.0;
        SpringBed bed(spec);
        bed.skin.bulk_stiffness *= stiffer;
        const ToolShape tool = toolOf(kind);
        bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
        double work = 0.0, largest = 0.0, excess = 0.0;
        Vec3 last_way = Vec3::Zero();
        for (int k = 0; k < 750; ++k) {  // stirs and taps for 1.5 s
          const double t = 0.002 * (k + 1);
          const Pose from = bed.pose;
          const Vec3 to(0.0003 + 0.003 * std::sin(2 * M_PI * 1.7 * t), 0.0007,
                        0.001 - 0.003 * (1 - std::cos(2 * M_PI * 3 * t)));
          findContactCandidates(bed.skin, bed.u.data(), tool, from, (to - from.position).norm(), bed.contact);
          for (int s = 1; s <= kSubsteps; ++s) {
            Pose pose = from;
            pose.position += (to - from.position) * s / kSubsteps;
            const Vec3 way = pose.position - bed.pose.position;
            const Vec3 force = bed.step(tool, pose, friction);
            work -= 0.5 * force.dot(last_way + way);  // it acts at the step's start, between the two ways
            last_way = way;
            const double energy = bed.energy();
            largest = std::max(largest, energy);
            excess = std::max(excess, energy - work);
          }
        }
        std::printf("energy: kind %d stiffness x %g mu %.1f: at most %.2e of the largest above the work; end %.2e\n", static_cast<int>(kind),
                    stiffer, friction, excess / largest, (bed.energy() - work) / largest);
        CHECK(largest > 1e-4);
        CHECK(excess < 0.01 * largest);
      }
    }
  }
}

TEST_CASE("Tissue that bounces on a resting tool loses energy, if any", "[contact]") {
  for (ToolKind kind : kKinds) {
    for (double stiffer : {0.01, 1.0, 1000.0}) {
      SpringBed::Spec spec = tissueLike();
      spec.damping = 0.0;
      SpringBed bed(spec);
      bed.skin.bulk_stiffness *= stiffer;
      const ToolShape tool = toolOf(kind);
      bed.place(tool, tipAt(0.0003, 0.0007, 0.0005));
      for (Float4& a : bed.du) a.z = static_cast<float>(0.5 * spec.dt);  // 0.5 m/s towards the tool
      const double before = bed.energy();
      double most = 0.0;
      int touched = 0;
      for (int k = 0; k < 500; ++k) {
        move(bed, tool, 1, Vec3::Zero());
        most = std::max(most, bed.energy());
        touched += bed.contact.contact_count > 0 ? 1 : 0;
      }
      std::printf("bounce: kind %d stiffness x %g: energy at most %.5f, at the end %.5f of before\n",
                  static_cast<int>(kind), stiffer, most / before, bed.energy() / before);
      CHECK(touched > 20);
      CHECK(touched < 480);
      CHECK(most < 1.002 * before);
    }
  }
}

TEST_CASE("The step's limit does not depend on the layer's stiffness", "[contact]") {
  const ToolShape tool = toolOf(ToolKind::Sphere);
  double force[3];
  const double stiffer[3] = {1.0, 100.0, 1e5};
  for (int i : {0, 1, 2}) {
    SpringBed bed(tissueLike());
    bed.skin.bulk_stiffness *= stiffer[i];
    bed.place(tool, tipAt(0.0003, 0.0007, 0.0));
    move(bed, tool, 200, 0.01 * kDown);
    force[i] = move(bed, tool, 300, Vec3::Zero()).z();
    CHECK(bed.deepest(tool) < 0.02 * tool.radius);
  }
  std::printf("stiffness x 1, 100, 1e5: %.5f %.5f %.5f N\n", force[0], force[1], force[2]);
  CHECK(force[1] == Approx(force[0]).epsilon(0.02));
  CHECK(force[2] == Approx(force[1]).epsilon(0.01));
}

TEST_CASE("Nothing tunnels at 1 and 2 m/s", "[contact]") {
  for (ToolKind kind : kKinds) {
    for (double radius : {0.01, 0.003}) {
      for (double speed : {1.0, 2.0}) {
        for (double tilt : {0.0, 0.7, M_PI / 2}) {  // tip first, askew, and flat with its side
          CAPTURE(static_cast<int>(kind), radius, speed, tilt);
          SpringBed::Spec spec = tissueLike();
          spec.tool_radius = radius;
          spec.skin_spacing = std::min(0.0025, 0.3 * radius);
          SpringBed bed(spec);
          const ToolShape tool = toolOf(kind, radius);
          Pose start;
          start.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
          const double middle = kind == ToolKind::Sphere ? radius : 0.5 * tool.length;
          start.position = Vec3(0.0003, 0.0007, 0.02) - (tilt > 1.0 ? middle : 0.0) * Vec3::UnitX();
          bed.place(tool, start);
          double deepest = 0.0;
          for (int k = 0; k < 0.035 / speed / 0.002; ++k) {
            move(bed, tool, 1, speed * kDown);
            deepest = std::max(deepest, bed.deepest(tool));
          }
          // A vertex that got past the middle would be deeper than half the radius on its way.
          CHECK(deepest < 0.3 * radius);
          CHECK(deepest > 0.0);
          // The skin below the tool is still below it.
          const Vec3 tip = bed.pose.toWorld({0, 0, radius});
          for (int v = 0; v < bed.skin.vertexCount(); ++v) {
            const Vec3 x = skinPosition(bed.skin, v, bed.u.data());
            if ((x - tip).head<2>().norm() < 0.5 * radius) REQUIRE(x.z() < tip.z());
          }
          REQUIRE(allFinite(bed.u));
        }
      }
    }
  }
}

TEST_CASE("A vertex deep under a flat end is pushed out by the end, not by the wall", "[contact]") {
  const ToolShape tool{ToolKind::FlatCylinder, 0.01, 0.06, 0.0005};
  SpringBed::Spec spec = tissueLike();
  spec.skin_spacing = 0.001;
  SpringBed bed(spec);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.0005));
  findContactCandidates(bed.skin, bed.u.data(), tool, bed.pose, 0.01, bed.contact);
  // In one step 3 mm below the skin: vertices within 3 mm of the wall are nearer to it than to the end.
  bed.step(tool, tipAt(0.0003, 0.0007, -0.003));
  int near_wall = 0;
  for (int step = 0; step < 20; ++step) {
    for (int k = 0; k < bed.contact.count; ++k) {
      const Vec3 local = bed.pose.toLocal(bed.skin.surface.vertices[bed.contact.vertex[k]]);
      const double r = local.head<2>().norm();
      if (r > tool.radius - 2.0 * edgeRadius(tool)) continue;
      near_wall += r > tool.radius - 0.0025 ? 1 : 0;
      const Vec3 force = toVec3(bed.contact.force[k]);
      REQUIRE(force.head<2>().norm() <= 1e-3 * force.norm());
      REQUIRE(force.z() <= 0.0);
    }
    bed.step(tool, bed.pose);
  }
  CHECK(near_wall > 100);
  move(bed, tool, 400, Vec3::Zero());  // it is thrown off and returns
  CHECK(bed.deepest(tool) < 0.02 * tool.radius);
}

TEST_CASE("A tool put deep into the tissue is survived", "[contact]") {
  for (ToolKind kind : kKinds) {
    SpringBed bed(tissueLike());
    const ToolShape tool = toolOf(kind);
    bed.place(tool, tipAt(0, 0, 0.1));
    bed.tick(tool, tipAt(0.0, 0.0, -0.02), 1, 0.3);
    for (int k = 0; k < 200; ++k) REQUIRE(move(bed, tool, 1, Vec3::Zero(), 0.3).allFinite());
    CHECK(allFinite(bed.u));
    bed.tick(tool, tipAt(0.0, 0.0, 0.1), 1, 0.3);
    move(bed, tool, 500, Vec3::Zero(), 0.3);
    double largest = 0.0;
    for (const Float4& a : bed.u) largest = std::max(largest, toVec3(a).norm());
    std::printf("teleport: kind %d: largest displacement a second later %.2e m\n", static_cast<int>(kind), largest);
    CHECK(largest < 0.03);
  }
}

TEST_CASE("What is not a number stays where it is", "[contact]") {
  SpringBed bed(tissueLike());
  const ToolShape tool = toolOf(ToolKind::Sphere);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.0));
  move(bed, tool, 200, 0.01 * kDown, 0.3);
  const int bad = (bed.side / 2) * bed.side + bed.side / 2 + 2;  // beside the contact's middle
  bed.u[bad].x = std::numeric_limits<float>::quiet_NaN();
  const Vec3 force = bed.step(tool, bed.pose, 0.3);
  CHECK(force.allFinite());
  CHECK(force.z() > 0.0);
  bed.du[0].y = std::numeric_limits<float>::infinity();
  const Vec3 lost = solveContact(bed.skin, tool, bed.pose, bed.pose, 0.3, 4e-8, bed.inverse_mass.data(),
                                 bed.u.data(), bed.du.data(), bed.contact);
  CHECK(lost.allFinite());
  for (Float4& a : bed.du) a.z = std::numeric_limits<float>::quiet_NaN();
  CHECK(bed.step(tool, bed.pose, 0.3).norm() == 0.0);
}

TEST_CASE("Contact is deterministic and does not see how far the search went", "[contact]") {
  auto run = [](double margin) {
    SpringBed bed(tissueLike());
    const ToolShape tool = toolOf(ToolKind::FlatCylinder);
    bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
    for (int k = 0; k < 400; ++k) {
      const Pose from = bed.pose;
      findContactCandidates(bed.skin, bed.u.data(), tool, from, margin, bed.contact);
      for (int s = 0; s < 5; ++s) {
        Pose to = bed.pose;
        to.position += k < 200 ? Vec3(0, 0, -2e-6) : Vec3(2e-6, 1e-6, 0);
        bed.step(tool, to, 0.3);
      }
    }
    return hashOf(bed);
  };
  const std::uint64_t hash = run(0.0005);
  CHECK(run(0.0005) == hash);
  CHECK(run(0.004) == hash);
}

TEST_CASE("Contact allocates nothing and locks nothing", "[contact]") {
  if (!test::guardAvailable()) {
    WARN("a sanitizer replaces malloc: not counted here");
    return;
  }
  SpringBed bed(tissueLike());
  const ToolShape tool = toolOf(ToolKind::FlatCylinder);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
  test::startGuard();
  for (int k = 0; k < 200; ++k) move(bed, tool, 1, {0.01, 0.0, -0.01}, 0.3);
  const int offences = test::stopGuard().total();
  CHECK(offences == 0);
  CHECK(bed.contact.contact_count > 5);
  // The guard counts.
  test::startGuard();
  const auto some = std::make_unique<SpringBed>(bed);
  const int allocations = test::stopGuard().allocations;
  CHECK(allocations > 0);
  CHECK(some->side == bed.side);
}
