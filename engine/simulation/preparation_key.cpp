#include "base/key.h"
#include "simulation/preparation.h"

namespace palpate {

std::string preparationKey(const Scene& scene, const TriangleSurface& organ) {
  ByteKey key;
  key.add(organ.vertices, organ.triangles);
  return key.bytes() + scene.set_up_values;
}

}  // namespace palpate
