#include "imaging/repair_report.h"

#include "base/number_text.h"

namespace palpate {
namespace {

std::string counted(int count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

bool RepairReport::changedNothing() const {
  return !resampled() && unreadable_faces + concave_polygons + doubled_faces + flat_faces + split_faces +
                                 joined_vertices + turned_faces + holes + piercing_faces + inner_sheets + loose_sheets +
                                 small_parts + thin_parts + filled_bubbles + stray_vertices ==
                             0;
}

std::vector<std::string> RepairReport::lines() const {
  std::vector<std::string> lines;
  const auto say = [&](int count, const char* one, const char* many, const std::string& what) {
    if (count > 0) lines.push_back(counted(count, one, many) + what);
  };
  say(unreadable_faces, "face", "faces", " that can't be read (cut off, or without proper vertices): left out");
  say(unused_vertices, "vertex", "vertices", " that no face has: left out");
  if (stray_vertices > 0)
    lines.push_back(counted(stray_vertices, "stray vertex", "stray vertices") +
                    format(", up to %.3g sizes of the body away, with ", stray_sizes) +
                    counted(stray_faces, "face", "faces") + ": left out");
  say(concave_polygons, "concave polygon", "concave polygons", ": cut into triangles");
  say(doubled_faces, "face", "faces", " there more than once: removed");
  say(flat_faces, "face", "faces", " without area: removed");
  say(joined_vertices, "vertex", "vertices", " of rims that nearly touch: joined");
  say(split_faces, "face", "faces", " with another's vertex in an edge: split there");
  if (inside_out)
    lines.push_back("all " + counted(turned_faces, "face", "faces") + " inside out: turned");
  else
    say(turned_faces, "face", "faces", " facing inward or against the neighbours: turned");
  say(inner_sheets, "sheet", "sheets", " inside the body: removed");
  say(loose_sheets, "loose sheet", "loose sheets", " that bound nothing: removed");
  say(piercing_faces, "face", "faces", " piercing others: cut out with those around, and closed again");
  if (holes > 0)
    lines.push_back(counted(holes, "hole", "holes") + " (" + counted(hole_edges, "open edge", "open edges") +
                    "): closed");
  say(crowded_edges, "edge", "edges", " shared by more than two faces");
  if (small_parts > 0)
    lines.push_back(counted(small_parts, "small part", "small parts") +
                    format(" (%.2g %% of the volume): left out", 100 * small_volume_share));
  if (thin_parts > 0)
    lines.push_back(counted(thin_parts, "part", "parts") + " joined to the body, but too thin to be united with it" +
                    format(" (%.2g %% of the volume): left out", 100 * thin_volume_share));
  say(filled_bubbles, "hollow", "hollows", " too small to matter: filled");
  if (resampled()) {
    lines.push_back("made anew, because " + resampled_because +
                    format(": on a grid of %.3g mm, by winding numbers, with ", 1e3 * cell) +
                    counted(made_faces, "face", "faces") + (even_triangles ? "" : ", which are not even"));
    if (opened > 0) lines.push_back(format("spikes and walls thinner than %.3g mm: removed", 1e3 * opened));
    if (invented_share > 0.0005)
      lines.push_back(format("%.2g %% of the new surface closes gaps in the given one", 100 * invented_share));
    if (lost_share > 0.0005)
      lines.push_back(
          format("%.2g %% of the given surface is too thin for the grid, or was inside: not kept", 100 * lost_share));
  }
  say(came_apart, "part", "parts", " joined to the rest by less than the grid shows: came apart");
  if (cavities > 0) lines.push_back(counted(cavities, "cavity", "cavities") + " inside: kept");
  if (parts - cavities > 1) lines.push_back(counted(parts - cavities, "separate part", "separate parts") + ": kept");
  return lines;
}

}  // namespace palpate
