#include "base/key.h"
#include "imaging/membership.h"
#include "model/preparation.h"

namespace palpate {

std::string preparationKey(const Scene& scene, const TriangleSurface& organ) {
  ByteKey key;
  key.add(organ.vertices, organ.triangles);
  // What other files of the scene say.
  std::string memberships;
  for (const MaterialSpec& m : scene.materials)
    if (m.membership) memberships += identityOf(*m.membership);
  for (const BoundarySpec& b : scene.boundaries)
    if (b.region.kind == Region::Kind::Point) key.add(b.region.point, b.component[0], b.component[1], b.component[2]);
  return key.bytes() + memberships + scene.set_up_values;
}

}  // namespace palpate
