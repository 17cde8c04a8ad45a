#pragma once

#include <array>
#include <span>
#include <string>
#include <variant>

#include "base/types.h"

namespace palpate {

/// One quantity at all points, or in all cells, for ParaView. It refers to the caller's array.
struct VtuField {
  std::string name;  // with its unit, as ParaView shows it
  std::variant<std::span<const float>, std::span<const double>, std::span<const int>> values;  // (count x components)
  int components = 1;  // 1 scalar, 3 vector, 9 tensor (by rows)
};

/// The field of an array of vectors.
VtuField vtuVectors(std::string name, std::span<const Vec3> values);

/// Writes tetrahedra with their fields as an unstructured grid of VTK (VTU: XML with base64 of little-endian arrays),
/// whole or not at all (output_file.h).
///
/// @param points        m                            (point_count)
/// @param cells         points, positively oriented  (cell_count); none: bare points
/// @param point_fields  count = point_count in each
/// @param cell_fields   count = cell_count in each (bare points: point_count)
/// Throws std::runtime_error with file and reason when it can't be written, std::invalid_argument
/// where a field's length does not fit or a cell names a point that is not there.
/// Test: io/vtu_file_test.cpp reads it back with meshio.
void writeVtu(const std::string& path, std::span<const Vec3> points, std::span<const std::array<int, 4>> cells,
              std::span<const VtuField> point_fields, std::span<const VtuField> cell_fields = {});

/// One file of a series in time.
struct PvdFrame {
  double time = 0;   // s
  std::string file;  // VTU, relative to the PVD file
};

/// Writes the series (PVD) that ParaView opens as one, whole or not at all; so it can be written anew after each frame.
void writePvd(const std::string& path, std::span<const PvdFrame> frames);

}  // namespace palpate
