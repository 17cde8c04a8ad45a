#pragma once

#include <cstdint>
#include <vector>

#include "approximation/known_rows.h"
#include "approximation/mmls.h"
#include "approximation/neighbours.h"
#include "approximation/shape_table.h"

namespace palpate {

/// A point that its support can't carry.
struct InadmissibleSupport {
  int row = -1;  // evaluation point
  int support_count = 0;
  MmlsQuality quality;
};

/// What counts as admissible. Partition of unity alone hides a coplanar support, so linear
/// reproduction is tested, and values and gradients that explode before the matrix is singular.
struct AdmissibilityLimits {
  double linear_error = 1e-8;
  /// Of sum_j |N_j|: 1 to 1.7 in whole organs, above 100 where nodes nearly lie in a plane. With 3 a quarter of some
  /// blocks with a lamella between slits are refused, with 5 and 10 as many as without.
  double magnitude = 10;
  double gradient_error = 1e-7;
  double gradient_norm = 50;  // of max |gradN| R; 4 R/h is healthy

  bool admit(const MmlsQuality& q) const {
    return q.linear_error <= linear_error && q.magnitude <= magnitude && q.gradient_error <= gradient_error &&
           q.gradient_norm <= gradient_norm;
  }
};

/// Which nodes may carry which points: those that have a bit in common with the point. Empty: all. The approximation
/// goes through nodes with several bits, so that the fields of their groups meet there.
struct SupportGroups {
  std::vector<std::uint64_t> node;  // (node_count)
  std::vector<std::uint64_t> row;   // (row_count)
};

/// The known rows of a part, if any; where no gradients are wanted.
struct KnownPart {
  const RowsAtHand* rows = nullptr;
  std::size_t part = 0;
};

enum class Wanted { Values, Gradients };

/// Evaluates MMLS shape functions at many points, on all cores; with gradients where they are wanted (of the table,
/// else gradN is empty).
/// @param points   m (row_count)
/// @param failed   receives the inadmissible rows in ascending order; their entries are left empty
/// @param groups   supports that are to end somewhere
/// @param known    rows of the same options, which are copied where they hold
ShapeTable shapeFunctions(const std::vector<Vec3>& points, const std::vector<Vec3>& X,
                          const std::vector<double>& radius, const Neighbours& neighbours, const MmlsOptions& options,
                          std::vector<InadmissibleSupport>& failed, const SupportGroups& groups = {},
                          const KnownPart& known = {}, Wanted wanted = Wanted::Gradients);

/// Multiplies by 1.15 the radii of the eight nodes nearest to each failed point that may carry it: sparse supports
/// grow until they are admissible. Returns the nodes that changed.
std::vector<int> enlargeSupports(const std::vector<Vec3>& points, const std::vector<InadmissibleSupport>& failed,
                                 const Neighbours& neighbours, std::vector<double>& radius,
                                 const SupportGroups& groups = {});

}  // namespace palpate
