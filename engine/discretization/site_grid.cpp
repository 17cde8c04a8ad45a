#include "discretization/site_grid.h"

namespace palpate {
namespace {
constexpr double most_cells = 4e6;  // 16 MB of first places
}

SiteGrid::SiteGrid(const Eigen::AlignedBox3d& box, double cell) : origin_(box.min()), cell_(cell) {
  const auto cellCount = [&](double edge) { return ((box.sizes() / edge).array().floor() + 1).prod(); };
  while (cellCount(cell_) > most_cells) cell_ *= 1.25;
  count_ = (box.sizes() / cell_).array().floor().cast<int>() + 1;
}

void SiteGrid::assign(const std::vector<Site>& sites) {
  first_.assign(static_cast<std::size_t>(count_.x()) * count_.y() * count_.z() + 1, 0);
  slot_of_.resize(sites.size());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    slot_of_[i] = slot(cellOf(sites[i].X));
    ++first_[slot_of_[i]];
  }
  int end = 0;  // each cell's; it fills from there down
  for (int& first : first_) first = end += first;
  ball_.resize(sites.size());
  normal_.resize(sites.size());
  index_.resize(sites.size());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const int place = --first_[slot_of_[i]];
    ball_[place] = {sites[i].X, sites[i].h};
    normal_[place] = sites[i].normal;
    index_[place] = static_cast<int>(i);
  }
}

}  // namespace palpate
