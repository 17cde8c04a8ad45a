#include "app/panels/force_history.h"

#include <algorithm>

namespace palpate::app {

namespace {
constexpr float mm_per_m = 1e3F;
}

void ForceHistory::clear() {
  for (auto* curve : {&raw_time_, &filtered_time_, &raw_depth_, &filtered_depth_}) curve->clear();
  first_ = 0;
  last_time_ = -1;
  peak_raw_ = peak_filtered_ = 0;
  trust_ = {};
  samples_ = doubted_ = 0;
}

void ForceHistory::add(const ForceSample& sample, const ToolReadings& readings) {
  if (sample.time_s < last_time_) clear();
  if (sample.time_s == last_time_) return;  // the same tick, drawn twice
  last_time_ = sample.time_s;

  const auto time = static_cast<float>(sample.time_s);
  const auto depth = static_cast<float>(sample.depth_m) * mm_per_m;
  const double raw = sample.force_raw.norm(), filtered = sample.force_filtered.norm();
  raw_time_.push_back({time, static_cast<float>(raw)});
  filtered_time_.push_back({time, static_cast<float>(filtered)});
  raw_depth_.push_back({depth, static_cast<float>(raw)});
  filtered_depth_.push_back({depth, static_cast<float>(filtered)});
  peak_raw_ = std::max(peak_raw_, raw);
  peak_filtered_ = std::max(peak_filtered_, filtered);
  const bool several = readings.count > 1;
  for (int k = 0; several && k < static_cast<int>(readings.count); ++k) {
    const ToolReading& tool = readings.tool[static_cast<std::size_t>(k)];
    trust_.add(Doubt::None, tool.expected_error, tool.error_force, sample.time_s, k);
  }
  const bool added = several && sample.error_by >= 0 && sample.error_by < max_tools;
  trust_.add(sample.doubt, added ? 0 : sample.expected_error, added ? 0 : sample.error_force, sample.time_s,
             sample.error_by);
  ++samples_;
  doubted_ += sample.doubt != Doubt::None ? 1 : 0;

  while (raw_time_[first_].x < time - static_cast<float>(seconds_)) ++first_;
  if (first_ > 1024 && 2 * first_ > raw_time_.size()) {  // seldom, so that adding stays cheap
    const auto old = static_cast<std::ptrdiff_t>(first_);
    for (auto* curve : {&raw_time_, &filtered_time_, &raw_depth_, &filtered_depth_})
      curve->erase(curve->begin(), curve->begin() + old);
    first_ = 0;
  }
}

}  // namespace palpate::app
