#include "io/gltf_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/text_file.h"
#include "support/temp_folder.h"

using namespace palpate;
using nlohmann::json;

namespace {

/// A tetrahedron whose top is pressed in, and a triangle that moves and turns by a right angle.
GltfRun pressedTetrahedron() {
  GltfRun run;
  run.time_s = {0, 0.05, 0.125};
  run.surface.name = "tissue";
  run.surface.rest = {{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  for (const float top : {0.1F, 0.08F, 0.05F})
    run.surface.frames.push_back({{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}, {0.01F, 0, top}});
  GltfBody tool{"tool", {{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}}, {{0, 1, 2}}}, Vec3(0.5, 0.5, 0.5), {}};
  for (const double turn : {0.0, 0.25, 0.5})
    tool.poses.push_back(
        {Vec3(0, 0, 0.2 - 0.1 * turn), Quat(Eigen::AngleAxisd(turn * std::acos(-1.0), Vec3::UnitX()))});
  run.bodies.push_back(tool);
  run.curves = {{"force_N_z", {0, 0.5, 1}}};
  return run;
}

#ifdef PALPATE_READ_GLTF
json readBack(const std::string& path) {
  FILE* pipe = ::popen((std::string("'") + PALPATE_READ_GLTF + "' '" + path + "' 2>&1").c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string output;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
  const int status = ::pclose(pipe);
  INFO(output.substr(0, 2000));
  REQUIRE(status == 0);
  return json::parse(output);
}

double away(const json& a, const Vec3& b) {
  return (Vec3(a[0].get<double>(), a[1].get<double>(), a[2].get<double>()) - b).norm();
}
#endif

}  // namespace

TEST_CASE("Assimp finds a run's surface at each moment, and its tool, in a glTF file", "[io][gltf]") {
#ifndef PALPATE_READ_GLTF
  WARN("not tried: assimp is not installed (libassimp-dev; tools/setup installs it)");
#else
  const TempFolder folder;
  const GltfRun run = pressedTetrahedron();
  for (const char* name : {"run.gltf", "run.glb"}) {
    CAPTURE(name);
    writeGltf(folder.path(name), run);
    const json read = readBack(folder.path(name));
    CHECK(away(read["up"], Vec3(0, 1, 0)) < 1e-6);  // single precision
    REQUIRE(read["meshes"].size() == 2);
    const json& tissue = read["meshes"][0];
    CHECK(tissue["triangles"] == json(run.surface.rest.triangles));
    REQUIRE(tissue["targets"].size() == 3);
    REQUIRE(read["morphs"].size() == 3);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::abs(read["morphs"][k]["time"].get<double>() - run.time_s[k]) < 1e-7);
      for (std::size_t t = 0; t < 3; ++t) CHECK(read["morphs"][k]["weights"][t] == (t == k ? 1.0 : 0.0));
      for (std::size_t v = 0; v < 4; ++v)
        CHECK(away(tissue["targets"][k][v], run.surface.frames[k][v].cast<double>()) < 1e-8);
      const json& motion = read["motion"][k];
      CHECK(away(motion["position"], run.bodies[0].poses[k].position) < 1e-7);
      CHECK(std::abs(motion["turn"][0].get<double>() - run.bodies[0].poses[k].orientation.x()) < 1e-6);
    }
    // The face opposite to the origin's edge, as pressed: a corner's normal is the sum of its faces'.
    const auto& x = run.surface.frames[2];
    const Vec3f sum =
        (x[2] - x[0]).cross(x[1] - x[0]) + (x[1] - x[0]).cross(x[3] - x[0]) + (x[3] - x[0]).cross(x[2] - x[0]);
    CHECK(away(tissue["target_normals"][2][0], sum.normalized().cast<double>()) < 1e-6);
  }
#endif
}

TEST_CASE("A run that does not fit together leaves the glTF file as it was", "[io][gltf]") {
  const TempFolder folder;
  const std::string path = folder.write("run.gltf", "before");
  const auto refused = [&](const auto& spoil) {
    GltfRun run = pressedTetrahedron();
    spoil(run);
    CHECK_THROWS_AS(writeGltf(path, run), std::invalid_argument);
    CHECK(readWholeFile(path) == "before");
  };
  refused([](GltfRun& run) { run.time_s.clear(); });
  refused([](GltfRun& run) { run.time_s[2] = run.time_s[1]; });
  refused([](GltfRun& run) { run.surface.frames.pop_back(); });
  refused([](GltfRun& run) { run.surface.frames[1].pop_back(); });
  refused([](GltfRun& run) { run.surface.frames[1][0].x() = std::numeric_limits<float>::quiet_NaN(); });
  refused([](GltfRun& run) { run.surface.rest.triangles[0][0] = 4; });
  refused([](GltfRun& run) { run.bodies[0].poses.pop_back(); });
  refused([](GltfRun& run) { run.bodies[0].surface.triangles.clear(); });
  refused([](GltfRun& run) { run.curves[0].second.push_back(0); });
  CHECK_THROWS_AS(writeGltf(folder.path("none/run.glb"), pressedTetrahedron()), std::runtime_error);
}
