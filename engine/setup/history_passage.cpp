#include "setup/history_passage.h"

#include "approximation/neighbours.h"
#include "setup/passage.h"

namespace palpate {
namespace {

constexpr std::size_t lanes = 16, components = 6;

/// The points of a material in a layout.
struct Points {
  std::vector<Vec3> X;    // m
  std::vector<int> lane;  // in the layout
};

Points pointsOf(const Model& model, int material) {
  Points points;
  for (std::size_t k = 0; k < model.kernel.point.size(); ++k) {
    const int q = model.kernel.point[k];
    if (q < 0 || model.point_material[static_cast<std::size_t>(q)] != material) continue;
    points.X.push_back(model.point_X[static_cast<std::size_t>(q)]);
    points.lane.push_back(static_cast<int>(k));
  }
  return points;
}

}  // namespace

HistoryPassage makeHistoryPassage(const Model& a, const Model& b) {
  HistoryPassage passage;
  for (std::size_t m = 0; m < b.materials.size(); ++m) {
    if (b.materials[m].relaxation_count == 0) continue;
    passage.lane.resize(b.kernel.point.size());
    passage.share.resize(b.kernel.point.size());
    const Points of_a = pointsOf(a, static_cast<int>(m)), of_b = pointsOf(b, static_cast<int>(m));
    if (of_a.X.empty()) continue;
    const Neighbours neighbours(of_a.X, std::vector<double>(of_a.X.size(), a.scene.discretization.spacing));
    for (std::size_t p = 0; p < of_b.X.size(); ++p) {
      auto& lane = passage.lane[static_cast<std::size_t>(of_b.lane[p])];
      auto& share = passage.share[static_cast<std::size_t>(of_b.lane[p])];
      const std::vector<int> nearest = neighbours.nearest(of_b.X[p], HistoryPassage::sources);
      double sum = 0;
      std::array<double, HistoryPassage::sources> weight{};
      for (std::size_t n = 0; n < nearest.size(); ++n) {
        const auto k = static_cast<std::size_t>(nearest[n]);
        const double distance = (of_a.X[k] - of_b.X[p]).norm();
        lane[n] = of_a.lane[k];
        sum += weight[n] = distance > same_place ? 1 / (distance * distance) : 1;
        if (distance <= same_place) break;  // the nearest is the first
      }
      for (std::size_t n = 0; n < weight.size(); ++n) share[n] = static_cast<float>(weight[n] / sum);
    }
  }
  return passage;
}

void carryHistory(const HistoryPassage& passage, const RelaxationHistory& before, std::size_t begin, std::size_t end,
                  RelaxationHistory& after) {
  const auto rows = static_cast<std::size_t>(after.term_count) * components;
  for (std::size_t k = begin * lanes; k < end * lanes; ++k) {
    float* const to = after.Z.data() + k / lanes * rows * lanes + k % lanes;
    for (std::size_t row = 0; row < rows; ++row) to[row * lanes] = 0;
    for (std::size_t n = 0; n < HistoryPassage::sources && passage.share[k][n] > 0; ++n) {
      const auto source = static_cast<std::size_t>(passage.lane[k][n]);
      const float* const from = before.Z.data() + source / lanes * rows * lanes + source % lanes;
      for (std::size_t row = 0; row < rows; ++row) to[row * lanes] += passage.share[k][n] * from[row * lanes];
    }
  }
}

}  // namespace palpate
