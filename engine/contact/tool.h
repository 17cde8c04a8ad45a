#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "base/parameter.h"
#include "base/types.h"
#include "contact/tool_profile.h"

namespace palpate {

/// A number from 0 for each tool of contact/tools/tool_list.h, which names them (ToolKind::Sphere, ...). Not here, so
/// that a new tool compiles nothing anew but what names tools.
enum class ToolKind : int;

/// A rigid tool. Its local frame: the axis is +z, pointing from the tip into the
/// handle; the origin is the tip (the lowest point), so a pose's position is
/// where the tip is and the tool advances along -z.
struct ToolShape {
  static constexpr int max_parameters = 4;

  ToolKind kind{};                                    // the first: a sphere
  double radius = 0.01;                               // m
  double length = 0.06;                               // m, tip to end; a sphere ignores it
  std::array<double, max_parameters> parameter = {};  // those of ToolType::parameters, in their order

  /// A tool of this kind whose own parameters have their defaults.
  static ToolShape of(ToolKind kind, double radius, double length = 0.06);
};

/// Why a tool can't be made.
struct ToolFault {
  const char* key;      // the scene's key that is at fault
  const char* problem;  // what is wrong
  const char* advice;   // what to do
};

/// All there is to know of a kind of tool; the scene's keys, their reference, contact, pictures and panels use it.
struct ToolType {
  const char* name;                       // `shape` in scenes: "cylinder"
  const char* title;                      // in panels and messages: "flat cylinder"
  const char* meaning;                    // in the scene reference: "a flat-ended cylinder"
  std::span<const Parameter> parameters;  // beside radius and length; numbers with defaults, at most max_parameters

  /// The tool's surface. Any values of the parameters give some surface.
  ToolProfile (*profile)(const ToolShape&);

  /// What is wrong with parameters that are in their ranges but don't fit each other.
  std::optional<ToolFault> (*fault)(const ToolShape&);

  // The rod behind the tool that the picture shows, in radii; the contact doesn't know it.
  double neck_radius = 0.42, neck_length = 1.2;
};

const ToolType& toolType(ToolKind kind);

/// All tools, in the order of ToolKind.
std::span<const ToolType* const> toolTypes();

/// The tool's surface. What asks for many distances makes it once. Real-time.
ToolProfile toolProfile(const ToolShape& tool);

/// Default of a tool's rounding (a rim, a pointed tip) per radius.
///
/// A rim sharper than the skin's spacing e can't be felt smoothly: dragged half a radius deep at
/// 10 mm/s, vertices snap around it one by one and a 2 ms tick changes the force by 5-25 % of the peak
/// at a rounding of 0.3 e, 2-6 % at e, below 1.2 % from 1.2 e on. Hence 0.3 R for skins with edges of 0.25 R.
inline constexpr double default_rounding_per_radius = 0.3;

/// The rounding in use, m: what is asked for or, where that is 0, the default; no more than fits the tool.
double roundingOf(const ToolShape& tool, double asked);

// The same as with a ToolProfile, which they make first.
ToolDistance toolDistance(const ToolShape& tool, const Vec3& local);
double tipProfile(const ToolShape& tool, double r);

/// Radius of the ball that wants nodes as close as the tool's end does, m: a flat end's own radius; where the end is
/// round or pointed, with a tip of radius t behind which the tool has R, sqrt(t R). A quarter of R deep both touch a
/// disk of half that radius (Hertz).
double touchRadius(const ToolShape& tool);

/// Bound on how far any point of the tool travels between two poses, m. Real-time.
double largestTravel(const ToolShape& tool, const Pose& from, const Pose& to);

}  // namespace palpate
