#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "setup/place.h"

namespace palpate {

/// The places of one scene for all who run it (simulations of one model, tasks, equilibria). While somebody has a
/// place, whoever asks for it gets the same one; else it is made, or read where it was kept. Equal bits in any case.
/// Any thread. Test: simulation/place_test.cpp
class PlaceSource {
 public:
  /// @param start  the place at which the tools start: for as long as this lives
  PlaceSource(std::shared_ptr<const Places> places, std::shared_ptr<const Place> start, PlaceStore store = {});

  const Places& places() const { return *places_; }
  const std::shared_ptr<const Place>& start() const { return start_; }
  /// Whether a place that was made once is read from then on.
  bool keeps() const { return store_.keep && !places_->key.empty(); }

  /// Throws as makePlace does.
  std::shared_ptr<const Place> at(const PlaceIndex& index);

 private:
  std::shared_ptr<const Place> find(const PlaceIndex& index);

  const std::shared_ptr<const Places> places_;
  const std::shared_ptr<const Place> start_;
  const PlaceStore store_;
  std::mutex mutex_;
  std::map<PlaceIndex, std::weak_ptr<const Place>> made_;
  std::mutex memory_mutex_;
  PlaceMemory memory_;  // of one maker at a time: others do without
};

}  // namespace palpate
