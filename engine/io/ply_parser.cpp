#include "io/ply_parser.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "base/input_error.h"
#include "io/byte_reader.h"
#include "io/polygon_faces.h"
#include "io/token_reader.h"

namespace palpate {
namespace {

struct PlyProperty {
  std::string name;
  NumberKind kind = NumberKind::None;
  NumberKind count_kind = NumberKind::None;  // of a list
  bool isList() const { return count_kind != NumberKind::None; }
};

struct PlyElement {
  std::string name;
  double count = 0;
  SourceLocation place;
  std::vector<PlyProperty> properties;
};

NumberKind plyKind(std::string_view word) {
  struct Name {
    const char *old_name, *new_name;
    NumberKind kind;
  };
  constexpr Name names[] = {{"char", "int8", NumberKind::Int8},        {"uchar", "uint8", NumberKind::UInt8},
                            {"short", "int16", NumberKind::Int16},     {"ushort", "uint16", NumberKind::UInt16},
                            {"int", "int32", NumberKind::Int32},       {"uint", "uint32", NumberKind::UInt32},
                            {"float", "float32", NumberKind::Float32}, {"double", "float64", NumberKind::Float64}};
  for (const Name& name : names)
    if (word == name.old_name || word == name.new_name) return name.kind;
  return NumberKind::None;
}

class PlyReader {
 public:
  PlyReader(const std::string& bytes, const std::string& file, SurfaceFile& result)
      : bytes_(bytes), file_(file), text_(bytes, file), result_(result), faces_(result) {
    result_.source.file = file;
  }

  void readHeader() {
    if (text_.nextInLine() != "ply") refuse("a PLY file begins with \"ply\"", "export the organ again as PLY");
    std::string format;
    for (;;) {
      if (!text_.nextLine()) refuse("the header does not end", "the file was cut short: export it again");
      const std::string_view word = text_.nextInLine();
      if (word == "end_header") break;
      if (word == "format") {
        format = std::string(text_.nextInLine());
      } else if (word == "element") {
        PlyElement element;
        element.name = std::string(text_.nextInLine());
        element.place = text_.place();
        element.count = parseNumber(text_.nextInLine(), text_.place(), "an element's count");
        if (!(element.count >= 0) || element.count != std::floor(element.count) || element.count > 2e9)
          throw InputError(element.place, "a count of " + inQuotes(element.name) + " that can't be", "export it again");
        elements_.push_back(std::move(element));
      } else if (word == "property") {
        readProperty();
      }  // comments and what else there is say nothing of the shape
    }
    ascii_ = format == "ascii";
    if (!ascii_ && format != "binary_little_endian" && format != "binary_big_endian")
      refuse(inQuotes(format) + " is not a PLY format", "it is ascii, binary_little_endian or binary_big_endian");
    big_endian_ = format == "binary_big_endian";
    for (const PlyElement& element : elements_)  // left out in silence they would be a hole, or all of the organ
      if (element.name == "tristrips" && element.count > 0)
        throw InputError(element.place, "triangle strips are not read", "export plain faces: element face");
  }

  void readBody() {
    std::size_t body = bytes_.find("end_header");
    body = body == std::string::npos ? bytes_.size() : bytes_.find('\n', body);
    ByteReader binary(bytes_, body == std::string::npos ? bytes_.size() : body + 1, big_endian_);
    for (const PlyElement& element : elements_) {
      checkLength(element, ascii_ ? bytes_.size() : binary.left());
      const bool vertex = element.name == "vertex", face = element.name == "face";
      const int axis[3] = {placeOf(element, "x"), placeOf(element, "y"), placeOf(element, "z")};
      const int list = std::max(placeOf(element, "vertex_indices"), placeOf(element, "vertex_index"));
      if (vertex && std::min({axis[0], axis[1], axis[2]}) < 0)
        throw InputError(element.place, "vertices without x, y and z", "export the organ again");
      if (face && (list < 0 || !element.properties[static_cast<std::size_t>(list)].isList()))
        throw InputError(element.place, "faces without a list \"vertex_indices\"",
                         "export the organ as a triangle mesh");
      for (double n = 0; n < element.count; ++n) {
        const int line = readRow(element, binary);
        if (vertex) {
          result_.surface.vertices.emplace_back(row_[axis[0]], row_[axis[1]], row_[axis[2]]);
          if (ascii_) result_.source.vertex_line.push_back(line);
        } else if (face) {
          faces_.add(lists_[static_cast<std::size_t>(list)], ascii_ ? line : 0);
        }
      }
    }
  }

