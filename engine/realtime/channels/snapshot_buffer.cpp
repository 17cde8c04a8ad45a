#include "realtime/channels/snapshot_buffer.h"

#include "setup/place.h"

namespace palpate {

const Model& modelOf(const Snapshot& snapshot, const Model& loaded) {
  return snapshot.place ? snapshot.place->model : loaded;
}

Snapshot makeSnapshot(int node_count, int contact_capacity, int material_count) {
  Snapshot snapshot;
  snapshot.u.assign(static_cast<std::size_t>(node_count), Float4{});
  snapshot.contact_vertex.assign(static_cast<std::size_t>(contact_capacity), -1);
  snapshot.contact_force.assign(static_cast<std::size_t>(contact_capacity), Float4{});
  snapshot.materials.resize(static_cast<std::size_t>(material_count));
  return snapshot;
}

}  // namespace palpate
