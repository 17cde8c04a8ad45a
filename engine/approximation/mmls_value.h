#pragma once

#include <vector>

#include "approximation/mmls.h"
#include "base/types.h"

namespace palpate {

/// The value of a field by modified moving least squares (Mmls) where its gradient is not asked for, at a quarter of
/// the cost: u(x) = sum_j N_j(x) u_j.
///
/// Reusable scratch: one object per thread; no allocation once the largest support was seen.
/// Test: approximation/mmls_value_test.cpp (equal to Mmls to rounding).
class MmlsValue {
 public:
  explicit MmlsValue(const MmlsOptions& options);
  ~MmlsValue();
  void use(const MmlsOptions& options) { options_ = options; }

  /// A node of the support of x.
  struct Node {
    Vec3 X;         // m
    double radius;  // m, > |x - X|
    Vec3 u;
  };

  /// @param support  of x (node_count)
  /// @return false where the support can't carry the approximation: the moment matrix is singular, or 1 and x are not
  ///         reproduced to 1e-8
  bool at(const Vec3& x, const std::vector<Node>& support, Vec3& u);

 private:
  template <int Size>
  bool solve(const Vec3& x, const std::vector<Node>& support, Vec3& u);

  MmlsOptions options_;
  struct Packed;
  std::vector<Packed> pack_;  // of the support
};

}  // namespace palpate