  void finish() { faces_.finish(); }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& advice) {
    throw InputError({file_, text_.line(), 0}, problem, advice);
  }

  static int placeOf(const PlyElement& element, std::string_view name) {
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      if (element.properties[p].name == name) return static_cast<int>(p);
    return -1;
  }

  void readProperty() {
    if (elements_.empty()) refuse("a property before any element", "export the organ again");
    PlyProperty property;
    std::string_view word = text_.nextInLine();
    if (word == "list") {
      property.count_kind = plyKind(text_.nextInLine());
      if (property.count_kind == NumberKind::None) refuse("a list without a kind of count", "export the organ again");
      word = text_.nextInLine();
    }
    property.kind = plyKind(word);
    if (property.kind == NumberKind::None)
      refuse(inQuotes(word) + " is not a kind of number", "export the organ again");
    property.name = std::string(text_.nextInLine());
    constexpr std::size_t most = 256;  // of an element: far more than any program writes
    if (elements_.back().properties.size() >= most) refuse("too many properties", "export only the shape");
    elements_.back().properties.push_back(std::move(property));
  }

  /// Refuses a count that the file is too short for, before memory is taken for it.
  void checkLength(const PlyElement& element, std::size_t left) const {
    double least = 0;  // bytes of a row
    for (const PlyProperty& p : element.properties)
      least += ascii_ ? 2 : static_cast<double>(bytesOf(p.isList() ? p.count_kind : p.kind));
    if (element.count * least > static_cast<double>(left) + 2)
      throw InputError(element.place,
                       "more of " + inQuotes(element.name) + " are announced than the file has bytes for",
                       "it was cut short: export it again");
    if (element.properties.empty() && element.count > 0)
      throw InputError(element.place, inQuotes(element.name) + " without properties", "export it again");
  }

  double next(ByteReader& binary, NumberKind kind) {
    if (ascii_) {
      const std::string_view word = text_.next();
      return parseNumber(word, text_.place(), "a number");
    }
    double value = 0;
    if (!readNumber(binary, kind, value))
      throw InputError({file_, 0, 0}, "the file ends within its numbers", "it was cut short: export it again");
    return value;
  }

  /// One row of an element into row_ and lists_. @return its line
  int readRow(const PlyElement& element, ByteReader& binary) {
    row_.resize(element.properties.size());
    lists_.resize(element.properties.size());
    int line = 0;
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (!property.isList()) {
        row_[p] = next(binary, property.kind);
      } else {
        const double count = next(binary, property.count_kind);
        const double room = static_cast<double>(ascii_ ? bytes_.size() / 2 : binary.left());
        if (!(count >= 0) || count > room)
          throw InputError({file_, ascii_ ? text_.line() : 0, 0}, "a list longer than the file", "export it again");
        lists_[p].clear();
        for (double k = 0; k < count; ++k) lists_[p].push_back(asIndex(next(binary, property.kind)));
      }
      if (p == 0) line = text_.place().line;
    }
    return line;
  }

  const std::string& bytes_;
  std::string file_;
  TokenReader text_;
  SurfaceFile& result_;
  PolygonFaces faces_;
  std::vector<PlyElement> elements_;
  bool ascii_ = true, big_endian_ = false;
  std::vector<double> row_;
  std::vector<std::vector<int>> lists_;
};

}  // namespace

SurfaceFile parsePly(const std::string& bytes, const std::string& file, SurfaceReading reading) {
  return readCounted<PlyReader>(bytes, file, reading);
}

}  // namespace palpate
