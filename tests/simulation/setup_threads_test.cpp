#include <catch2/catch.hpp>

#include "base/parallel_for.h"
#include "support/equal_models.h"
#include "support/small_scene.h"

using namespace palpate;

TEST_CASE("A model has the same bits for any number of threads that make it", "[build_model][whole]") {
  Scene scene = test::blockScene(0.008);
  SECTION("as it is") {}
  SECTION("with all that is optional") {
    scene.discretization.quadrature.accuracy = 0.1;
    scene.discretization.quadrature.max_depth = 1;
    scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
    scene.discretization.refine.push_back({Vec3(0, 0, 0.03), 0.01, 0.006, 0, {}});
  }
  setup_threads = 1;
  const Model alone = test::blockModel(scene);
  for (const int threads : {2, 3, 7}) {
    setup_threads = threads;
    INFO(threads << " threads");
    test::requireSameModel(test::blockModel(scene), alone);
  }
  setup_threads = 0;
}
