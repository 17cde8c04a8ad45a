#include "io/vtk_surface_parser.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "base/input_error.h"
#include "base/printable_text.h"
#include "io/byte_reader.h"
#include "io/polygon_faces.h"
#include "io/token_reader.h"

namespace palpate {
namespace {

NumberKind vtkKind(const std::string& word) {
  if (word == "float") return NumberKind::Float32;
  if (word == "double") return NumberKind::Float64;
  if (word == "int" || word == "vtktypeint32") return NumberKind::Int32;
  if (word == "vtktypeint64" || word == "vtkidtype" || word == "long") return NumberKind::Int64;
  return NumberKind::None;
}

class VtkReader {
 public:
  VtkReader(const std::string& bytes, const std::string& file, SurfaceFile& result)
      : bytes_(bytes), file_(file), result_(result), faces_(result) {
    result_.source.file = file;
  }

  void readHeader() {
    if (!line().starts_with("# vtk DataFile")) refuse("a legacy VTK file begins with \"# vtk DataFile Version\"");
    line();  // a title
    const std::string format = lowerCase(word());
    if (format != "ascii" && format != "binary") refuse(inQuotes(format) + " where ASCII or BINARY should stand");
    binary_ = format == "binary";
    if (lowerCase(word()) != "dataset" || lowerCase(word()) != "polydata")
      refuse("this VTK file has no POLYDATA set", "save the surface (not the volume) as PLY, STL or VTK polydata");
  }

  void readBody() {
    for (std::string section = lowerCase(word()); !section.empty(); section = lowerCase(word())) {
      if (section == "points") {
        readPoints();
      } else if (section == "polygons") {
        readPolygons(true);
      } else if (section == "vertices" || section == "lines") {
        readPolygons(false);
      } else if (section == "triangle_strips") {
        refuse("triangle strips", "let the exporting program write triangles (vtkTriangleFilter)");
      } else if (section == "point_data" || section == "cell_data") {
        return;  // values say nothing of the shape
      } else {
        line();  // metadata, names
      }
    }
  }

  void finish() { faces_.finish(); }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& advice = "export the organ again") const {
    const int line = 1 + static_cast<int>(std::count(bytes_.begin(), bytes_.begin() + static_cast<long>(at_), '\n'));
    throw InputError({file_, line, 0}, problem, advice);
  }

  std::string_view line() {
    const std::size_t begin = at_, end = std::min(bytes_.find('\n', begin), bytes_.size());
    at_ = std::min(end + 1, bytes_.size());
    return std::string_view(bytes_).substr(begin, end - begin);
  }

  std::string_view word() {
    const auto blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    while (at_ < bytes_.size() && blank(bytes_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !blank(bytes_[at_])) ++at_;
    return std::string_view(bytes_).substr(begin, at_ - begin);
  }

  double count(const char* what) {
    const std::string_view text = word();
    const double value = parseNumber(text, {file_, 0, 0}, what);
    if (!(value >= 0) || value != std::floor(value) || value > 2e9) refuse(inQuotes(text) + " is not " + what);
    return value;
  }

  /// So many numbers of a kind, which the file must be long enough for.
  void numbers(double count, NumberKind kind, std::vector<double>& values) {
    const double least = binary_ ? static_cast<double>(bytesOf(kind)) : 2;
    if (kind == NumberKind::None) refuse("numbers of an unknown kind");
    if (count * least > static_cast<double>(bytes_.size() - at_) + 2)
      refuse("more numbers are announced than the file has bytes for", "it was cut short: export it again");
    values.clear();
    values.reserve(static_cast<std::size_t>(count));
    if (binary_) line();  // the data begin on the next
    ByteReader reader(bytes_, at_, true);
    for (double k = 0; k < count; ++k) {
      double value = 0;
      if (!binary_)
        value = parseNumber(word(), {file_, 0, 0}, "a number");
      else if (!readNumber(reader, kind, value))
        refuse("the file ends within its numbers", "it was cut short: export it again");
      values.push_back(value);
    }
    if (binary_) at_ = reader.at();
  }

  void readPoints() {
    const double points = count("the number of points");
    const NumberKind kind = vtkKind(lowerCase(word()));
    std::vector<double> x;
    numbers(3 * points, kind, x);
    for (std::size_t k = 0; k + 2 < x.size(); k += 3) result_.surface.vertices.emplace_back(x[k], x[k + 1], x[k + 2]);
  }

  void readPolygons(bool kept) {
    const double first = count("a number of polygons"), second = count("a length");
    const std::size_t mark = at_;
    if (lowerCase(word()) == "offsets") {
      std::vector<double> offsets, corners;
      const NumberKind offset_kind = vtkKind(lowerCase(word()));
      numbers(first, offset_kind, offsets);
      if (lowerCase(word()) != "connectivity") refuse("OFFSETS without CONNECTIVITY");
      const NumberKind corner_kind = vtkKind(lowerCase(word()));
      numbers(second, corner_kind, corners);
      for (std::size_t k = 0; kept && k + 1 < offsets.size(); ++k) {
        const int from = asIndex(offsets[k]), to = asIndex(offsets[k + 1]);
        if (from < 0 || to < from || static_cast<std::size_t>(to) > corners.size()) refuse("OFFSETS beyond the list");
        addPolygon(corners, static_cast<std::size_t>(from), static_cast<std::size_t>(to));
      }
      return;
    }
    at_ = mark;
    std::vector<double> list;
    numbers(second, NumberKind::Int32, list);
    std::size_t at = 0;
    for (double n = 0; kept && n < first; ++n) {
      const int corners = at < list.size() ? asIndex(list[at]) : -1;
      if (corners < 0 || static_cast<std::size_t>(corners) > list.size() - at - 1) refuse("a polygon beyond the list");
      addPolygon(list, at + 1, at + 1 + static_cast<std::size_t>(corners));
      at += 1 + static_cast<std::size_t>(corners);
    }
  }

  void addPolygon(const std::vector<double>& list, std::size_t from, std::size_t to) {
    corners_.clear();
    for (std::size_t k = from; k < to; ++k) corners_.push_back(asIndex(list[k]));
    faces_.add(corners_, 0);
  }

  const std::string& bytes_;
  std::string file_;
  SurfaceFile& result_;
  PolygonFaces faces_;
  std::size_t at_ = 0;
  bool binary_ = false;
  std::vector<int> corners_;
};

}  // namespace

SurfaceFile parseVtk(const std::string& bytes, const std::string& file, SurfaceReading reading) {
  return readCounted<VtkReader>(bytes, file, reading);
}

}  // namespace palpate
