#include "api/border.h"
#include "api/handles.h"
#include "contact/skin.h"

using namespace palpate;
using namespace palpate::api;

extern "C" {

int32_t palpate_skin_positions(palpate_simulation* simulation, float* positions, int32_t vertex_count) {
  if (simulation == nullptr || positions == nullptr) return PALPATE_BAD_ARGUMENT;
  const SkinModel& skin = simulation->model->skin;
  if (vertex_count != skin.vertexCount()) return PALPATE_BAD_ARGUMENT;
  const Snapshot& snapshot = simulation->loop.snapshots().latest();
  for (int v = 0; v < vertex_count; ++v) {
    const Vec3f x = skinPosition(skin, v, snapshot.u.data()).cast<float>();
    positions = std::copy_n(x.data(), 3, positions);
  }
  return PALPATE_OK;
}

int32_t palpate_contacts(palpate_simulation* simulation, int32_t* vertex, float* force, int32_t capacity,
                         int32_t* count) {
  if (simulation == nullptr || count == nullptr || capacity < 0) return PALPATE_BAD_ARGUMENT;
  if (capacity > 0 && (vertex == nullptr || force == nullptr)) return PALPATE_BAD_ARGUMENT;
  const Snapshot& snapshot = simulation->loop.snapshots().latest();
  *count = snapshot.contact_entries;
  for (std::size_t k = 0; k < static_cast<std::size_t>(std::min(capacity, *count)); ++k) {
    const Float4& f = snapshot.contact_force[k];
    vertex[k] = snapshot.contact_vertex[k];
    *force++ = f.x;
    *force++ = f.y;
    *force++ = f.z;
  }
  return PALPATE_OK;
}

}  // extern "C"
