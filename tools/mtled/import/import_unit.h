#pragma once

#include <string>

namespace palpate::tools {

/// The unit of a surface file, which says nothing about it.
struct SurfaceUnit {
  std::string name;    // "mm", "cm" or "m"
  double length = 1;   // m
  std::string reason;  // why this one, with the organ's length: "it is 161 mm long then"
};

/// The unit asked for; else mm or m, if no other unit than this one makes an organ of 5 mm to 0.6 m. Throws InputError
/// at `file` where more than one does, none, or only cm, which is rare, naming the lengths that each would give.
/// @param length  of the longest edge of the surface's bounding box, in the file's unit
SurfaceUnit surfaceUnit(const std::string& file, const std::string& asked, double length);

}  // namespace palpate::tools
