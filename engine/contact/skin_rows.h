#pragma once

#include <span>

#include "contact/skin_contact.h"

namespace palpate {

/// The rows of places of the skin that touch each other: a vertex v before a face with corners k and shares b_k,
///   N(i) = N_i(X_v) - sum_k b_k N_i(X_k)
/// so that action and reaction are equal to rounding. K = k_v a_v (skin.layer), or what stops the two within a step
/// where that is stiffer. What is deeper than the layer comes back by no more than 0.02 mm a step, so that it is not
/// shot out.
/// Test: simulation/skin_contact_test.cpp
class SkinRows final : public ContactGroup {
 public:
  /// @param state, scratch  with the tick's pairs (findSkinPairs); null: none
  SkinRows(const ContactStep& step, SkinContactState* state, SkinContactScratch* scratch);

  std::size_t makeRows() override;
  bool sweep(bool forwards) override;
  /// Keeps the forces for the next step.
  SkinContact finish();

 private:
  using Row = SkinContactScratch::Row;
  std::span<Row> rows() const;
  std::size_t active(std::size_t k) const { return static_cast<std::size_t>(scratch_->active[k]); }
  void push(const Row& row, const Eigen::Vector4f& f) const;

  const ContactStep& step_;
  SkinContactState* state_;
  SkinContactScratch* scratch_;
  std::size_t active_ = 0;  // rows that touch in this step, or nearly
  Sweeps sweeps_;
};

}  // namespace palpate
