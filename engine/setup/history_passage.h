#pragma once

#include <array>
#include <vector>

#include "mechanics/relaxation.h"
#include "model/model.h"

namespace palpate {

/// What the points of materials that relax remember (mechanics/relaxation.h) on the way from one place of a cloud that
/// follows the tool to another: a point of B takes over the Z of the point of A that stands where it does (to
/// same_place), or the mean of the nearest four of its material and body, weighted by the inverse square of their
/// distance. Z is a stress in the body at rest, symmetric and continuous within a material, so that means of it are
/// one, too.
struct HistoryPassage {
  static constexpr int sources = 4;
  std::vector<std::array<int, sources>> lane;     // (16 * batch_count of B) 16 * batch + lane in A's layout
  std::vector<std::array<float, sources>> share;  // (16 * batch_count of B) 0: not, nor any after it

  bool empty() const { return lane.empty(); }
};

/// Empty where no material relaxes.
HistoryPassage makeHistoryPassage(const Model& a, const Model& b);

/// Batches [begin, end) of B. Real-time: no allocation, no lock, no throw.
/// Test: simulation/place_test.cpp
void carryHistory(const HistoryPassage& passage, const RelaxationHistory& before, std::size_t begin, std::size_t end,
                  RelaxationHistory& after);

}  // namespace palpate
