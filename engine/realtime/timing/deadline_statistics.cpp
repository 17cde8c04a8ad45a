#include "realtime/timing/deadline_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace palpate {
namespace {

constexpr std::int64_t kSubBins = std::int64_t{1} << DurationHistogram::kSubBits;
constexpr std::int64_t kLargest = (std::int64_t{1} << (DurationHistogram::kSubBits + DurationHistogram::kOctaves)) - 1;

std::int64_t binBegin(int b) {  // ns
  if (b < kSubBins) return b;
  const int octave = static_cast<int>((b - kSubBins) / kSubBins);
  return (kSubBins + (b - kSubBins) % kSubBins) << octave;
}

// For counters with one writer: no locked instruction needed.
void bump(std::atomic<std::int64_t>& counter) {
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

int DurationHistogram::binOf(std::int64_t ns) {
  ns = std::clamp<std::int64_t>(ns, 0, kLargest);
  if (ns < kSubBins) return static_cast<int>(ns);
  const int octave = std::bit_width(static_cast<std::uint64_t>(ns)) - 1 - kSubBits;
  return static_cast<int>(kSubBins * octave + (ns >> octave));
}

double DurationHistogram::binBeginUs(int b) { return 1e-3 * static_cast<double>(binBegin(b)); }

void DurationHistogram::add(std::int64_t ns) {
  ns = std::max<std::int64_t>(ns, 0);
  bump(bins_[static_cast<std::size_t>(binOf(ns))]);
  bump(count_);
  if (ns > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(ns, std::memory_order_relaxed);
}

double DurationHistogram::percentileUs(double p) const {
  std::int64_t total = 0;  // not count(): while the writer runs, the two may differ by one
  for (int b = 0; b < kBinCount; ++b) total += binCount(b);
  if (total == 0) return 0;
  const auto rank =
      std::clamp<std::int64_t>(static_cast<std::int64_t>(std::ceil(p * static_cast<double>(total))), 1, total);
  if (rank == total) return maxUs();
  std::int64_t below = 0;
  for (int b = 0; b < kBinCount; ++b) {
    below += binCount(b);
    if (below >= rank) {
      const double middle = 0.5e-3 * static_cast<double>(binBegin(b) + binBegin(b + 1) - 1);
      return std::min(middle, maxUs());
    }
  }
  return maxUs();
}

Percentiles DurationHistogram::percentiles() const {
  return {percentileUs(0.5), percentileUs(0.99), percentileUs(0.999), maxUs()};
}

}  // namespace palpate
