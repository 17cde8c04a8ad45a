#include "io/scene_boundary.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string_view>

#include "io/point_file.h"

namespace palpate {

namespace {

/// Throws where a name is not fit to head a column of CSV results.
void checkPlain(const TomlTable& table, const std::string& name) {
  const bool plain = name.find_first_of(",\"") == std::string::npos;
  if (name == "tool") {
    throw InputError(table.place("name"), "the name \"tool\" stands for the tool's own force in the results",
                     "give another name");
  }
  if (!plain || name.empty()) {
    throw InputError(table.place("name"), "\"name\" is " + inQuotes(name), "give a name without commas and quotes");
  }
}

/// What fixed and prescribed boundaries have in common.
/// @param usual_name  where the scene gives none
BoundarySpec readBoundary(const TomlTable& table, const std::string& usual_name,
                          const std::vector<BoundarySpec>& others) {
  BoundarySpec boundary;
  boundary.place = table.place();
  boundary.name = usual_name;
  table.readName("name", boundary.name);
  checkResultName(table, boundary.name, others);
  if (!table.has("points")) boundary.region = readRegion(table);
  table.readAxes("components", boundary.component);
  table.read("surface_only", boundary.surface_only);
  return boundary;
}

/// Points that go where they were measured.
void readMeasured(const TomlTable& table, const std::string& folder, BoundarySpec& boundary) {
  for (const char* key : {"shape", "point", "normal", "min", "max", "centre", "radius", "height", "distance",
                          "surface_only", "translation", "axis_point", "axis", "angle"})
    table.forbid({key}, "to measured points");
  std::string name;
  table.read("points", name);
  constexpr double units[] = {0.001, 0.01, 1.0};  // in the order of the key's choices
  std::optional<double> unit;
  std::optional<Frame> frame;
  if (table.has("unit")) unit = units[table.readChoice("unit", 0)];
  if (table.has("frame")) frame = table.readChoice("frame", 0) == 0 ? Frame::Ras : Frame::Lps;
  const auto path = (std::filesystem::path(folder) / name).lexically_normal();
  const auto load = std::make_shared<PointLoad>(readPoints(path.string(), unit, frame, table.place("points")));
  load->sheet = table.readChoice("spread", 0) == 1;
  boundary.points = load;
  table.noteFile(path.string());
}

/// Where a region goes.
void readWay(const TomlTable& table, BoundarySpec& boundary) {
  table.read("translation", boundary.translation);
  const bool rotates = table.has("axis_point") || table.has("axis") || table.has("angle");
  if (rotates) {
    table.require({"axis_point", "axis", "angle"}, "a rotation");
    table.read("axis_point", boundary.axis_point);
    table.readDirection("axis", boundary.axis);
    double degrees = 0;
    table.read("angle", degrees);
    boundary.angle = degrees * std::numbers::pi / 180;
  } else if (!table.has("translation")) {
    throw InputError(table.place(), "neither a translation nor a rotation",
                     "give translation = [x, y, z] in m; or axis_point, axis and angle; or all four");
  }
}

}  // namespace

template <class Spec>
void checkResultName(const TomlTable& table, const std::string& name, const std::vector<Spec>& others) {
  checkPlain(table, name);
  for (const Spec& other : others) {
    if (other.name != name) continue;
    throw InputError(table.place("name"),
                     "the name " + inQuotes(name) + " is taken by line " + std::to_string(other.place.line),
                     "give each [[fixed]], [[prescribed]] and [[load]] a name of its own");
  }
}
template void checkResultName(const TomlTable&, const std::string&, const std::vector<BoundarySpec>&);
template void checkResultName(const TomlTable&, const std::string&, const std::vector<LoadSpec>&);

void readCourse(const TomlTable& table, const std::string& what, double& duration, LoadCurve& curve) {
  if (!table.has("curve_table")) {
    table.require({"duration"}, what + " without \"curve_table\"");
    table.read("duration", duration);
    constexpr LoadCurve::Kind kinds[] = {LoadCurve::Kind::Smooth, LoadCurve::Kind::Linear};
    curve.kind = kinds[table.readChoice("curve", 0)];
    return;
  }
  if (table.has("curve")) {
    throw InputError(table.place("curve"), "both \"curve\" and \"curve_table\"", "give one of them");
  }
  curve.kind = LoadCurve::Kind::Table;
  table.readCurve("curve_table", curve.time, curve.fraction);
  duration = curve.time.back();
  table.read("duration", duration);
  if (duration < curve.time.back()) {
    throw InputError(table.place("duration"), "\"curve_table\" goes on after \"duration\"",
                     "leave \"duration\" out: the table's last time is meant");
  }
}

Region readRegion(const TomlTable& table) {
  struct Shape {
    Region::Kind kind;
    std::string title;
    std::vector<const char*> keys;  // that it needs; it allows no other
  };
  static const Shape shapes[] = {
      // in the order of the key's choices
      {Region::Kind::HalfSpace, "a half-space", {"point", "normal"}},
      {Region::Kind::Box, "a box", {"min", "max"}},
      {Region::Kind::Sphere, "a sphere", {"centre", "radius"}},
      {Region::Kind::NearPlane, "a near-plane region", {"point", "normal", "distance"}},
      {Region::Kind::Cylinder, "a cylinder", {"point", "normal", "radius", "height"}},
      {Region::Kind::Shell, "a shell", {"distance"}},
  };
  const Shape& shape = shapes[table.readChoice("shape", 0)];
  for (const char* key : shape.keys) table.require({key}, shape.title);
  for (const char* key : {"point", "normal", "min", "max", "centre", "radius", "height", "distance"}) {
    const bool needed =
        std::any_of(shape.keys.begin(), shape.keys.end(), [key](std::string_view needs) { return needs == key; });
    if (!needed) table.forbid({key}, "to " + shape.title);
  }
  Region region;
  region.place = table.place();
  region.kind = shape.kind;
  table.read("point", region.point);
  table.read("centre", region.point);
  table.readDirection("normal", region.normal);
  table.read("min", region.min);
  table.read("max", region.max);
  table.read("radius", region.radius);
  table.read("height", region.height);
  table.read("distance", region.distance);
  if ((region.min.array() > region.max.array()).any()) {
    throw InputError(table.place("min"), "the box's \"min\" is above its \"max\"", "swap the coordinates");
  }
  return region;
}

BoundarySpec readMotion(const TomlTable& table) {
  BoundarySpec boundary;
  readWay(table, boundary);
  readCourse(table, "a motion", boundary.duration, boundary.curve);
  return boundary;
}

BoundarySpec readFixed(const TomlTable& table, const std::vector<BoundarySpec>& before) {
  return readBoundary(table, "fixed " + std::to_string(before.size() + 1), before);
}

BoundarySpec readPrescribed(const TomlTable& table, const std::string& folder,
                            const std::vector<BoundarySpec>& before) {
  const auto moving = std::count_if(before.begin(), before.end(), [](const BoundarySpec& b) { return b.duration > 0; });
  BoundarySpec boundary = readBoundary(table, "prescribed " + std::to_string(moving + 1), before);
  if (table.has("points")) {
    readMeasured(table, folder, boundary);
  } else {
    table.forbid({"unit", "frame", "spread"}, "without \"points\"");
    readWay(table, boundary);
  }
  readCourse(table, "a motion", boundary.duration, boundary.curve);
  return boundary;
}

}  // namespace palpate
