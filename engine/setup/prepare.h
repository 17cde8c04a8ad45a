#pragma once

#include "discretization/surface/surface_tree.h"
#include "model/preparation.h"
#include "setup/approximate.h"
#include "setup/build_model.h"
#include "setup/discretize.h"

namespace palpate {

/// What a body has in common at all places of a scene whose cloud follows the tool (place.h), so that what is far from
/// the tool does not change with it.
struct CommonToBody {
  TriangleSurface skin;  // as tools touch it
  std::shared_ptr<const SurfaceGaps> gaps;
  double pair_moment = 0;  // cells are joined up to it (pairCellsUpTo), where the scene has cells_per_point > 1
  double row_limit = 0;    // 1/s^2: m_i = max(lumped m_i, Gershgorin row_i / row_limit)
  double critical = 0;     // s, the critical step that all have; a place that falls short gets more mass where it must
};

/// The first half of buildModel, from nodes and cells on. Throws InputError naming the place in the scene that can't be
/// used.
/// @param tree    of the organ's closed surface
/// @param common  of a place; null: the scene's body is on its own
/// @param memory  or null
Preparation prepare(const Scene& scene, const SurfaceTree& tree, Discretization discretization,
                    const Progress& progress, const CommonToBody* common = nullptr, const RowMemory* memory = nullptr);

/// Materials by number at the cells' middles, as `prepare` has them (cell_count).
std::vector<int> cellMaterials(const Scene& scene, const SurfaceTree& tree, const std::vector<Vec3>& X,
                               const BackgroundCells& cells);

}  // namespace palpate
