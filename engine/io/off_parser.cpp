#include "io/off_parser.h"

#include <cmath>
#include <string_view>
#include <vector>

#include "base/input_error.h"
#include "io/byte_reader.h"
#include "io/polygon_faces.h"
#include "io/token_reader.h"

namespace palpate {
namespace {

/// The words of an OFF file; what follows a # on a line is none of it.
class OffReader {
 public:
  OffReader(const std::string& text, const std::string& file, SurfaceFile& result)
      : text_(text, file), bytes_(text.size()), result_(result), faces_(result) {
    result_.source.file = file;
  }

  void readHeader() {
    std::string_view word = next();
    if (word.ends_with("OFF")) {
      if (word.find('4') != std::string_view::npos || word.find('n') != std::string_view::npos)
        refuse(inQuotes(word) + ": not in three dimensions", "export the organ as OFF");
      word = next();
      if (word == "BINARY") refuse("a binary OFF file", "export it as text, or as PLY or STL");
    }
    vertex_count_ = count(word, "the number of vertices");
    face_count_ = count(next(), "the number of faces");
    next();  // edges
    text_.nextLine();
    if (2.0 * (3.0 * vertex_count_ + face_count_) > static_cast<double>(bytes_))
      refuse("more vertices and faces are announced than the file has bytes for", "it was cut short: export it again");
  }

  void readBody() {
    for (double n = 0; n < vertex_count_; ++n) {
      Vec3 x;
      for (int k = 0; k < 3; ++k) {
        const std::string_view word = next();
        x[k] = parseNumber(word, text_.place(), "a coordinate");
      }
      result_.source.vertex_line.push_back(text_.place().line);
      result_.surface.vertices.push_back(x);
      text_.nextLine();  // colours and normals
    }
    std::vector<int> corners;
    for (double n = 0; n < face_count_; ++n) {
      const double corner_count = count(next(), "the number of corners");
      const int line = text_.place().line;
      if (corner_count > static_cast<double>(bytes_) / 2) refuse("a face longer than the file", "export it again");
      corners.clear();
      for (double k = 0; k < corner_count; ++k) {
        const std::string_view word = next();
        corners.push_back(asIndex(parseNumber(word, text_.place(), "a vertex index")));
      }
      text_.nextLine();  // colours
      faces_.add(corners, line);
    }
  }

  void finish() { faces_.finish(); }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& advice) {
    throw InputError(text_.place(), problem, advice);
  }

  std::string_view next() {
    for (;;) {
      const std::string_view word = text_.next();
      if (word.empty() || word.front() != '#') return word;
      text_.nextLine();
    }
  }

  double count(std::string_view word, const char* what) {
    const double value = parseNumber(word, text_.place(), what);
    if (!(value >= 0) || value != std::floor(value) || value > 2e9)
      refuse(inQuotes(word) + " is not " + what, "an OFF file begins with OFF and three counts");
    return value;
  }

  TokenReader text_;
  std::size_t bytes_;
  SurfaceFile& result_;
  PolygonFaces faces_;
  double vertex_count_ = 0, face_count_ = 0;
};

}  // namespace

SurfaceFile parseOff(const std::string& bytes, const std::string& file, SurfaceReading reading) {
  return readCounted<OffReader>(bytes, file, reading);
}

}  // namespace palpate
