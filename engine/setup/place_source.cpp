#include "setup/place_source.h"

#include <utility>

namespace palpate {

PlaceSource::PlaceSource(std::shared_ptr<const Places> places, std::shared_ptr<const Place> start, PlaceStore store)
    : places_(std::move(places)), start_(std::move(start)), store_(std::move(store)) {}

std::shared_ptr<const Place> PlaceSource::find(const PlaceIndex& index) {
  if (index == start_->index) return start_;
  const std::lock_guard lock(mutex_);
  const auto made = made_.find(index);
  return made != made_.end() ? made->second.lock() : nullptr;
}

std::shared_ptr<const Place> PlaceSource::at(const PlaceIndex& index) {
  if (auto place = find(index)) return place;
  const std::unique_lock memory(memory_mutex_, std::try_to_lock);
  auto place = std::make_shared<const Place>(makePlace(*places_, index, store_, memory ? &memory_ : nullptr));
  const std::lock_guard lock(mutex_);
  std::erase_if(made_, [](const auto& other) { return other.second.expired(); });
  std::weak_ptr<const Place>& slot = made_[index];
  if (auto other = slot.lock()) return other;  // made by another thread in the meantime
  slot = place;
  return place;
}

}  // namespace palpate
