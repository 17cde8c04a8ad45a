#include "io/obj_parser.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>
#include <vector>

#include "io/token_reader.h"

namespace palpate {

namespace {

// Statements that say nothing about the shape.
constexpr std::array<std::string_view, 17> skipped = {"vt",     "vn",  "vp",    "o",        "g",       "s",
                                                      "mg",     "l",   "p",     "usemtl",   "mtllib",  "usemap",
                                                      "maplib", "lod", "bevel", "c_interp", "d_interp"};

/// The vertex that a corner names: "7", "7/1", "7//3", "7/1/3" or "-1/...", as an index from 0.
/// An index beyond the vertices read so far is allowed here; the whole file decides.
int parseCorner(std::string_view word, int vertex_count, const SourceLocation& place) {
  const std::string_view number = word.substr(0, word.find('/'));
  long long index = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
  if (error == std::errc::result_out_of_range || index > std::numeric_limits<int>::max() ||
      index < -std::numeric_limits<int>::max()) {
    throw InputError(place, "vertex index " + inQuotes(word) + " is out of range", "export the surface again");
  }
  if (error != std::errc{} || end != number.data() + number.size()) {
    throw InputError(place, inQuotes(word) + " is not a vertex index",
                     "write a face like \"f 1 2 3\" or \"f 1/1/1 2/2/2 3/3/3\"");
  }
  if (index == 0) {
    throw InputError(place, "vertex index 0", "OBJ counts vertices from 1");
  }
  if (index < 0) {
    if (-index > vertex_count) {
      throw InputError(place,
                       "vertex index " + std::to_string(index) + " reaches back beyond the " +
                           std::to_string(vertex_count) + " vertices read so far",
                       "relative indices count back from the face");
    }
    return vertex_count + static_cast<int>(index);
  }
  return static_cast<int>(index) - 1;
}

}  // namespace

SurfaceFile parseObj(const std::string& text, const std::string& file) {
  SurfaceFile result;
  result.source.file = file;
  auto& [vertices, triangles] = result.surface;
  TokenReader reader(text, file);

  struct Polygon {
    int first_triangle;
    std::vector<int> corners;
    SourceLocation place;
  };
  std::vector<Polygon> polygons;  // with more than three corners
  int highest = -1;
  SourceLocation highest_place;
  std::vector<int> corners;
  do {
    const std::string_view keyword = reader.nextInLine();
    if (keyword.empty() || keyword.front() == '#') continue;
    const SourceLocation place = reader.place();
    if (keyword == "v") {
      Vec3 x;
      for (int k = 0; k < 3; ++k) {
        const std::string_view word = reader.nextInLine();
        x[k] = parseNumber(word, reader.place(), "coordinate " + std::to_string(k + 1) + " of this vertex");
      }
      vertices.push_back(x);
      result.source.vertex_line.push_back(place.line);
    } else if (keyword == "f") {
      corners.clear();
      for (std::string_view word = reader.nextInLine(); !word.empty() && word.front() != '#';
           word = reader.nextInLine()) {
        corners.push_back(parseCorner(word, static_cast<int>(vertices.size()), reader.place()));
        if (corners.back() > highest) {
          highest = corners.back();
          highest_place = reader.place();
        }
      }
      if (corners.size() < 3) {
        throw InputError(place, "a face with " + std::to_string(corners.size()) + " corners",
                         "a face needs at least 3; the line may have been cut short");
      }
      if (corners.size() > 3) polygons.push_back({static_cast<int>(triangles.size()), corners, place});
      for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
        triangles.push_back({corners[0], corners[k], corners[k + 1]});
        result.source.triangle_line.push_back(place.line);
      }
    } else if (std::find(skipped.begin(), skipped.end(), keyword) == skipped.end()) {
      throw InputError(place, inQuotes(keyword) + " is not a statement of a polygonal OBJ file",
                       "export the organ as an OBJ of \"v\" and \"f\" lines, or as STL");
    }
  } while (reader.nextLine());

  if (highest >= static_cast<int>(vertices.size())) {
    throw InputError(highest_place,
                     "vertex index " + std::to_string(highest + 1) + " but the file has " +
                         std::to_string(vertices.size()) + " vertices",
                     "the file may have been cut short: export it again");
  }
  if (triangles.empty()) throw InputError({file, 0, 0}, "no faces in this file", "an OBJ surface has \"f\" lines");

  // A fan fills a polygon only if none of its triangles points against the whole.
  for (const Polygon& polygon : polygons) {
    Vec3 whole = Vec3::Zero();
    const Vec3& o = vertices[polygon.corners[0]];
    for (std::size_t k = 1; k + 1 < polygon.corners.size(); ++k) {
      whole += (vertices[polygon.corners[k]] - o).cross(vertices[polygon.corners[k + 1]] - o);
    }
    for (std::size_t k = 1; k + 1 < polygon.corners.size(); ++k) {
      if ((vertices[polygon.corners[k]] - o).cross(vertices[polygon.corners[k + 1]] - o).dot(whole) < 0) {
        throw InputError(polygon.place, "a concave polygon", "let the exporting program triangulate the faces");
      }
    }
  }
  return result;
}

}  // namespace palpate
