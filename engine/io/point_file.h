#pragma once

#include <optional>
#include <string>

#include "base/input_error.h"
#include "scene/scene.h"

namespace palpate {

/// The directions of a file's axes: to the patient's right, front and top, or left, back and top.
enum class Frame { Ras, Lps };

/// Reads measured points: the columns x, y, z of a CSV file say where they are and, where it has them, x0, y0, z0 where
/// they were before; or the points of a 3D Slicer file (.fcsv, .mrk.json), which are where they are.
/// @param unit   m, of the file's lengths; Slicer's files are in mm, and say so
/// @param frame  must be given for CSV; for Slicer's files their header says it, and what is given must agree
/// @param asked_from  where another file names this one
/// Throws InputError naming the line where there is one.
/// Test: io/point_file_test.cpp
PointLoad readPoints(const std::string& path, std::optional<double> unit, std::optional<Frame> frame,
                     const SourceLocation& asked_from = {});

}  // namespace palpate
