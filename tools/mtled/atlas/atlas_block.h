#pragma once

#include "mtled/atlas/atlas_run.h"
#include "scene/scene.h"

namespace palpate::tools {

/// The bodies that most cells of the atlas deform: x in +-a/2, y in +-b/2, z in 0..c.

/// How a block's faces are held; its top always moves along z.
enum class BlockFaces {
  Free,      // ends without friction, sides free: the deformation is uniform
  Confined,  // all faces without friction
  Bonded,    // both ends held
};

/// A block whose top is moved by `stretch` - 1 times its height within half a second; boundary 0 is the base, 1 the
/// top.
Scene blockScene(BlockFaces faces, double young, double poisson, double stretch);

/// The drive that waits for it to come to rest.
AtlasDrive blockDrive();

/// Force on the top along z, N, of a block of that cross-section, stretched uniformly:
///   P_i = mu J^(-2/3) (l_i - I1 / (3 l_i)) + K (J - 1) J / l_i,   P = 0 at free sides
/// Closed form but for the lateral stretch, which is found by bisection.
double blockForce(BlockFaces faces, double young, double poisson, double stretch, double area);

}  // namespace palpate::tools
