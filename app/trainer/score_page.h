#pragma once

#include <string>

#include "app/render/organ_view.h"
#include "app/render/picture.h"
#include "app/render/theme.h"
#include "app/trainer/task_score.h"

namespace palpate::app {

/// A page of A4 that one would print: what the score sheet says, each lump and whether it was found, and the organ seen
/// from the tool's side with lumps, marks, the probe's path and the peak pressure on the skin.
/// Draws in the current contexts of OpenGL and Dear ImGui, in no frame's midst; leaves the window's framebuffer bound.
/// @param view  of the same model, in which the score was made
Picture scorePage(const Theme& theme, const Model& model, OrganView& view, const TaskScore& score,
                  const SheetHead& head);

}  // namespace palpate::app
