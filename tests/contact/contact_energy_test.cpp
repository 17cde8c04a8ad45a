#include <catch2/catch.hpp>

#include <cmath>

#include "contact/bed_motion.h"

using namespace palpate;

// Friction and energy.

namespace {

/// A bed without damping, whose contact layer is `stiffer` times the usual.
SpringBed undampedBed(double stiffer) {
  SpringBed::Spec spec = tissueLike();
  spec.damping = 0.0;
  SpringBed bed(spec);
  bed.stiffenLayer(stiffer);
  return bed;
}

}  // namespace

TEST_CASE("Friction: drags with mu N, sticks below, and does not creep", "[contact][whole]") {
  const double mu = 0.3;
  SECTION("a plate: closed form") {
    const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
    SpringBed bed(damped({}));
    bed.place(plate, tipAt(0, 0, 0));
    move(bed, plate, 50, 0.02 * kDown, mu);
    move(bed, plate, 200, Vec3::Zero(), mu);
    move(bed, plate, 100, 0.002 * Vec3::UnitX(), mu);  // 0.4 mm aside, gently
    const Vec3 stuck = move(bed, plate, 200, Vec3::Zero(), mu);
    const double k = bed.layer(), kappa = bed.spec.lateral, aside = bed.pose.position.x();
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

TEST_CASE("Contact creates no energy", "[contact][whole]") {
  for (ToolKind kind : kKinds) {
    for (double stiffer : {0.1, 1.0, 100.0}) {
      for (double friction : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(kind), stiffer, friction);
        SpringBed bed = undampedBed(stiffer);
        const ToolShape tool = toolOf(kind);
        bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
        double work = 0.0, largest = 0.0, excess = 0.0;
        Vec3 last_way = Vec3::Zero();
        for (int k = 0; k < 750; ++k) {  // stirs and taps for 1.5 s
          const double t = 0.002 * (k + 1);
          const Pose from = bed.pose;
          const Vec3 to(0.0003 + 0.003 * std::sin(2 * M_PI * 1.7 * t), 0.0007,
                        0.001 - 0.003 * (1 - std::cos(2 * M_PI * 3 * t)));
          findContactCandidates(bed.skin, bed.u.data(), tool, from, (to - from.position).norm(), bed.contact,
                                bed.scratch);
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
        std::printf("energy: kind %d stiffness x %g mu %.1f: at most %.2e of the largest above the work; end %.2e\n",
                    static_cast<int>(kind), stiffer, friction, excess / largest, (bed.energy() - work) / largest);
        CHECK(largest > 1e-4);
        CHECK(excess < 0.01 * largest);
      }
    }
  }
}

TEST_CASE("Tissue that bounces on a resting tool loses energy, if any", "[contact][whole]") {
  for (ToolKind kind : kKinds) {
    for (double stiffer : {0.01, 1.0, 1000.0}) {
      SpringBed bed = undampedBed(stiffer);
      const ToolShape tool = toolOf(kind);
      bed.place(tool, tipAt(0.0003, 0.0007, 0.0005));
      for (Float4& a : bed.du) a.z = static_cast<float>(0.5 * bed.spec.dt);  // 0.5 m/s towards the tool
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

// A force that pushes along the normal of where a point will be, not of where it is, pushes it on over a round tool: a
// ball that was held deeper than its radius in a liver shook it, +-6 % of its force at 139 Hz.
TEST_CASE("Tissue that slides to and fro on a ball held deep gains no energy", "[contact]") {
  SpringBed::Spec spec = tissueLike();
  spec.lateral = 1e4;  // slow: it slides far
  spec.damping = 200;
  SpringBed bed(spec);
  const ToolShape ball = toolOf(ToolKind::Sphere);
  bed.place(ball, tipAt(0.0003, 0.0007, 0));
  move(bed, ball, 200, 0.02 * kDown);
  move(bed, ball, 500, Vec3::Zero());
  const double held = bed.energy();
  bed.spec.damping = 0;
  for (Float4& a : bed.du) a.x += static_cast<float>(0.05 * bed.spec.dt);
  move(bed, ball, 1, Vec3::Zero());
  const double kicked = bed.energy() - held;
  move(bed, ball, 1000, Vec3::Zero());
  const double later = bed.energy() - held;
  std::printf("kicked beside a ball: %.2e J, two seconds later %.2e J\n", kicked, later);
  CHECK(kicked > 1e-5);
  CHECK(later < 1.05 * kicked);
}

TEST_CASE("The step's limit does not depend on the layer's stiffness", "[contact]") {
  const ToolShape tool = toolOf(ToolKind::Sphere);
  double force[3];
  const double stiffer[3] = {1.0, 100.0, 1e5};
  for (int i : {0, 1, 2}) {
    SpringBed bed(tissueLike());
    bed.stiffenLayer(stiffer[i]);
    bed.place(tool, tipAt(0.0003, 0.0007, 0.0));
    move(bed, tool, 200, 0.01 * kDown);
    force[i] = move(bed, tool, 300, Vec3::Zero()).z();
    CHECK(bed.deepest(tool) < 0.02 * tool.radius);
  }
  std::printf("stiffness x 1, 100, 1e5: %.5f %.5f %.5f N\n", force[0], force[1], force[2]);
  CHECK(force[1] == Approx(force[0]).epsilon(0.02));
  CHECK(force[2] == Approx(force[1]).epsilon(0.01));
}
