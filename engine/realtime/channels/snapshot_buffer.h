#pragma once

#include "realtime/channels/snapshot.h"
#include "realtime/channels/triple_buffer.h"

namespace palpate {

/// The latest tick, from the loop to whoever draws.
///   loop thread:    back(), publish()
///   viewer thread:  latest(), hasNews()
using SnapshotBuffer = TripleBuffer<Snapshot>;

/// A snapshot at rest with memory for `node_count` nodes and `contact_capacity`
/// contacts: the initial value of a SnapshotBuffer.
Snapshot makeSnapshot(int node_count, int contact_capacity, int material_count = 0);

}  // namespace palpate
