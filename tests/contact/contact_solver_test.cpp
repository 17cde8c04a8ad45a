#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>

#include "contact/spring_bed.h"

// Counts allocations while a test asks for it.
namespace {
std::atomic<bool> g_counting{false};
std::atomic<int> g_allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  if (g_counting) ++g_allocations;
  void* p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
}  // namespace

void* operator new(std::size_t size) { return counted(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t a) { return counted(size, static_cast<std::size_t>(a)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

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

[[maybe_unused]] bool allFinite(const AlignedVector<Float4>& u) {
  return std::all_of(u.begin(), u.end(), [](const Float4& a) { return toVec3(a).allFinite(); });
}

[[maybe_unused]] std::uint64_t hashOf(const SpringBed& bed) {
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
  // Every vertex is under the flat end: F = A d kappa k / (kappa + k), exactly.
  const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
  SpringBed bed(damped({}));
  bed.place(plate, tipAt(0, 0, 0.001));
  move(bed, plate, 100, 0.02 * kDown);  // to 3 mm depth
  const Vec3 force = move(bed, plate, 200, Vec3::Zero());
  const double depth = -bed.pose.position.z(), k = bed.skin.bulk_stiffness, kappa = bed.spec.foundation;
  CHECK(depth == Approx(0.003).epsilon(1e-9));
  // The outer ring of nodes reaches beyond the skin: its springs are pressed, too. With splines the
  // nodes' displacements are uniform, so the bed's area is that of all nodes.
  const double bed_area = bed.side * bed.side * std::pow(bed.spec.node_spacing, 2);
  (void)bed_area;
  std::printf("plate: F %.6g springs %.6g, A kappa d %.6g (skin area) %.6g (all nodes) pen %.3g\n", force.z(),
              bed.springForce().z(), 0.0036 * depth * kappa * k / (kappa + k), bed_area * depth * kappa, bed.contact.max_penetration);
}

TEST_CASE("explore sphere", "[contact]") {
  for (double h : {0.0025, 0.00125}) {
    for (double d : {0.001, 0.002}) {
    SpringBed::Spec spec = damped({});
    spec.half_width = 0.02; spec.node_spacing = h; spec.skin_spacing = h / 2; spec.lateral = 1.5e7; spec.dt=2e-4/ 2;
    spec.surface_density = 20;
    const ToolShape tool = toolOf(ToolKind::Sphere, 0.02);
    SpringBed bed(spec);
    bed.place(tool, tipAt(0.0003, 0.0007, 0));
    move(bed, tool, static_cast<int>(d / 0.02 / 0.001), 0.02 * kDown);
    Vec3 F = move(bed, tool, 300, Vec3::Zero());
    double dd = -bed.pose.position.z();
    double exact = spec.foundation * M_PI * (tool.radius*dd*dd - dd*dd*dd/3);
    double a = std::sqrt(2*tool.radius*dd);
    std::printf("sphere h %g d %g F %.5g exact %.5g err %.2f%% (h/a)^2 %.4f balance %.2g pen %.3g contacts %d\n", h, dd, F.z(), exact, 100*(F.z()/exact-1), h*h/a/a, (F-bed.springForce()).norm()/F.norm(), bed.contact.max_penetration, bed.contact.contact_count);
    const ToolShape punch{ToolKind::FlatCylinder, 0.01, 0.06, 0.001};
    SpringBed b2(spec); b2.place(punch, tipAt(0.0003,0.0007,0));
    move(b2, punch, static_cast<int>(d / 0.02 / 0.001), 0.02 * kDown);
    F = move(b2, punch, 300, Vec3::Zero());
    exact = spec.foundation*M_PI*punch.radius*punch.radius*dd;
    std::printf("punch F %.5g exact %.5g err %.2f%% h/R %.3f\n", F.z(), exact, 100*(F.z()/exact-1), h/punch.radius);
    }
  }
}

TEST_CASE("explore energy", "[contact]") {
  for (ToolKind kind : kKinds) for (double kf : {0.1, 1.0, 100.0}) for (double mu : {0.0, 0.5}) {
    SpringBed::Spec spec = tissueLike(); spec.damping = 0;
    SpringBed bed(spec); bed.skin.bulk_stiffness *= kf;
    const ToolShape tool = toolOf(kind);
    bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
    double work = 0, worst = -1, big = 0, e0 = 0, worst_step=0; double last=0;
    for (int k = 0; k < 1500; ++k) {
      Pose to = bed.pose;
      const double t = 0.002 * k;
      if (k % 1 == 0) {}
      to.position.z() = 0.001 - 0.003 * (1 - std::cos(2 * M_PI * 3 * t));
      to.position.x() = 0.0003 + 0.003 * std::sin(2 * M_PI * 1.7 * t);
      const Pose from = bed.pose;
      findContactCandidates(bed.skin, bed.u.data(), tool, from, 0.003, bed.contact);
      for (int s = 1; s <= 10; ++s) {
        Pose p = from; p.position += 0.1 * s * (to.position - from.position);
        Vec3 dx = p.position - bed.pose.position;
        Vec3 f = bed.step(tool, p, mu);
        work -= f.dot(dx);
        double e = bed.energy();
        big = std::max(big, e);
        worst = std::max(worst, e - work - e0);
        worst_step = std::max(worst_step, e - work - last); last = e - work;
      }
    }
    std::printf("kind %d kf %g mu %.1f energy max %.4g final excess %.4g worst excess %.4g (%.3g of max) step %.3g\n", (int)kind, kf, mu, big, bed.energy() - work, worst, worst / big, worst_step/big);
  }
}

TEST_CASE("explore friction", "[contact]") {
  for (double kf : {1.0}) {
    SpringBed bed(damped({})); bed.skin.bulk_stiffness *= kf;
    const ToolShape plate = toolOf(ToolKind::FlatCylinder, 0.1);
    bed.place(plate, tipAt(0, 0, 0));
    move(bed, plate, 50, 0.02 * kDown, 0.3);
    move(bed, plate, 200, Vec3::Zero(), 0.3);
    Vec3 f = move(bed, plate, 20, {0.01, 0, 0}, 0.3);
    f = move(bed, plate, 200, Vec3::Zero(), 0.3);
    Vec3 f2 = move(bed, plate, 2000, Vec3::Zero(), 0.3);
    std::printf("stick %.6g N %.6g ratio %.5f creep %.3g\n", f.x(), f.z(), f.x()/f.z(), (f2-f).norm()/f.norm());
    f = move(bed, plate, 500, {0.01, 0, 0}, 0.3);
    std::printf("slip ratio %.6f (%g)\n", -f.x()/f.z(), f.y());
    const ToolShape ball = toolOf(ToolKind::Sphere, 0.05);
    SpringBed b3(damped(tissueLike())); b3.place(ball, tipAt(-0.01, 0, 0));
    move(b3, ball, 50, 0.02*kDown, 0.3);
    f = move(b3, ball, 500, {0.02, 0, 0}, 0.3);
    std::printf("ball slip ratio %.6f (%g) N %g\n", -f.x()/f.z(), f.y(), f.z());
    // partial stick on ball
    SpringBed b4(tissueLike()); const ToolShape b = toolOf(ToolKind::Sphere); b4.place(b, tipAt(0.0003,0.0007,0));
    move(b4, b, 250, 0.01*kDown, 0.5);
    move(b4, b, 50, {0.01,0,0}, 0.5);
    f = move(b4, b, 1000, Vec3::Zero(), 0.5);
    f2 = move(b4, b, 5000, Vec3::Zero(), 0.5);
    std::printf("ball partial: F %.6g %.6g %.6g creep in 10 s %.3g sweeps %d\n", f.x(), f.y(), f.z(), (f2-f).norm()/f.norm(), b4.contact.sweep_count);
  }
}

TEST_CASE("explore tunnel", "[contact]") {
  for (ToolKind kind : kKinds) for (double R : {0.01, 0.003}) for (double v : {1.0, 2.0}) for (double tilt : {0.0, M_PI / 2, 0.7}) {
    SpringBed::Spec spec = tissueLike(); spec.tool_radius = R; spec.skin_spacing = std::min(0.0025, 0.3 * R);
    SpringBed bed(spec);
    const ToolShape tool = toolOf(kind, R);
    Pose at; at.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
    at.position = Vec3(0.0003, 0.0007, 0.003 + (tilt>0? R:0)) - (tilt > 1 ? Vec3(0.03,0,0) : Vec3::Zero());
    bed.place(tool, at);
    double deep = 0;
    for (int k = 0; k < int(0.02 / v / 0.002); ++k) { move(bed, tool, 1, v * kDown); deep = std::max(deep, bed.deepest(tool)); }
    std::printf("kind %d R %g v %g tilt %.1f deepest/R %.3f%% final z %.4f\n", (int)kind, R, v, tilt, 100 * deep / R, bed.pose.position.z());
  }
}
