#pragma once

// What the tissue's skin touches, in the order of use:
// clang-format off
#include "contact/tool.h"                  // shape, signed distance
#include "contact/tool_set.h"              // several tools, jaws
#include "contact/skin.h"                  // buildSkinModel, at load
#include "contact/first_contact_travel.h"  // firstContactTravel, at load
#include "contact/contact_state.h"         // makeContactState, at load
#include "contact/broad_phase.h"           // findContactCandidates, once per tick
#include "contact/samples/face_samples.h"  // findFaceSamples, once per tick after it
#include "contact/skin_contact.h"          // bodies against one another: findSkinPairs, once per tick
#include "contact/rigid_bodies.h"          // addRigidBody, at load
#include "contact/contact_solver.h"        // solveContacts: all that touches, once per step
#include "contact/true_depth.h"            // how deep the skin is pressed, once per tick
// clang-format on
