#include "app/run/saved_files.h"

#include <catch2/catch.hpp>

#include "io/text_file.h"
#include "model/solution_fields.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("Fields for ParaView are those of the materials in force, and tell no stress that may have relaxed",
          "[saved_files]") {
  const Scene scene = test::blockScene();
  Scene stiffer_scene = scene;
  stiffer_scene.materials[0].material.set("young", 6000);
  const Model model = test::blockModel(scene), stiffer = test::blockModel(stiffer_scene);
  Snapshot snapshot;
  std::vector<Vec3> u;
  for (const Vec3& X : model.X) {
    u.emplace_back(0.1 * X.z(), 0, -0.2 * X.z());
    snapshot.u.push_back(toFloat4(u.back()));
  }
  const KernelMaterials in_force = makeKernelMaterials(model.kernel, stiffer.materials);
  const SolutionFields live = solutionFields(model, u, {}, {}, &in_force), built = solutionFields(stiffer, u);
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    REQUIRE(live.pressure[c] == Approx(built.pressure[c]).epsilon(1e-5));
    REQUIRE(live.von_mises[c] == Approx(built.von_mises[c]).epsilon(1e-5));
  }

  const TempFolder folder;
  const auto written = [&](std::vector<Material> materials) {
    snapshot.materials = std::move(materials);
    app::writeStateVtu(folder.path("state.vtu"), model, snapshot);
    return readWholeFile(folder.path("state.vtu"));
  };
  const std::string as_loaded = written(model.materials), as_set = written(stiffer.materials);
  CHECK_THAT(as_loaded, Contains("pressure_Pa") && Contains("von_Mises_Pa"));
  CHECK(as_set != as_loaded);
  std::vector<Material> relaxing = model.materials;
  relaxing[0].relaxation_count = 1;
  relaxing[0].relaxation[0] = 0.3;
  relaxing[0].relaxation[1] = 0.1;
  CHECK_THAT(written(relaxing), Contains("pressure_Pa") && !Contains("von_Mises_Pa"));
}
