#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/types.h"

namespace palpate::organs {

/// Negative inside the organ, positive outside, roughly a distance; m.
using Field = std::function<double(const Vec3&)>;

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

}  // namespace palpate::organs
