#pragma once

#include <string>
#include <vector>

#include "discretization/surface/surface_check.h"
#include "discretization/surface/surface_parts.h"
#include "discretization/surface/weld_vertices.h"
#include "imaging/repair_report.h"

namespace palpate {

/// Leaves out vertices far off all others, with their faces: a hundredth of all at most, three times as far from the
/// middle as any other, and with rims whose holes are small. A slip of an editor or a scanner, which would hide the
/// body's size and bound nothing. Keeps `source` in step.
void dropStray(TriangleSurface& surface, SurfaceSource& source, RepairReport& report);

/// Which parts are one body: those whose faces pierce one another, or that touch face on face.
struct Bodies {
  int count = 0;
  std::vector<int> of_part;  // (parts.count) 0 .. count-1
  bool touching = false;     // some touch
};
/// @param asked  (parts.count) not 0: the part is looked at; the others are joined only through those
Bodies joinedParts(const TriangleSurface& surface, const SurfaceParts& parts, const std::vector<char>& asked);

/// Removes faces that are there more than once and those without area, and splits faces at vertices that hang in their
/// open edges (T-junctions), so that what was meant to be joined is. No vertex moves, but open rims that lie closer
/// together than a thousandth of the surface's size and a fifth of their edges are joined. Keeps `source` in step.
void tidyFaces(TriangleSurface& surface, SurfaceSource& source, RepairReport& report);

/// Turns the faces of each patch (joined across edges that exactly two faces have) alike, and each patch so that its
/// front is seen from outside: what encloses a volume, or nearly, by that volume; sheets by rays, of which more escape
/// from one side (Takayama et al. 2014). Removes what bounds nothing: sheets inside the body, closed surfaces inside it
/// that face outward, and sheets that are seen from both sides, unless they are all there is. Closed surfaces inside
/// that face inward, by the file's own sense, are cavities and stay.
void orientPatches(TriangleSurface& surface, SurfaceSource& source, RepairReport& report);

/// Closes holes by the smallest surface that their rims span, as long as all of that is at most
/// `max_filled_share` of the surface then. @return the faces that are new stand behind this many that were there
int fillHoles(TriangleSurface& surface, SurfaceSource& source, RepairReport& report);

/// Drops bodies of less than `least_part_share` of the largest one's volume, each with all parts that are joined to it,
/// and cavities below `least_cavity_share`. Small parts that are joined to a body stay but where they are thinner than
/// `thinnest`, m: whoever unites them on a grid would lose them.
void dropSmallParts(TriangleSurface& surface, SurfaceSource& source, RepairReport& report, double thinnest);

/// Of the surface's area: what may be closed without its having been there. A bust with an open base has less, a box
/// without a lid more.
inline constexpr double max_filled_share = 0.15;
/// Of the largest part's volume.
inline constexpr double least_part_share = 0.01, least_cavity_share = 1e-3;

}  // namespace palpate
