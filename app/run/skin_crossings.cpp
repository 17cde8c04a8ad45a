#include "app/run/skin_crossings.h"

#include <algorithm>

#include "discretization/surface/surface_parts.h"

namespace palpate::app {
namespace {

/// Six times the signed volume of a tetrahedron.
double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// m, from a plane, within which what lies on which side is a matter of rounding; of two organs the contact's.
constexpr double in_plane = 1e-7, in_contact = 1e-4;

/// The segment p q goes through the triangle's inside, further than `within` (m) from its edges, with both ends further
/// than that from its plane.
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c, double within) {
  const Vec3 normal = (b - a).cross(c - a);
  const double from = normal.dot(p - a), to = normal.dot(q - a), least = within * normal.norm();
  if (std::min(from, to) >= -least || std::max(from, to) <= least) return false;
  int side = 0;
  const auto passes = [&](const Vec3& x, const Vec3& y) {
    const double v = volume(p, q, x, y);
    side += v > 0 ? 1 : -1;
    return std::abs(v) > within * (q - p).cross(y - x).norm();
  };
  return passes(a, b) && passes(b, c) && passes(c, a) && std::abs(side) == 3;
}

}  // namespace

SkinCrossings::SkinCrossings(const SkinModel& skin)
    : skin_(&skin),
      part_(connectedParts(skin.surface, faceEdges(skin.surface)).part),
      x_(skin.surface.vertices.size()),
      box_(skin.surface.triangles.size()),
      spans_(skin.surface.triangles.size()) {}

bool SkinCrossings::cross(int a, int b) const {
  const std::array<int, 3>&s = skin_->surface.triangles[a], &t = skin_->surface.triangles[b];
  for (const int v : s)
    if (std::find(t.begin(), t.end(), v) != t.end()) return false;
  const double within = part_[a] == part_[b] ? in_plane : in_contact;
  for (std::size_t k = 0; k < 3; ++k)
    if (pierces(x_[s[k]], x_[s[(k + 1) % 3]], x_[t[0]], x_[t[1]], x_[t[2]], within) ||
        pierces(x_[t[k]], x_[t[(k + 1) % 3]], x_[s[0]], x_[s[1]], x_[s[2]], within))
      return true;
  return false;
}

int SkinCrossings::count(const Float4* u) {
  for (std::size_t v = 0; v < x_.size(); ++v) x_[v] = skinPosition(*skin_, static_cast<int>(v), u);
  for (std::size_t t = 0; t < box_.size(); ++t) {
    box_[t].setEmpty();
    for (const int v : skin_->surface.triangles[t]) box_[t].extend(x_[v]);
    spans_[t] = {box_[t].min().x(), box_[t].max().x(), static_cast<int>(t)};
  }
  std::sort(spans_.begin(), spans_.end(), [](const Span& a, const Span& b) { return a.low < b.low; });
  int count = 0;
  for (auto a = spans_.begin(); a != spans_.end(); ++a)
    for (auto b = a + 1; b != spans_.end() && b->low <= a->high; ++b)
      count += box_[a->triangle].intersects(box_[b->triangle]) && cross(a->triangle, b->triangle);
  return count;
}

}  // namespace palpate::app
