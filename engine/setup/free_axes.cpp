#include "setup/free_axes.h"

namespace palpate {

Vec3 freeAxes(const Body& body) {
  unsigned held = 0;
  for (const std::uint8_t imposed : body.imposed) held |= imposed;
  if (held == 0 && body.scene.rigid.empty()) return Vec3::Zero();
  return {held & 1U ? 0.0 : 1.0, held & 2U ? 0.0 : 1.0, held & 4U ? 0.0 : 1.0};
}

}  // namespace palpate
