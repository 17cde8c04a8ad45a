#pragma once

#include <span>
#include <vector>

#include "contact/contact.h"
#include "model/model.h"
#include "model/tools_at.h"

namespace palpate {

/// The tools that touch a body which moves in double (BatchBody): where they are, and their contacts. The contact
/// itself works in float on the way of the skin, as that of the real-time step.
/// Test: simulation/batch_tools_test.cpp
class BatchTools {
 public:
  explicit BatchTools(const Model& model);

  /// Where they go in the next step, from where they were.
  void move(const ToolsAt& tools) { now_ = tools; }
  /// They stand there already: no way leads to it.
  void place(const ToolsAt& tools) { now_ = before_ = tools; }
  bool present() const { return now_.count > 0; }
  const ToolsAt& at() const { return now_; }

  /// solveContacts for the tools and all else that touches; says what the tissue does to each tool (no torques).
  ContactForces solve(const ContactStep& step, Touching touching, ToolLoads& loads);

  std::span<const ContactState> contacts() const { return contact_; }
  /// After solve(), as StepReport has them: how deep the skin is in the tools, m, and whether a list overflowed.
  double maxPenetration() const;
  bool overflow() const;

 private:
  int bodyCount() const;

  const Model& model_;
  ToolsAt now_, before_;
  std::vector<ContactState> contact_;    // (body_count)
  std::vector<ContactScratch> scratch_;  // (body_count)
};

}  // namespace palpate
