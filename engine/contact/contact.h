#pragma once

// Contact between a rigid tool and the tissue's skin, in the order of use:
#include "contact/tool.h"            // shape, signed distance
#include "contact/skin.h"            // buildSkinModel, at load
#include "contact/touch_travel.h"    // touchTravel, at load
#include "contact/contact_state.h"   // makeContactState, at load
#include "contact/broad_phase.h"     // findContactCandidates, once per tick
#include "contact/contact_solver.h"  // solveContact, once per step
