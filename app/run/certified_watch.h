#pragma once

#include <cstdint>
#include <vector>

#include "io/certificate.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// Whether a scene's certificate holds for what a tool does: as long as it is within a quarter of the touching radius
/// (touchRadius) of the certified way since it touched. A tool that is dragged there, or away and back, has another
/// force.
/// Test: app/run/certified_watch_test.cpp
class CertifiedWatch {
 public:
  /// @param touch_radius  m
  CertifiedWatch(Certificate certificate, double touch_radius);

  /// Each tick's, in order.
  void add(const ForceSample& sample);

  /// At a tick that was added; false without contact.
  bool holds(std::int64_t tick) const;
  const Certificate& certificate() const { return certificate_; }

 private:
  Certificate certificate_;
  double beside_;  // m
  bool strayed_ = false;
  std::vector<std::int64_t> turns_;  // ticks at which it began and ceased to hold
};

}  // namespace palpate::app
