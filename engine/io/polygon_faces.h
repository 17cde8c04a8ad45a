#pragma once

#include <span>
#include <vector>

#include "base/input_error.h"
#include "io/surface_file.h"

namespace palpate {

/// Gathers a file's polygons as triangles: convex ones as fans, concave ones cut at their ears once all vertices are
/// known, since a file may name vertices before it gives them.
class PolygonFaces {
 public:
  explicit PolygonFaces(SurfaceFile& file) : file_(file) {}

  /// A polygon of fewer than three corners is counted as unreadable.
  /// @param corners  vertex indices; they need not exist
  /// @param line     of the file; 0: not known (then for all faces)
  void add(std::span<const int> corners, int line);

  /// Cuts the concave polygons anew, of which all vertices exist, and counts them.
  void finish();

 private:
  struct Polygon {
    int first_triangle;
    std::vector<int> corners;
  };
  SurfaceFile& file_;
  std::vector<Polygon> polygons_;  // of more than three corners
};

/// Refuses a file without faces; a strict reader also faces with vertices that are not there, or too few corners.
void checkIndices(const SurfaceFile& result, SurfaceReading reading);

/// Reads a file of a format that counts its elements by Reader's readHeader(), readBody() and finish(). Where the body
/// ends early, a tolerant reading goes on with the faces there are, and counts one as unreadable.
template <class Reader>
SurfaceFile readCounted(const std::string& bytes, const std::string& file, SurfaceReading reading) {
  SurfaceFile result;
  Reader reader(bytes, file, result);
  reader.readHeader();
  try {
    reader.readBody();
  } catch (const InputError&) {
    if (reading == SurfaceReading::Strict || result.surface.triangles.empty()) throw;
    ++result.unreadable_faces;
  }
  reader.finish();
  checkIndices(result, reading);
  return result;
}

}  // namespace palpate
