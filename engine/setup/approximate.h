#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "approximation/known_rows.h"
#include "approximation/neighbours.h"
#include "approximation/shape_functions.h"
#include "discretization/cells/background_cells.h"
#include "discretization/cells/integration_points.h"
#include "discretization/surface/surface_gaps.h"
#include "scene/scene.h"

namespace palpate {

/// The cells' integration points, shared by pairs of cells or adaptive where the scene asks for it. Supports on which
/// the adaptive quadrature can't judge are enlarged in `radius`.
/// @param cell_material  (cell_count) index into the scene's materials: no pair has two
/// @param pair_moment    cells are joined up to it (pairCellsUpTo); null: until there are so many to a point as the
///                       scene asks for
IntegrationPoints choosePoints(const Scene& scene, const std::vector<Vec3>& X, const BackgroundCells& cells,
                               const std::vector<int>& cell_material, std::vector<double>& radius,
                               const double* pair_moment = nullptr);

/// Shape functions at integration points, skin vertices, nodes and samples of the boundary, over supports that
/// are enlarged where they must be.
struct Approximation {
  std::vector<double> radius;
  ShapeTable points, skin, nodes, facets, boundary;
};

/// Where supports end at borders between materials: to which groups of cells (bits) nodes and evaluation points belong.
struct ApproximationGroups {
  std::vector<std::uint64_t> of_nodes, points, skin, nodes, facets, boundary;
};

/// A place that no support carries, however large.
struct Unsupported {
  Vec3 at;
  std::uint64_t group;
};

/// Rows that are known from another cloud, and how this one's nodes are numbered among those of both.
struct RowMemory {
  const std::vector<int>& number;  // (node_count) ascending
  KnownRows& rows;                 // used, and replaced by those that are found
};

/// The gaps of a scene's body that supports could reach across. @param skin  as the tool touches it, m
SurfaceGaps gapsOf(const Scene& scene, const TriangleSurface& skin, const SurfaceTree& body);

/// Nodes that no row has (node_count), or nothing where all are in some.
std::vector<std::uint8_t> lonelyNodes(const ShapeTable& rows, std::size_t node_count);

/// Which nodes a place follows, of those that are near. Supports end at gaps. What sees too few nodes, such as a point
/// of a facet between coarse nodes that lies in the air, follows those that its nearest node sees, or has a cell with.
struct Sight {
  /// @param cells  nodes that each joins
  Sight(const SurfaceGaps& gaps, std::size_t node_count, const std::vector<std::array<int, 4>>& cells);

  /// It, and the nodes, must outlive the limit; what is set below takes part at once.
  SupportLimit limit() const;

  const SurfaceGaps& gaps;
  std::vector<std::vector<int>> joined;  // of each node those that it shares a cell with, ascending; no gaps: empty
  std::vector<std::uint8_t> lonely;      // lonelyNodes of the integration points: nothing else follows them, either
};

/// Gives rows that no support carries the field of the nearest integration point in sight, failing that of the nearest,
/// to first order: u(x_q) + grad u(x_q) (x - x_q), exact for linear fields.
/// @param failed          ascending; their rows in `table` are empty
/// @param points          rows of the integration points, with gradients; may be `table`
/// @param mayFollow(r, q)  whether row r may follow point q
/// @return those for which there is no point
std::vector<InadmissibleSupport> followPoints(const std::vector<Vec3>& at,
                                              const std::vector<InadmissibleSupport>& failed,
                                              const std::vector<Vec3>& point_X, const ShapeTable& points,
                                              const std::function<bool(int, int)>& mayFollow, const SurfaceGaps& gaps,
                                              ShapeTable& table);

/// @param gaps, cells  of Sight
/// @param groups       empty: supports reach over all borders
/// @param unsupported  receives such places; null: they are an InputError
/// @param memory       or null
Approximation approximate(const Scene& scene, const std::vector<Vec3>& X, std::vector<double> radius,
                          const std::vector<Vec3>& point_X, const std::vector<Vec3>& skin_X,
                          const std::vector<Vec3>& facet_X, const std::vector<Vec3>& boundary_X,
                          const SurfaceGaps& gaps, const std::vector<std::array<int, 4>>& cells,
                          const ApproximationGroups& groups = {}, std::vector<Unsupported>* unsupported = nullptr,
                          const RowMemory* memory = nullptr);

}  // namespace palpate
