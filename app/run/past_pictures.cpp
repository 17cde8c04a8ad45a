#include "app/run/past_pictures.h"

#include <algorithm>

namespace palpate::app {

namespace {

std::size_t bytesOf(const Snapshot& s) {
  return sizeof s + s.u.size() * sizeof(Float4) + s.contact_vertex.size() * (sizeof(int) + sizeof(Float4)) +
         s.materials.size() * sizeof(Material);
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
  kept_.push_back(snapshot);
  Snapshot& copy = kept_.back();  // without the room for contacts that it does not use
  const auto used = static_cast<std::size_t>(std::max(snapshot.contact_entries, snapshot.contact_count));
  copy.contact_vertex.resize(std::min(used, copy.contact_vertex.size()));
  copy.contact_force.resize(std::min(used, copy.contact_force.size()));
  copy.contact_vertex.shrink_to_fit();
  copy.contact_force.shrink_to_fit();
  bytes_ += bytesOf(copy);
  while (kept_.size() > 1 && (kept_.front().force.time_s < time - seconds || bytes_ > most_bytes)) {
    bytes_ -= bytesOf(kept_.front());
    kept_.pop_front();
  }
}

const Snapshot& PastPictures::at(double time_s) const {
  const auto later = std::upper_bound(kept_.begin(), kept_.end(), time_s,
                                      [](double time, const Snapshot& s) { return time < s.force.time_s; });
  return later == kept_.begin() ? kept_.front() : *(later - 1);
}

}  // namespace palpate::app
