#include <string>
#include <string_view>

#include "contact/tool.h"
#include "io/scene_keys.h"

namespace palpate {
namespace {

struct Section {
  const char* table;
  const char* title;
  const char* text;
};

constexpr Section sections[] = {
    {"", "Top level", ""},
    {"organ", "`[organ]`",
     "A closed surface from a file, or an analytic solid. Several stand as `[[organ]]`: they touch one another, as "
     "separate closed parts of one surface do, and must not overlap. `report.json` has the force of the others on "
     "each."},
    {"discretization", "`[discretization]`", ""},
    {"discretization.refine", "`[[discretization.refine]]`",
     "Any number of them; where they overlap the finest counts."},
    {"material", "`[[material]]`", "One or more."},
    {"region", "Region",
     "Not a table of its own: these keys choose a part of space, inline in `[[fixed]]` and `[[prescribed]]`, and in a "
     "material's or load's `region = { ... }`. All coordinates are the organ's at rest, after scaling."},
    {"boundary", "`[[fixed]]`",
     "One or more, or none where `[[prescribed]]` holds the organ. The keys of a [region](#region), and these. The "
     "displacement field there is exactly zero."},
    {"prescribed", "`[[prescribed]]`",
     "The keys of `[[fixed]]`, and these: where the region's nodes go (a translation, a rotation or a rotation "
     "followed "
     "by a translation, of which only `components` are imposed), and how over time."},
    {"rigid", "`[[rigid]]`",
     "A rigid body that the organ's skin can't enter, and tools stop at: a table, a plate, a retractor, which stands "
     "still or moves on a path. Penetration stays below 0.1 mm where nodes are dense enough (reports measure it on all "
     "of the skin); an organ that reaches up to 1 mm into it at rest is "
     "pushed out, one that reaches further is refused. Reports have its force on the tissue by its name. A round one "
     "presses as a tool does: where the cloud follows the tool there are nodes for it, and elsewhere its force is "
     "doubted where the nodes are too far apart for it. With a rigid "
     "body an organ needs no `[[fixed]]`: it lies there by `gravity`, and what slides off has slid off (a reset brings "
     "it back). `mtled solve` takes it, too: a static solution without friction, and with something fixed, or it would "
     "be one of many."},
    {"load", "`[[load]]`",
     "A pressure or traction on the skin, and how it comes over time. It acts in the loop and in `mtled solve`, whose "
     "`force.csv` has each load's force on the tissue. Sensitivities (`mtled identify --regions`) refuse it."},
    {"skull", "`[skull]`",
     "Short for a `[[rigid]]` surface that encloses the organ (`side = \"inside\"`), whose skin slides along it "
     "without "
     "friction. Tools pass it."},
    {"dynamics", "`[dynamics]`", ""},
    {"solve", "`[solve]`", "For solutions without a window; the interactive program ignores it."},
    {"tool", "`[tool]`",
     "Without this table a ball of radius 10 mm starts at (0, 0, 0.1) m and points down. Up to four are written as "
     "`[[tool]]`, each with keys of its own; the first is the mouse's, and the one whose force is filtered."},
    {"force", "`[force]`", ""},
    {"device", "`[device]`",
     "For `palpate SCENE --device`: [the coupling](../../engine/realtime/device/README.md) between a device's handle "
     "and "
     "the tool."},
    {"camera", "`[camera]`", ""},
    {"lump", "`[[lump]]`",
     "A stiffer ball of tissue with a finer spacing around it, as `[[material]]` and `[[discretization.refine]]` would "
     "make it. Scenes with lumps are tasks: they are hidden until the answers are in."},
    {"lumps", "`[lumps]`", "Lumps at random places that the tool gets to, the same for the same seed."},
};

/// What each tool is and the keys that only it has.
std::string toolReference() {
  std::string text;
  for (const ToolType* tool : toolTypes()) {
    text += std::string("\n`shape = \"") + tool->name + "\"`: " + tool->meaning + ".\n";
    if (tool->parameters.empty()) continue;
    text += '\n';
    text += keyReference(sceneKeys(), toolKeyGroup(*tool));
  }
  return text;
}

/// What stands before the tables. A test reads the scene in it.
constexpr const char* introduction = R"(## A scene in nine lines

Type this into `my.toml`:

```toml
name = "slab"                                       # title of the window
organ = { solid = "box", size = [0.1, 0.1, 0.05] }  # m: z goes from 0 to 0.05, the z axis is in the middle
fixed = [{ shape = "half-space", point = [0, 0, 0.001], normal = [0, 0, 1] }]  # m: held below z = 0.001
tool = { shape = "sphere", radius = 0.01, position = [0, 0, 0.06] }  # m: a ball, 10 mm above the slab
[[material]]           # all keys from here on describe the tissue
model = "neo-hookean"  # its law
young = 3000           # Pa: about as soft as a liver
poisson = 0.45         # nearly incompressible (0.5 would be entirely)
density = 1050         # kg/m^3
```

`tools/run my.toml` opens it: nodes are dense around the ball, and follow it. `tools/run my.toml --tool
indent_hold_retract` presses the ball 5 mm deep: the force at the hold is 0.19 N. Change `young` to 6000, and it is
twice that.

## Reference

The tables are printed from the parser's own list of keys (`engine/io/scene_keys.cpp`). "Depends" means: required or
without meaning, depending on the other keys.
)";

}  // namespace

std::string sceneReference() {
  std::string text = introduction;
  for (const auto& [table, title, about] : sections) {
    text += std::string("\n### ") + title + "\n\n";
    if (*about != '\0') text += std::string(about) + "\n\n";
    text += keyReference(sceneKeys(), table);
    if (std::string_view(table) == "tool") text += toolReference();
  }
  return text;
}

}  // namespace palpate
