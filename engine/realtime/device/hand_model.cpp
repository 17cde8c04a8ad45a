#include "realtime/device/hand_model.h"

#include <cmath>
#include <numbers>

namespace palpate {
namespace {

/// 0 to 1 between the times, gently at both ends.
double rise(double t, double from, double to) {
  const double s = t <= from ? 0 : t >= to ? 1 : (t - from) / (to - from);
  return s * s * s * (10 + s * (6 * s - 15));
}

}  // namespace

double SteadyRandom::next() {
  state_ += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

Vec3 HandMotion::at(double seconds) const {
  if (kind == Kind::Press) {
    const double s = std::fmod(seconds, period) / period;
    const double pressed = rise(s, 0.05, 0.25) - rise(s, 0.85, 0.97);
    return depth * pressed * down + slide * (rise(s, 0.6, 0.7) - rise(s, 0.72, 0.82)) * along;
  }
  if (kind == Kind::Wander) {
    const double presses = std::floor(seconds / period), s = seconds / period - presses;
    const auto place = [&](double press) {
      if (press < 1) return Vec3(Vec3::Zero());
      SteadyRandom random(seed + static_cast<std::uint64_t>(press));
      const double far = slide * std::sqrt(random.next()), angle = 2 * std::numbers::pi * random.next();
      return Vec3(far * (std::cos(angle) * along + std::sin(angle) * down.cross(along)));
    };
    const double on_the_way = rise(s, 0, 0.15), pressed = rise(s, 0.15, 0.4) - rise(s, 0.75, 0.95);
    return (1 - on_the_way) * place(presses - 1) + on_the_way * place(presses) + depth * pressed * down;
  }
  constexpr int kSines = 8;
  constexpr double kSlowest = 0.2, kRatio = 1.53;  // Hz: 0.2 to 4
  SteadyRandom random(seed);
  double deep = 0, side = 0, frequency = kSlowest, all = 0;
  for (int k = 0; k < kSines; ++k, frequency *= kRatio) {
    const double share = 1 / (1 + frequency), phase = 2 * std::numbers::pi * random.next();
    const double other = 2 * std::numbers::pi * random.next();
    deep += share * std::sin(2 * std::numbers::pi * frequency * seconds + phase);
    side += share * std::sin(2 * std::numbers::pi * frequency * seconds + other);
    all += share;
  }
  const double begins = rise(seconds, 0, 0.5);
  return begins * (depth * (0.5 + deep / all) * down + slide * side / all * along);
}

Vec3 HandMotion::turnAt(double seconds) const {
  return rise(seconds, 0, rock_period) * rock * std::sin(2 * std::numbers::pi * seconds / rock_period) * along;
}

}  // namespace palpate
