#include "app/trainer/felt_layout.h"

#include <optional>

#include "app/trainer/feel_check.h"
#include "base/number_text.h"

namespace palpate::app {

TaskBody makeTask(Scene& scene, const TaskMaking& making) {
  if (!scene.places.contains("lumps.count") || scene.places.contains("lumps.layout")) {
    TaskBody body = making.build(scene);
    requireFelt(body, making.cache_folder, making.progress);
    return body;
  }
  for (int layout = 1;; ++layout) {
    TaskBody body = making.build(scene);
    const std::optional<Unfelt> unfelt = unfeltLump(body, making.cache_folder, making.progress);
    if (!unfelt) return body;
    if (layout == most_layouts)
      throw InputError(
          unfelt->place,
          format("none of the first %d layouts of this seed has lumps that can all be felt; in the last, %s",
                 most_layouts, unfelt->problem.c_str()),
          "try another seed, fewer lumps, a lower level or a smaller tool");
    if (making.say)
      making.say(format("the seed's layout %d has a lump that can't be felt: taking layout %d", layout, layout + 1));
    scene = making.read(layout + 1);
  }
}

}  // namespace palpate::app
