#pragma once

#include <functional>
#include <string>

#include "app/trainer/lumps.h"
#include "scene/scene.h"

namespace palpate::app {

/// How a task's body is made.
struct TaskMaking {
  std::function<TaskBody(const Scene&)> build;
  std::function<Scene(int layout)> read;  // the scene, with the lumps of its seed in another layout (lumps.layout)
  std::function<void(const std::string&)> say{};  // gets what was decided
  std::string cache_folder{};                     // as requireFelt
  std::function<void(double)> progress{};         // of feeling the lumps, 0 .. 1; may throw to end it
};

/// Layouts of a seed that are tried: at the third level one in eighteen can't be felt, at the others none was.
inline constexpr int most_layouts = 12;

/// The scene's body, whose lumps can be felt. Where they lie at random and the scene does not name a layout, the first
/// layout of its seed in which all are felt: the same for the same scene. Throws InputError where there is none.
/// @param scene  receives that layout
TaskBody makeTask(Scene& scene, const TaskMaking& making);

}  // namespace palpate::app
