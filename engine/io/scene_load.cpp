#include "io/scene_load.h"

#include "io/scene_boundary.h"

namespace palpate {

LoadSpec readLoad(const TomlTable& table, const Scene& scene) {
  LoadSpec load;
  load.place = table.place();
  load.name = "load " + std::to_string(scene.loads.size() + 1);
  table.readName("name", load.name);
  checkResultName(table, load.name, scene.boundaries);
  checkResultName(table, load.name, scene.loads);
  load.whole = !table.has("region");
  if (!load.whole) load.region = readRegion(table.table("region", {"region"}));
  if (table.has("pressure") == table.has("traction"))
    throw InputError(
        table.has("pressure") ? table.place("traction") : table.place(),
        table.has("pressure") ? "both \"pressure\" and \"traction\"" : "neither \"pressure\" nor \"traction\"",
        "give pressure = number in Pa, inwards; or traction = [x, y, z] in Pa");
  if (table.has("traction")) {
    table.forbid({"kind"}, "to a traction, whose direction is fixed");
    load.kind = LoadSpec::Kind::Traction;
    table.read("traction", load.traction);
  } else {
    constexpr LoadSpec::Kind kinds[] = {LoadSpec::Kind::FollowerPressure, LoadSpec::Kind::DeadPressure};
    load.kind = kinds[table.readChoice("kind", 0)];
    table.read("pressure", load.pressure);
  }
  readCourse(table, "a load", load.duration, load.curve);
  return load;
}

}  // namespace palpate
