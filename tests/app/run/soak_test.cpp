#include "app/run/soak.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "app/run/session.h"
#include "app/run/soak_places.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("A soak presses where its tool meets the organ's top, and no deeper than the organ bears", "[soak]") {
  Scene scene = test::blockScene();
  const Model model = test::blockModel(scene);
  const std::vector<SoakPlace> places = soakPlaces(model, 20, 5);
  REQUIRE(places.size() == 20);
  double farthest = 0;
  for (const SoakPlace& place : places) {
    CHECK(place.touch == Approx(0.002).margin(1e-9));  // it starts 2 mm above
    CHECK(place.depth == Approx(0.0075));              // a quarter of 30 mm; 0.8 radii are 8 mm
    CHECK(place.slide.cwiseAbs().maxCoeff() <= 0.03);
    farthest = std::max(farthest, place.slide.norm());
  }
  CHECK(farthest > 0.015);
  scene.organs[0].size.z() = 0.004;  // too thin to press
  scene.discretization.spacing = 0.008;
  CHECK_THROWS_AS(soakPlaces(test::blockModel(scene), 20, 5), InputError);
}

TEST_CASE("A soak runs to its end, leaves its report and fails just where a promise is broken", "[soak][whole]") {
  const TempFolder folder;
  const std::string file = folder.path("block.toml"), out = folder.path("out");
  std::ofstream(file)
      << "name = \"block\"\n[organ]\nsolid = \"box\"\nsize = [0.06, 0.06, 0.03]\n"
         "[discretization]\nspacing = 0.015\n[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.48\n"
         "density = 1000\n[[fixed]]\nshape = \"half-space\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"
         "[dynamics]\ndamping = 60\n[tool]\nshape = \"sphere\"\nradius = 0.01\n"
         "position = [0, 0, 0.032]\ndirection = [0, 0, -1]\n";
  Options options;
  options.scene = file;
  options.offscreen = options.as_fast_as_possible = true;
  options.soak_minutes = 0.5;
  options.out = out;
  Log log;
  Session session(options, readScene(options), log);
  session.start();
  while (!session.finished()) {
    session.gather();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  session.finish();
  nlohmann::json report;
  std::ifstream(out + "/soak.json") >> report;
  CHECK(report["state"] == "done");
  CHECK(report["ticks"] == 15'000);
  CHECK(report["cycles"] >= 8);
  CHECK(report["unrested_cycles"] == 0);
  // How far this coarse block's rests may lie apart is soak_motion_test.cpp's matter; here: what is told is what
  // counts.
  const bool drifted = report["drift"] > 1e-6;
  CHECK(report["broken_promises"].size() == (drifted ? 1 : 0));
  CHECK(session.failure().empty() == !drifted);
  CHECK(report["peak_force_N"] > 0.02);
  CHECK(report["memory_growth"].is_number());  // the warm-up was over
  CHECK(report["threads_since_warm_up"].size() == 1);
  CHECK(std::filesystem::file_size(out + "/soak.txt") > 500);
  CHECK_FALSE(std::filesystem::exists(out + "/force.csv"));
}
