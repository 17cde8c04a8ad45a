#include "discretization/point_grid.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {
constexpr double most_cells = 4e6;  // 16 MB of list heads
}

PointGrid::PointGrid(const Eigen::AlignedBox3d& box, double cell) : origin_(box.min()), cell_(cell) {
  const auto cellCount = [&](double edge) { return ((box.sizes() / edge).array().floor() + 1).prod(); };
  while (cellCount(cell_) > most_cells) cell_ *= 1.25;
  count_ = (box.sizes() / cell_).array().floor().cast<int>() + 1;
  first_.assign(static_cast<std::size_t>(count_.x()) * count_.y() * count_.z(), -1);
}

void PointGrid::clear() {
  for (const Entry& entry : entries_) first_[slot(cellOf(entry.x))] = -1;
  entries_.clear();
}

void PointGrid::add(int index, const Vec3& x) {
  int& first = first_[slot(cellOf(x))];
  entries_.push_back({x, index, first});
  first = static_cast<int>(entries_.size()) - 1;
}

}  // namespace palpate
