#pragma once

#include <utility>
#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// Faces joined across edges that exactly two faces have, and what is seen of them from outside (orientPatches).
struct Patch {
  std::vector<int> faces;
  bool closed = true;
  bool has_inside = false;  // closed, or nearly
  bool turned = false;      // as a whole, against the file
  bool hidden = false;      // not seen from outside
  bool nested = false;      // has an inside, and is inside others
  bool removed = false;
  double area = 0, volume = 0;
  int front = 0, back = 0, rays = 0;  // rays that escaped, of so many on each side
};

/// Makes the faces of each patch turn alike, as most of them do, and lists the patches. Neighbours that agree are
/// joined first: where a tangle contradicts itself, the file's own sense counts.
/// @param face_turned  (triangle_count) gets 1 where a face was turned
std::vector<Patch> alikePatches(TriangleSurface& surface, std::vector<char>& face_turned);

inline void turnFace(std::array<int, 3>& t) { std::swap(t[1], t[2]); }

/// Middle of face t, m.
Vec3 faceMiddle(const TriangleSurface& surface, int t);

}  // namespace palpate
