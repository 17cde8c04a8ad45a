#pragma once

#include <string>
#include <vector>

#include "imaging/isosurface.h"

namespace palpate::organs {

/// An organ as a formula. z points up; x runs from the patient's right to left.
struct Organ {
  std::string name;         // of the file, without ".obj"
  std::string description;  // one line, the file's header
  Vec3 min, max;            // a box with the whole organ well inside it, m
  double edge_length;       // of the triangles, m
  Field field;
};

/// The organs that this program knows, in a fixed order.
const std::vector<Organ>& allOrgans();

/// The zero level of `organ.field` inside its box on a grid of spacing `cell` (m): palpate::isosurface.
/// @throws InputError if the surface reaches the box.
TriangleSurface isosurface(const Organ& organ, double cell);

}  // namespace palpate::organs
