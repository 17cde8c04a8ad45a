#include "realtime/loop/loop_channels.h"

namespace palpate {
namespace {

constexpr std::size_t kCommandCapacity = 1024;
constexpr std::size_t kLogCapacity = 1024;

/// Entries that the snapshot has room for.
int contactEntries(const State& state) {
  const auto entries = [](const ContactState& c) {
    return static_cast<int>(c.vertex.size() + 3 * c.samples.id.size());
  };
  int count = 0;
  for (const ContactState& contact : state.contact) count += entries(contact);
  return count;
}

}  // namespace

LoopChannels::LoopChannels(const Model& model, const State& state, std::size_t force_capacity,
                           std::size_t record_capacity)
    : commands(kCommandCapacity),
      hand(HandPose{}),
      snapshots(makeSnapshot(static_cast<int>(state.u.capacity()), contactEntries(state),
                             static_cast<int>(model.materials.size()))),
      forces(force_capacity),
      tools(model.tools.several() ? force_capacity : 1),
      log(kLogCapacity),
      recorded(record_capacity) {}

}  // namespace palpate
