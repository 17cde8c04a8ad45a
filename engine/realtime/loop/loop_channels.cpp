#include "realtime/loop/loop_channels.h"

namespace palpate {
namespace {

constexpr std::size_t kCommandCapacity = 1024;
constexpr std::size_t kLogCapacity = 1024;

}  // namespace

LoopChannels::LoopChannels(const Model& model, const State& state, std::size_t force_capacity,
                           std::size_t record_capacity)
    : commands(kCommandCapacity),
      hand(HandPose{}),
      snapshots(makeSnapshot(static_cast<int>(state.u.size()),
                             static_cast<int>(state.contact.vertex.size() + 3 * state.contact.samples.id.size()),
                             static_cast<int>(model.materials.size()))),
      forces(force_capacity),
      log(kLogCapacity),
      recorded(record_capacity) {}

}  // namespace palpate
