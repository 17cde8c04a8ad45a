#include "approximation/neighbours.h"

#include <algorithm>
#include <nanoflann.hpp>
#include <utility>

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
  using Index =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3, std::uint32_t>;
  explicit Tree(const std::vector<Vec3>& X) : cloud{X}, index(3, cloud) { index.buildIndex(); }
  Cloud cloud;
  Index index;
};

Neighbours::Neighbours(const std::vector<Vec3>& X, const std::vector<double>& radius, SupportLimit limit)
    : X_(X), limit_(std::move(limit)), tree_(std::make_unique<Tree>(X)) {
  for (double r : radius) max_radius_ = std::max(max_radius_, r);
  fillGrid(radius);
}

Neighbours::~Neighbours() = default;

void Neighbours::fillGrid(const std::vector<double>& radius) {
  if (X_.empty()) {
    first_.assign(2, 0);
    return;
  }
  const Box3 box = boxOf(X_);
  origin_ = box.min();
  // Cells of half the longest radius: smaller ones are more to visit, larger ones hold more that is too far. No more
  // of them than a few per node.
  const double extent = box.sizes().maxCoeff();
  cell_ = max_radius_ > 0 ? max_radius_ / 2 : std::max(extent, 1.0);
  const auto cellCount = [&] { return ((box.sizes() / cell_).array().floor() + 1).prod(); };
  while (cellCount() > 64.0 + 8.0 * static_cast<double>(X_.size())) cell_ *= 1.25;
  count_ = (box.sizes() / cell_).array().floor().cast<int>() + 1;

  first_.assign(static_cast<std::size_t>(count_.prod()) + 1, 0);
  const auto slotOf = [&](const Vec3& x) {
    const Eigen::Array3i c = cellOf(x);
    return slot(c.x(), c.y(), c.z());
  };
  for (const Vec3& x : X_) ++first_[slotOf(x)];
  int end = 0;  // each cell's; it fills from there down
  for (int& first : first_) first = end += first;
  ball_.resize(X_.size());
  node_.resize(X_.size());
  for (int j = static_cast<int>(X_.size()) - 1; j >= 0; --j) {
    const int place = --first_[slotOf(X_[j])];
    ball_[place] = {X_[j], radius[j] * radius[j]};
    node_[place] = j;
  }
}

Eigen::Array3i Neighbours::cellOf(const Vec3& x) const {
  const Eigen::Array3d place = ((x - origin_) / cell_).array();
  return place.max(0.0).min((count_ - 1).cast<double>()).cast<int>();
}

void Neighbours::find(const Vec3& x, std::vector<int>& support) const {
  support.clear();
  const Eigen::Array3i low = cellOf(x - Vec3::Constant(max_radius_)), high = cellOf(x + Vec3::Constant(max_radius_));
  for (int k = low.z(); k <= high.z(); ++k)
    for (int j = low.y(); j <= high.y(); ++j)
      for (int e = first_[slot(low.x(), j, k)]; e < first_[slot(high.x(), j, k) + 1]; ++e)
        if ((ball_[e].X - x).squaredNorm() < ball_[e].radius2) support.push_back(node_[e]);
  std::sort(support.begin(), support.end());
  if (limit_) limit_(x, X_, support);
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
