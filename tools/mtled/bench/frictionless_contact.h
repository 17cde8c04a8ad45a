#pragma once

#include "contact/contact.h"

namespace palpate::tools {

/// solveContact as one would write it for a tool without friction: no tangential force, no memory of it. What the
/// solver is held to
/// where a scene's friction is 0. Arguments as there.
Vec3 frictionlessContact(const SkinModel& skin, const ToolShape& tool, const Pose& pose, const Pose& previous_pose,
                         double alpha, const float* inverse_mass, const Float4* u, Float4* du, ContactState& contact);

}  // namespace palpate::tools
