#include "realtime/loop/place_worker.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "base/free_memory.h"
#include "base/parallel_for.h"
#include "realtime/loop/thread_setup.h"

namespace palpate {
namespace {

constexpr std::size_t returned_capacity = 16;  // the loop has two at most
// Places around one, those that a tool may come to next, on disk; in memory as many as there is room for.
constexpr std::size_t kept_around = 6;
constexpr double as_far_as = 1.8;  // strides

}  // namespace

PlaceWorker::PlaceWorker(const Places& places, Make make, std::shared_ptr<ReadyPlace> start, int threads, bool kept)
    : places_(places),
      make_(std::move(make)),
      threads_(threads),
      kept_(kept),
      start_(std::move(start)),
      wishes_(Wish{}),
      returned_(returned_capacity),
      failures_(no_place) {
  shelf_[start_->place.index] = {start_, ++uses_};
  seen_.insert(start_->place.index);
  thread_ = std::thread([this] { work(); });
}

PlaceWorker::~PlaceWorker() {
  stop_.store(true, std::memory_order_relaxed);
  wish_count_.fetch_add(1, std::memory_order_release);
  wish_count_.notify_one();
  thread_.join();
  clear();
  delete take();
}

void PlaceWorker::want(const Wish& wish) {
  if (wish == wanted_) return;
  wishes_.back() = wanted_ = wish;
  wishes_.publish();
  wish_count_.fetch_add(1, std::memory_order_release);
  wish_count_.notify_one();
}

PlaceChange* PlaceWorker::take() {
  PlaceChange* const change = ready_.exchange(nullptr, std::memory_order_acq_rel);
  if (change != nullptr) wanted_ = {};  // the same may be wanted once more
  return change;
}

bool PlaceWorker::failed(const PlaceIndex& index) { return index != no_place && failures_.latest() == index; }

std::string PlaceWorker::failure() const {
  const std::lock_guard lock(failure_mutex_);
  return failure_;
}

void PlaceWorker::fail(const PlaceIndex& index, const std::string& why) {
  {
    const std::lock_guard lock(failure_mutex_);
    if (failure_.empty()) failure_ = why;
  }
  failures_.back() = index;
  failures_.publish();
}

/// The changes that the loop is done with.
void PlaceWorker::clear() {
  for (PlaceChange* change = nullptr; returned_.pop(change);) delete change;
}

std::shared_ptr<const Place> PlaceWorker::make(const PlaceIndex& index) {
  const auto start = std::chrono::steady_clock::now();
  std::shared_ptr<const Place> made = make_(index);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  made_seconds_.store(made_seconds_.load(std::memory_order_relaxed) + seconds, std::memory_order_relaxed);
  made_count_.fetch_add(1, std::memory_order_relaxed);
  seen_.insert(index);
  return made;
}

std::shared_ptr<ReadyPlace> PlaceWorker::at(const PlaceIndex& index) {
  if (const auto found = shelf_.find(index); found != shelf_.end()) {
    found->second.used = ++uses_;
    return found->second.place;
  }
  while (shelf_.size() >= most()) {  // before it is made, which takes memory of its own
    auto oldest = shelf_.end();
    for (auto it = shelf_.begin(); it != shelf_.end(); ++it)
      if (!isHeld(it->second) && (oldest == shelf_.end() || it->second.used < oldest->second.used)) oldest = it;
    if (oldest == shelf_.end()) break;
    shelf_.erase(oldest);
  }
  auto place = std::make_shared<ReadyPlace>(make(index), start_->workspace);
  shelf_[index] = {place, ++uses_};
  return place;
}

/// Of the places around one, where some tool may go next, the nearest that is not in memory, nor was kept on disk;
/// no_place: all are.
PlaceIndex PlaceWorker::missingNeighbour(const PlaceIndex& index) const {
  std::vector<std::pair<double, PlaceIndex>> around;
  for (std::size_t t = 0; t < index.size() && index[t] >= 0; ++t)
    for (std::size_t c = 0; c < places_.centres.size(); ++c) {
      const double distance = (places_.centres[c] - places_.centres[static_cast<std::size_t>(index[t])]).norm();
      if (static_cast<int>(c) == index[t] || distance > as_far_as * places_.sizes.stride) continue;
      around.emplace_back(distance, index).second[t] = static_cast<int>(c);
    }
  std::sort(around.begin(), around.end());
  std::size_t held = 0;
  for (const auto& each : shelf_) held += isHeld(each.second);
  around.resize(std::min(around.size(), kept_ ? kept_around : most() - std::min(held, most())));
  for (const auto& [distance, place] : around)
    if (!shelf_.contains(place) && !(kept_ && seen_.contains(place))) return place;
  return no_place;
}

void PlaceWorker::work() {
  std::optional<OwnSetupThreads> own;
  int threads = 0;
  Wish done;
  std::uint32_t seen = 0;
  int given_back = 0;  // places made by then
  while (!stop_.load(std::memory_order_relaxed)) {
    if (const int wanted = threads_.load(std::memory_order_relaxed); wanted != threads) {
      setUpViewerThread();  // gives way to the loop, as whoever draws
      own.emplace(threads = wanted);
    }
    const std::uint32_t count = wish_count_.load(std::memory_order_acquire);
    const Wish wish = wishes_.latest();
    clear();
    PlaceIndex made = no_place;
    try {
      if (count != seen) {
        seen = count;
        const bool there =
            ready_.load(std::memory_order_acquire) != nullptr && wish.from == done.from && wish.to == done.to;
        if (wish.to != no_place && !there) {
          made = wish.to;
          auto change = std::make_unique<PlaceChange>(at(wish.from), at(wish.to), places_);
          done = wish;
          delete ready_.exchange(change.release(), std::memory_order_acq_rel);
          continue;
        }
      }
      made = wish.then;
      const bool is_idle = made == no_place && wish.to == no_place && threads > 0;
      if (is_idle) made = missingNeighbour(wish.from);
      if (made != no_place && !shelf_.contains(made) && !(kept_ && seen_.contains(made))) {
        if (kept_ && is_idle)
          make(made);  // for the disk
        else
          at(made);
        continue;
      }
    } catch (const std::exception& error) {
      fail(made, error.what());
    }
    if (std::exchange(given_back, madeCount()) != madeCount()) giveFreeMemoryBack();
    wish_count_.wait(count, std::memory_order_acquire);
  }
}

}  // namespace palpate
