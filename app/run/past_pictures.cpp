#include "app/run/past_pictures.h"

#include <algorithm>

#include "setup/place.h"

namespace palpate::app {

namespace {

std::size_t bytesOf(const Snapshot& s) {
  return sizeof s + s.u.size() * sizeof(Float4) + s.contact_vertex.size() * (sizeof(int) + sizeof(Float4)) +
         s.materials.size() * sizeof(Material);
}

/// Of the place that a snapshot is of, where it is another than that of the one before: it stays in memory for it.
std::size_t bytesOfPlace(const Snapshot& s, const std::shared_ptr<const Place>& before) {
  if (!s.place || s.place == before) return 0;
  const Model& model = s.place->model;
  constexpr std::size_t gradient = sizeof(Vec3) + sizeof(double) + sizeof(int), value = sizeof(float) + sizeof(int);
  return 2 * model.point_shape.N.size() * gradient + model.skin.N.size() * value;  // the kernel's, too
}

}  // namespace

void PastPictures::add(const Snapshot& snapshot) {
  const double time = snapshot.force.time_s;
  if (!kept_.empty()) {
    const double last = kept_.back().force.time_s;
    if (time < last) {
      kept_.clear();
      bytes_ = 0;
    } else if (time < last + apart) {
      return;
    }
  }
  bytes_ += bytesOfPlace(snapshot, kept_.empty() ? nullptr : kept_.back().place);
  kept_.push_back(snapshot);
  Snapshot& copy = kept_.back();  // without the room for contacts that it does not use
  const auto used = static_cast<std::size_t>(std::max(snapshot.contact_entries, snapshot.contact_count));
  copy.contact_vertex.resize(std::min(used, copy.contact_vertex.size()));
  copy.contact_force.resize(std::min(used, copy.contact_force.size()));
  copy.contact_vertex.shrink_to_fit();
  copy.contact_force.shrink_to_fit();
  bytes_ += bytesOf(copy);
  while (kept_.size() > 1 && (kept_.front().force.time_s < time - seconds || bytes_ > most_bytes)) {
    const std::shared_ptr<const Place> place = kept_.front().place;
    bytes_ -= bytesOf(kept_.front());
    if (place && kept_[1].place != place) bytes_ -= bytesOfPlace(kept_.front(), nullptr);
    kept_.pop_front();
  }
}

const Snapshot& PastPictures::at(double time_s) const {
  const auto later = std::upper_bound(kept_.begin(), kept_.end(), time_s,
                                      [](double time, const Snapshot& s) { return time < s.force.time_s; });
  return later == kept_.begin() ? kept_.front() : *(later - 1);
}

}  // namespace palpate::app
