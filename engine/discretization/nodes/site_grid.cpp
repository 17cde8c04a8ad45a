#include "discretization/nodes/site_grid.h"

#include <algorithm>

namespace palpate {
namespace {
constexpr double max_cells = 4e6;  // 16 MB of first entries
}

SiteGrid::SiteGrid(const Box3& box, double cell) : origin_(box.min()), cell_(cell) {
  const auto cellCount = [&](double edge) { return ((box.sizes() / edge).array().floor() + 1).prod(); };
  while (cellCount(cell_) > max_cells) cell_ *= 1.25;
  count_ = (box.sizes() / cell_).array().floor().cast<int>() + 1;
  first_.assign(static_cast<std::size_t>(count_.x()) * count_.y() * count_.z(), -1);
}

void SiteGrid::assign(const std::vector<Site>& sites) {
  clear();
  // Counted cell by cell, then filled from each cell's end down: the site added last stands first, as add leaves it.
  std::vector<int> end(first_.size() + 1, 0);
  std::vector<std::size_t> cell(sites.size());
  for (std::size_t i = 0; i < sites.size(); ++i) ++end[cell[i] = slot(cellOf(sites[i].X))];
  int before = 0;
  for (int& e : end) e = before += e;
  entry_.resize(sites.size());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    int& first = first_[cell[i]];
    const int place = --end[cell[i]];
    entry_[place] = {sites[i], static_cast<int>(i), first};
    first = place;
  }
}

void SiteGrid::clear() {
  std::fill(first_.begin(), first_.end(), -1);
  entry_.clear();
}

void SiteGrid::add(const Site& site) {
  int& first = first_[slot(cellOf(site.X))];
  entry_.push_back({site, size(), first});
  first = size() - 1;
}

}  // namespace palpate
