#pragma once

#include "base/types.h"
#include "contact/tool_profile.h"

namespace palpate {

/// Signed distance of a skin point to the tool at the end of a step, by the side that it came in by.
///
/// Nearer to the surface than half the rounding that is the nearest side. Deeper, the nearest side need not be the one
/// that the point came in by: that side is remembered until the point is near the surface on the same side again, or
/// out, and where the nearest side is turned against it by more than 45 degrees, the way out turns to it (fully from
/// 72 degrees on). A point that entered in front never leaves behind.
/// @param local, old_local  the point in the tool's frame at the step's end and start, m
/// @param last_normal       the way out of the last step, tool's frame; 0: it was not in contact
/// @param side              what is remembered: the side, 0 where the point is not deep
/// Real-time. Test: contact/tool_side_test.cpp.
ToolDistance distanceBySide(const ToolProfile& tool, const Vec3& local, const Vec3& old_local, const Vec3f& last_normal,
                            Vec3f& side);

}  // namespace palpate
