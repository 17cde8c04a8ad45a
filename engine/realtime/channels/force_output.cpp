#include "realtime/channels/force_output.h"

#include <algorithm>
#include <bit>

namespace palpate {

double freshSeconds(double rate_hz) {
  constexpr double kHandSeconds = 0.010;  // longer: a device pushes against where the hand was
  constexpr double kPeriods = 3;          // below 2, an on-time loop reads as stale
  return std::max(kHandSeconds, kPeriods / rate_hz);
}

ForceReading readForce(const ForceSample& sample, std::int64_t now, double rate_hz) {
  ForceReading reading{sample, 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now - sample.wall_ns)), false};
  reading.fresh = sample.tick > 0 && reading.age_s <= freshSeconds(rate_hz);
  return reading;
}

namespace {

using RigidForces = decltype(ForceSample::rigid_force);
using RigidWords = std::array<std::uint64_t, sizeof(RigidForces) / sizeof(std::uint64_t)>;

/// The words of a sample one after another.
struct Packer {
  std::uint64_t* word;
  void add(std::uint64_t value) { *word++ = value; }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Vec3& value) {
    for (const double component : value) add(component);
  }
  void add(const RigidWords& words) {
    for (const std::uint64_t value : words) add(value);
  }
};

struct Unpacker {
  const std::uint64_t* word;
  std::uint64_t whole() { return *word++; }
  double real() { return std::bit_cast<double>(whole()); }
  Vec3 vector() {
    const double x = real(), y = real(), z = real();
    return {x, y, z};
  }
  RigidForces rigid() {
    RigidWords words;
    for (std::uint64_t& value : words) value = whole();
    return std::bit_cast<RigidForces>(words);
  }
};

}  // namespace

void ForceOutput::publish(const ForceSample& s) {
  LatestWords<48>::Words words{};
  Packer packer{words.data()};
  packer.add(std::bit_cast<std::uint64_t>(s.tick));
  packer.add(std::bit_cast<std::uint64_t>(s.wall_ns));
  packer.add(s.time_s);
  packer.add(s.depth_m);
  packer.add(s.advance_m);
  packer.add(s.force_raw);
  packer.add(s.force_filtered);
  packer.add(static_cast<std::uint64_t>(s.doubt));
  packer.add(s.expected_error);
  packer.add(s.error_force);
  packer.add(std::bit_cast<std::uint64_t>(std::int64_t{s.error_by}));
  packer.add(s.tool_pose.position);
  for (const double component : s.tool_pose.orientation.coeffs()) packer.add(component);
  packer.add(s.torque);
  packer.add(s.contact_normal);
  packer.add(s.stiffness);
  packer.add(s.work_J);
  packer.add(s.pose_sequence);
  packer.add(std::bit_cast<std::uint64_t>(s.loss_count));
  packer.add(static_cast<std::uint64_t>(s.contact_count));
  packer.add(static_cast<std::uint64_t>(s.frozen));
  packer.add(static_cast<std::uint64_t>(s.node_count));
  packer.add(static_cast<std::uint64_t>(s.place_late));
  packer.add(std::bit_cast<RigidWords>(s.rigid_force));
  words_.publish(words);
}

ForceSample ForceOutput::latest() const {
  const LatestWords<48>::Words words = words_.latest();
  Unpacker unpacker{words.data()};
  ForceSample s;
  s.tick = std::bit_cast<std::int64_t>(unpacker.whole());
  s.wall_ns = std::bit_cast<std::int64_t>(unpacker.whole());
  s.time_s = unpacker.real();
  s.depth_m = unpacker.real();
  s.advance_m = unpacker.real();
  s.force_raw = unpacker.vector();
  s.force_filtered = unpacker.vector();
  s.doubt = static_cast<Doubt>(unpacker.whole());
  s.expected_error = unpacker.real();
  s.error_force = unpacker.real();
  s.error_by = static_cast<int>(std::bit_cast<std::int64_t>(unpacker.whole()));
  s.tool_pose.position = unpacker.vector();
  for (double& component : s.tool_pose.orientation.coeffs()) component = unpacker.real();
  s.torque = unpacker.vector();
  s.contact_normal = unpacker.vector();
  s.stiffness = unpacker.real();
  s.work_J = unpacker.real();
  s.pose_sequence = unpacker.whole();
  s.loss_count = std::bit_cast<std::int64_t>(unpacker.whole());
  s.contact_count = static_cast<int>(unpacker.whole());
  s.frozen = unpacker.whole() != 0;
  s.node_count = static_cast<int>(unpacker.whole());
  s.place_late = unpacker.whole() != 0;
  s.rigid_force = unpacker.rigid();
  return s;
}

}  // namespace palpate
