#pragma once

#include <random>
#include <vector>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"

namespace palpate::test {

// What the tests of the loop give it and take from it.

inline Pose poseAt(const Vec3& position, double angle = 0) {
  Pose pose;
  pose.position = position;
  pose.orientation = Quat(Eigen::AngleAxisd(angle, Vec3(1, 1, 0).normalized()));
  return pose;
}

/// A wandering tool, as a script would give it.
inline std::vector<Pose> wander(int ticks, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> step(0, 1e-4);
  std::vector<Pose> poses;
  Vec3 p(0, 0, 0.1);
  for (int k = 0; k < ticks; ++k) {
    p += Vec3(step(random), step(random), step(random));
    poses.push_back(poseAt(p, 0.001 * k));
  }
  return poses;
}

/// A track that moves the tool to poses[k] in tick k.
inline std::vector<TimedRequest> trackFromPoses(const std::vector<Pose>& poses) {
  std::vector<TimedRequest> track;
  for (std::size_t k = 0; k < poses.size(); ++k)
    track.push_back({static_cast<std::int64_t>(k), Request::moveTool(poses[k])});
  return track;
}

inline SimulationLoopOptions limited(std::int64_t ticks) {
  SimulationLoopOptions options;
  options.tick_limit = ticks;
  return options;
}

template <class T>
std::vector<T> drain(SpscRing<T>& ring) {
  std::vector<T> all;
  T value;
  while (ring.pop(value)) all.push_back(value);
  return all;
}

inline bool has(const std::vector<LogEvent>& events, LogEvent::Kind kind) {
  for (const LogEvent& event : events) {
    if (event.kind == kind) return true;
  }
  return false;
}

}  // namespace palpate::test
