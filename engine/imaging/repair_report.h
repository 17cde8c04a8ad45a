#pragma once

#include <string>
#include <vector>

namespace palpate {

/// What was found wrong with a surface and what was done about it, counted.
struct RepairReport {
  int given_faces = 0;
  // Of the file's faces
  int unreadable_faces = 0;  // named vertices that are not there or not finite, or were cut off
  int concave_polygons = 0;  // cut into triangles
  int unused_vertices = 0;   // that no face has, left out
  int stray_vertices = 0;    // far off all others, left out
  int stray_faces = 0;       // with them
  double stray_sizes = 0;    // how far off the furthest was, in sizes of the body
  // Of faces and edges
  int doubled_faces = 0;    // removed
  int flat_faces = 0;       // without area, removed
  int split_faces = 0;      // at vertices that hung in their edges
  int joined_vertices = 0;  // of rims close together
  int turned_faces = 0;     // against their neighbours or inside out
  bool inside_out = false;  // all of them
  int holes = 0;            // closed
  int hole_edges = 0;
  int crowded_edges = 0;   // with three faces or more
  int piercing_faces = 0;  // cut out and closed again, where they were few
  // Of parts
  int parts = 0;                  // closed surfaces that are kept
  int cavities = 0;               // of these
  int came_apart = 0;             // parts that the given ones' joints were too thin to hold together
  int inner_sheets = 0;           // removed
  int loose_sheets = 0;           // removed: bound nothing
  int small_parts = 0;            // removed
  double small_volume_share = 0;  // of them, of the whole
  int thin_parts = 0;             // joined to others, but too thin for the grid that would unite them: removed
  double thin_volume_share = 0;   // of them, of the whole
  int filled_bubbles = 0;         // cavities too small to matter
  // Where mending face by face was not enough
  std::string resampled_because;  // empty: it was
  double cell = 0;                // m, of the grid on which the surface was made anew
  double opened = 0;              // m: what was thinner, spikes and walls, is gone
  int made_faces = 0;
  bool even_triangles = false;  // remeshed; otherwise as the grid gives them
  double invented_share = 0;    // of the new surface's area: further than two cells from any given face
  double see_through = 0;       // rays that the insides of the given patches let out, to those of their outsides
  double lost_share = 0;        // of the given area: further than two cells from the new surface

  bool changedNothing() const;
  bool resampled() const { return !resampled_because.empty(); }

  /// In plain words, a line for each thing.
  std::vector<std::string> lines() const;
};

}  // namespace palpate
