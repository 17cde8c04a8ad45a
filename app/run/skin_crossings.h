#pragma once

#include <array>
#include <vector>

#include "contact/skin.h"

namespace palpate::app {

/// Counts where the skin passes through itself, which what folds finer than contact sees can. Not real-time: some
/// ms for 20,000 triangles.
class SkinCrossings {
 public:
  /// @param skin  must outlive this
  explicit SkinCrossings(const SkinModel& skin);

  /// The same skin by other nodes, which must outlive this, too.
  void goOnWith(const SkinModel& skin) { skin_ = &skin; }

  /// @param u  (node_count) m
  /// @return pairs of triangles without a common vertex of which an edge of one goes through the other, by more than
  /// 1e-7 m: faces of one plane do not cross; of two organs by more than 0.1 mm, which their contact may leave
  int count(const Float4* u);

 private:
  struct Span {
    double low = 0, high = 0;  // m, along x
    int triangle = 0;
  };
  bool cross(int a, int b) const;

  const SkinModel* skin_;
  std::vector<int> part_;                 // (triangle_count) of the skin
  std::vector<Vec3> x_;                   // (vertex_count) m
  std::vector<Eigen::AlignedBox3d> box_;  // (triangle_count) m
  std::vector<Span> spans_;               // (triangle_count) by low
};

}  // namespace palpate::app
