#include "io/obj_parser.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "io/polygon_faces.h"
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

/// Reads statement by statement.
class ObjReader {
 public:
  ObjReader(const std::string& text, const std::string& file, SurfaceFile& result)
      : reader_(text, file), result_(result), faces_(result) {
    result_.source.file = file;
  }

  /// The statement on this line, if there is one.
  void read() {
    const std::string_view keyword = reader_.nextInLine();
    if (keyword.empty() || keyword.front() == '#') return;
    const SourceLocation place = reader_.place();
    if (keyword == "v") {
      readVertex(place);
    } else if (keyword == "f") {
      readFace(place);
    } else if (std::find(skipped.begin(), skipped.end(), keyword) == skipped.end()) {
      throw InputError(place, inQuotes(keyword) + " is not a statement of a polygonal OBJ file",
                       "export the organ as an OBJ of \"v\" and \"f\" lines, or as STL");
    }
  }
  bool nextLine() { return reader_.nextLine(); }

  /// Throws where a vertex is named that the file does not have.
  void checkHighest() const {
    const int count = static_cast<int>(result_.surface.vertices.size());
    if (highest_ < count) return;
    throw InputError(
        highest_place_,
        "vertex index " + std::to_string(highest_ + 1) + " but the file has " + std::to_string(count) + " vertices",
        "the file may have been cut short: export it again");
  }
  void finish() { faces_.finish(); }

 private:
  void readVertex(const SourceLocation& place) {
    // Counted even where it can't be read, so that the others keep their numbers.
    result_.surface.vertices.push_back(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
    result_.source.vertex_line.push_back(place.line);
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = reader_.nextInLine();
      x[k] = parseNumber(word, reader_.place(), "coordinate " + std::to_string(k + 1) + " of this vertex");
    }
    result_.surface.vertices.back() = x;
  }

  void readFace(const SourceLocation& place) {
    corners_.clear();
    for (std::string_view word = reader_.nextInLine(); !word.empty() && word.front() != '#';
         word = reader_.nextInLine()) {
      corners_.push_back(parseCorner(word, static_cast<int>(result_.surface.vertices.size()), reader_.place()));
      if (corners_.back() > highest_) {
        highest_ = corners_.back();
        highest_place_ = reader_.place();
      }
    }
    if (corners_.size() < 3) {
      throw InputError(place, "a face with " + std::to_string(corners_.size()) + " corners",
                       "a face needs at least 3; the line may have been cut short");
    }
    faces_.add(corners_, place.line);
  }

  TokenReader reader_;
  SurfaceFile& result_;
  PolygonFaces faces_;
  std::vector<int> corners_;
  int highest_ = -1;
  SourceLocation highest_place_;
};

}  // namespace

SurfaceFile parseObj(const std::string& text, const std::string& file, SurfaceReading reading) {
  SurfaceFile result;
  ObjReader reader(text, file, result);
  std::optional<InputError> first;  // of the lines that can't be read
  do {
    try {
      reader.read();
    } catch (const InputError& error) {
      if (!first) first = error, result.unreadable = error.what();
      constexpr int max_unreadable = 10'000;  // beyond, it is no OBJ file
      if (reading == SurfaceReading::Strict || ++result.unreadable_faces > max_unreadable) throw;
    }
  } while (reader.nextLine());
  if (reading == SurfaceReading::Strict) reader.checkHighest();
  if (result.surface.triangles.empty() && first) throw *first;
  if (result.surface.triangles.empty())
    throw InputError({file, 0, 0}, "no faces in this file", "an OBJ surface has \"f\" lines");
  reader.finish();
  return result;
}

}  // namespace palpate
