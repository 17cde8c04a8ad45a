#include "setup/history_passage.h"

#include <algorithm>

#include "approximation/neighbours.h"
#include "setup/passage.h"

namespace palpate {
namespace {

constexpr std::size_t lanes = 16, components = 6;

/// The points of a material and a part in a layout.
struct Points {
  std::vector<Vec3> X;    // m
  std::vector<int> lane;  // in the layout
};

Points pointsOf(const Model& model, int material, int body) {
  Points points;
  for (std::size_t k = 0; k < model.kernel.point.size(); ++k) {
    const int q = model.kernel.point[k];
    if (q < 0 || model.point_material[static_cast<std::size_t>(q)] != material || model.bodyOfPoint(q) != body)
      continue;
    points.X.push_back(model.point_X[static_cast<std::size_t>(q)]);
    points.lane.push_back(static_cast<int>(k));
  }
  return points;
}

void carryPoints(const Points& of_a, const Points& of_b, double spacing, HistoryPassage& passage) {
  const Neighbours neighbours(of_a.X, std::vector<double>(of_a.X.size(), spacing));
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

}  // namespace

HistoryPassage makeHistoryPassage(const Model& a, const Model& b) {
  HistoryPassage passage;
  const auto relaxes = [](const Material& m) { return m.relaxation_count > 0; };
  if (std::none_of(b.materials.begin(), b.materials.end(), relaxes)) return passage;
  passage.lane.resize(b.kernel.point.size());
  passage.share.resize(b.kernel.point.size());
  for (int m = 0; m < static_cast<int>(b.materials.size()); ++m)
    for (int body = 0; body < b.bodyCount() && relaxes(b.materials[static_cast<std::size_t>(m)]); ++body) {
      const Points of_a = pointsOf(a, m, body);
      if (!of_a.X.empty()) carryPoints(of_a, pointsOf(b, m, body), a.scene.discretization.spacing, passage);
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
