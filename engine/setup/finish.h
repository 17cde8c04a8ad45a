#pragma once

#include <memory>

#include "contact/skin_contact.h"
#include "discretization/surface/surface_gaps.h"
#include "discretization/surface/surface_tree.h"
#include "setup/build_model.h"

namespace palpate {

/// What all places of a scene whose cloud follows the tool (place.h) have in common, beside what each body has
/// (CommonToBody).
struct CommonToPlaces {
  SkinModel skin;                                        // without rows
  SkinBodies bodies;                                     // of it, likewise
  std::vector<std::shared_ptr<const SurfaceGaps>> gaps;  // (body_count) in the skin of each
  double finest_spacing = 0;                             // m, of the nodes at any place
  ToolSet tools;                                         // before the skin; which forces they may have, a place says
};

/// The second half of buildModel: what is quick, and what depends on rate, step and tool. Throws InputError naming the
/// place in the scene that can't be used.
/// @param tree    of the organ's closed surface
/// @param common  of a place; null: the scene's body is on its own
Model finish(const Scene& scene, const SurfaceTree& tree, Preparation preparation, const Progress& report,
             const CommonToPlaces* common = nullptr);

/// The skin as the contact reads it, but for its rows.
SkinModel skinOf(const TriangleSurface& surface);

}  // namespace palpate
