#include "realtime/device/device_packet.h"

#include <bit>
#include <cmath>

namespace palpate {
namespace {

class PacketWriter {
 public:
  void whole(std::uint64_t value, int bytes) {
    for (int b = 0; b < bytes; ++b) packet_[at_++] = static_cast<unsigned char>(value >> (8 * b));
  }
  void real(double value) { whole(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4); }
  void vector(const Vec3& v) {
    for (const double c : v) real(c);
  }
  const DevicePacket& packet() const { return packet_; }

 private:
  DevicePacket packet_{};  // what is not written stays 0
  std::size_t at_ = 0;
};

class PacketReader {
 public:
  explicit PacketReader(const unsigned char* bytes) : bytes_(bytes) {}
  std::uint64_t whole(int bytes) {
    std::uint64_t value = 0;
    for (int b = 0; b < bytes; ++b) value |= static_cast<std::uint64_t>(*bytes_++) << (8 * b);
    return value;
  }
  std::uint32_t word() { return static_cast<std::uint32_t>(whole(4)); }
  double real() { return static_cast<double>(std::bit_cast<float>(word())); }
  Vec3 vector() {
    const double x = real(), y = real(), z = real();
    return {x, y, z};
  }

 private:
  const unsigned char* bytes_;
};

}  // namespace

bool isSane(const DevicePose& p) {
  const double turn = p.pose.orientation.norm();
  return p.pose.position.allFinite() && p.pose.orientation.coeffs().allFinite() && p.velocity.allFinite() &&
         p.pose.position.norm() <= 10 && p.velocity.norm() <= 100 && turn > 0.5 && turn < 2;
}

DevicePacket packetOf(const DevicePose& p) {
  PacketWriter out;
  out.whole(pose_magic, 4);
  out.whole(p.sequence, 4);
  out.whole(p.felt, 4);
  out.whole(p.buttons, 4);
  out.whole(std::bit_cast<std::uint64_t>(p.sent_ns), 8);
  out.vector(p.pose.position);
  for (const double c : p.pose.orientation.coeffs()) out.real(c);  // x, y, z, w
  out.vector(p.has_velocity ? p.velocity : Vec3(Vec3::Constant(std::nan(""))));
  return out.packet();
}

DevicePacket packetOf(const DeviceWrench& w) {
  PacketWriter out;
  out.whole(force_magic, 4);
  out.whole(w.sequence, 4);
  out.whole(w.answers, 4);
  out.whole(w.touching ? 1 : 0, 4);
  out.whole(std::bit_cast<std::uint64_t>(w.sent_ns), 8);
  out.vector(w.force);
  out.vector(w.torque);
  out.whole((w.doubted ? 1 : 0) | (w.short_of_force ? 2 : 0), 4);
  return out.packet();
}

bool readPacket(const unsigned char* bytes, std::size_t count, DevicePose& pose) {
  if (count != DevicePacket().size()) return false;
  PacketReader in(bytes);
  if (in.word() != pose_magic) return false;
  DevicePose p;
  p.sequence = in.word();
  p.felt = in.word();
  p.buttons = in.word();
  p.sent_ns = std::bit_cast<std::int64_t>(in.whole(8));
  p.pose.position = in.vector();
  for (double& c : p.pose.orientation.coeffs()) c = in.real();
  p.velocity = in.vector();
  p.has_velocity = p.velocity.allFinite();
  if (!p.has_velocity) p.velocity.setZero();
  if (p.sequence == 0 || !isSane(p)) return false;
  p.pose.orientation.normalize();
  pose = p;
  return true;
}

bool readPacket(const unsigned char* bytes, std::size_t count, DeviceWrench& wrench) {
  if (count != DevicePacket().size()) return false;
  PacketReader in(bytes);
  if (in.word() != force_magic) return false;
  DeviceWrench w;
  w.sequence = in.word();
  w.answers = in.word();
  w.touching = in.word() != 0;
  w.sent_ns = std::bit_cast<std::int64_t>(in.whole(8));
  w.force = in.vector();
  w.torque = in.vector();
  const std::uint32_t flags = in.word();
  w.doubted = (flags & 1) != 0;
  w.short_of_force = (flags & 2) != 0;
  wrench = w;
  return w.force.allFinite() && w.torque.allFinite();
}

}  // namespace palpate
