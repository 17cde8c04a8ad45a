#include "io/vtu_file.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/number_text.h"
#include "io/base64.h"
#include "io/output_file.h"

namespace palpate {

namespace {

static_assert(std::endian::native == std::endian::little, "the arrays are written as they lie in memory");
static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(int) == 4);

constexpr int vtk_vertex = 1, vtk_tetra = 10;  // cell types of VTK's file formats

template <class T>
const char* typeName() {
  if constexpr (std::is_same_v<T, float>) return "Float32";
  if constexpr (std::is_same_v<T, double>) return "Float64";
  if constexpr (std::is_same_v<T, int>) return "Int32";
  return "UInt8";
}

std::string escaped(const std::string& text) {
  std::string result;
  for (char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

/// A DataArray: its size in bytes (UInt64) and its values, as one run of base64.
template <class T>
void appendArray(std::string& text, const std::string& name, int components, std::span<const T> values) {
  text += std::string("<DataArray type=\"") + typeName<T>() + "\" Name=\"" + escaped(name) + "\"" +
          (components > 1 ? " NumberOfComponents=\"" + std::to_string(components) + "\"" : "") + " format=\"binary\">";
  const std::uint64_t size = values.size_bytes();
  std::vector<unsigned char> bytes(sizeof size + size);
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values.data(), size);
  appendBase64(text, bytes);
  text += "</DataArray>\n";
}

void appendFields(std::string& text, const char* element, std::span<const VtuField> fields, std::size_t count) {
  text += std::string("<") + element + ">\n";
  for (const VtuField& field : fields) {
    std::visit(
        [&](const auto& values) {
          if (field.components < 1 || values.size() != count * static_cast<std::size_t>(field.components)) {
            throw std::invalid_argument("the field " + field.name + " has " + std::to_string(values.size()) +
                                        " values, not " + std::to_string(field.components) + " for each of " +
                                        std::to_string(count));
          }
          appendArray(text, field.name, field.components, values);
        },
        field.values);
  }
  text += std::string("</") + element + ">\n";
}

void appendCells(std::string& text, std::span<const std::array<int, 4>> cells, std::size_t point_count) {
  std::vector<int> connectivity, offsets;
  for (const auto& cell : cells) {
    for (int node : cell) {
      if (node < 0 || static_cast<std::size_t>(node) >= point_count) {
        throw std::invalid_argument("a cell names point " + std::to_string(node) + " of " +
                                    std::to_string(point_count));
      }
      connectivity.push_back(node);
    }
    offsets.push_back(static_cast<int>(connectivity.size()));
  }
  const bool bare = cells.empty();  // points that belong to no cell would not be drawn
  for (std::size_t i = 0; bare && i < point_count; ++i) {
    connectivity.push_back(static_cast<int>(i));
    offsets.push_back(static_cast<int>(i + 1));
  }
  const std::vector<unsigned char> types(offsets.size(), bare ? vtk_vertex : vtk_tetra);
  text += "<Cells>\n";
  appendArray<int>(text, "connectivity", 1, connectivity);
  appendArray<int>(text, "offsets", 1, offsets);
  appendArray<unsigned char>(text, "types", 1, types);
  text += "</Cells>\n";
}

}  // namespace

VtuField vtuVectors(std::string name, std::span<const Vec3> values) {
  const double* first = values.empty() ? nullptr : values.front().data();
  return {std::move(name), std::span<const double>(first, 3 * values.size()), 3};
}

void writeVtu(const std::string& path, std::span<const Vec3> points, std::span<const std::array<int, 4>> cells,
              std::span<const VtuField> point_fields, std::span<const VtuField> cell_fields) {
  const std::size_t cell_count = cells.empty() ? points.size() : cells.size();
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n"
      "<Piece NumberOfPoints=\"" +
      std::to_string(points.size()) + "\" NumberOfCells=\"" + std::to_string(cell_count) + "\">\n<Points>\n";
  const VtuField coordinates = vtuVectors("Points", points);
  appendArray(text, coordinates.name, 3, std::get<std::span<const double>>(coordinates.values));
  text += "</Points>\n";
  appendCells(text, cells, points.size());
  appendFields(text, "PointData", point_fields, points.size());
  appendFields(text, "CellData", cell_fields, cell_count);
  text += "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  writeWholeFile(path, text);
}

void writePvd(const std::string& path, std::span<const PvdFrame> frames) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n";
  for (const PvdFrame& frame : frames) {
    text += "<DataSet timestep=\"" + shortest(frame.time) + "\" group=\"\" part=\"0\" file=\"" + escaped(frame.file) +
            "\"/>\n";
  }
  text += "</Collection>\n</VTKFile>\n";
  writeWholeFile(path, text);
}

}  // namespace palpate
