#include "approximation/neighbours.h"

#include <algorithm>
#include <nanoflann.hpp>

namespace palpate {
namespace {

struct Cloud {
  const std::vector<Vec3>& X;
  std::size_t kdtree_get_point_count() const { return X.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t d) const { return X[i][static_cast<int>(d)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

}  // namespace

struct Neighbours::Tree {
  using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3, std::uint32_t>;
  explicit Tree(const std::vector<Vec3>& X) : cloud{X}, index(3, cloud) { index.buildIndex(); }
  Cloud cloud;
  Index index;
};

Neighbours::Neighbours(const std::vector<Vec3>& X, const std::vector<double>& radius)
    : X_(X), radius_(radius), tree_(std::make_unique<Tree>(X)) {
  for (double r : radius) max_radius_ = std::max(max_radius_, r);
}

Neighbours::~Neighbours() = default;

void Neighbours::find(const Vec3& x, std::vector<int>& support) const {
  thread_local std::vector<std::pair<std::uint32_t, double>> matches;
  matches.clear();
  tree_->index.radiusSearch(x.data(), max_radius_ * max_radius_, matches, nanoflann::SearchParams(32, 0, false));
  support.clear();
  for (const auto& [j, distance2] : matches)
    if (distance2 < radius_[j] * radius_[j]) support.push_back(static_cast<int>(j));
  std::sort(support.begin(), support.end());
}

std::vector<int> Neighbours::nearest(const Vec3& x, int k) const {
  const std::size_t n = std::min<std::size_t>(k, X_.size());
  std::vector<std::uint32_t> index(n);
  std::vector<double> distance2(n);
  nanoflann::KNNResultSet<double, std::uint32_t> result(n);
  result.init(index.data(), distance2.data());
  tree_->index.findNeighbors(result, x.data(), nanoflann::SearchParams());
  return {index.begin(), index.end()};
}

}  // namespace palpate
