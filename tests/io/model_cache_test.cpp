#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>

#include "io/load_model.h"
#include "io/model_cache.h"
#include "io/preparation_file.h"
#include "simulation/model_hash.h"
#include "simulation/step.h"
#include "simulation/workspace.h"
#include "support/equal_models.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
namespace fs = std::filesystem;

namespace {

void replaceBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

std::size_t fileCount(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string keyOf(const Scene& scene) { return preparationKey(scene, organSurface(scene)); }

/// A cache in its own folder that remembers what it was told of.
struct OwnCache {
  TempFolder folder;
  std::vector<std::string> told;
  ModelCache cache{folder.path("cache"), [this](const std::string& line) { told.push_back(line); }};

  /// Whether loadModel had to make the preparation; the model is left in `model`.
  bool made(const Scene& scene) {
    bool prepared = false;
    model = loadModel(
        scene, [&](const std::string& what, double) { prepared = prepared || what == "shape functions"; }, cache);
    return prepared;
  }
  Model model;
};

std::uint64_t hashAfterTicks(const Model& model, int ticks) {
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tool_target = test::toolAt(model, model.first_contact_travel + 0.003);
  for (int k = 0; k < ticks; ++k) tick(model, state, command, workspace);
  return stateHash(model, state);
}

}  // namespace

TEST_CASE("A model from the cache has the bits of one that was built", "[model_cache]") {
  Scene scene = test::blockScene();
  SECTION("as it is") {}
  SECTION("with tractions over facets and a second material") {
    scene.boundary_method = Scene::BoundaryMethod::Ebciem;
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].young = 9000;
    scene.materials[1].everywhere = false;
    scene.materials[1].region.normal = -Vec3::UnitX();
  }
  SECTION("plain") { scene.consistent_gradients = scene.node_patch_volume = false; }
  const Model built = buildModel(scene, organSurface(scene));
  OwnCache own;
  REQUIRE(own.made(scene));
  test::requireSameModel(own.model, built);
  REQUIRE_FALSE(own.made(scene));
  test::requireSameModel(own.model, built);
  CHECK(hashAfterTicks(own.model, 5) == hashAfterTicks(built, 5));
  CHECK(own.told.empty());
  CHECK(fileCount(own.folder.path("cache")) == 1);
}

TEST_CASE("What may change without a new set-up is taken from the scene, not from the cache", "[model_cache]") {
  OwnCache own;
  Scene scene = test::blockScene();
  REQUIRE(own.made(scene));
  scene.name = "another";
  scene.rate_hz = 250;
  scene.damping = 5;
  scene.friction = 0.3;
  scene.tool_position.x() = 0.004;
  scene.step_safety = 0.3;
  scene.camera_distance = 1;
  CHECK_FALSE(own.made(scene));
  test::requireSameModel(own.model, buildModel(scene, organSurface(scene)));
  CHECK(own.model.scene.name == "another");
  scene.tool_position.z() = 0.02;  // and is still checked
  CHECK_THROWS_WITH(own.made(scene), Catch::Contains("inside the organ"));
}

TEST_CASE("The key changes with all that a set-up depends on, and with nothing else", "[model_cache]") {
  Scene plain = test::blockScene();
  plain.refine.push_back({Vec3(0, 0, 0.03), 0.01, 0.008, 0, {}});
  plain.boundaries[0].curve = {LoadCurve::Kind::Table, {0, 1}, {0, 1}};
  const std::string key = keyOf(plain);
  CHECK(keyOf(plain) == key);
  const std::function<void(Scene&)> relevant[] = {
      [](Scene& s) { s.size.x() = 0.061; },
      [](Scene& s) { s.spacing = 0.0121; },
      [](Scene& s) { s.seed = 2; },
      [](Scene& s) { s.quadrature.points_per_cell = 4; },
      [](Scene& s) { s.quadrature.cells_per_point = 1.5; },
      [](Scene& s) { s.quadrature.accuracy = 0.1; },
      [](Scene& s) { s.quadrature.division = 4; },
      [](Scene& s) { s.quadrature.max_depth = 2; },
      [](Scene& s) { s.basis_degree = 1; },
      [](Scene& s) { s.support_factor = 1.9; },
      [](Scene& s) { s.mmls_weight = 0.1; },
      [](Scene& s) { s.consistent_gradients = false; },
      [](Scene& s) { s.node_patch_volume = false; },
      [](Scene& s) { s.boundary_method = Scene::BoundaryMethod::Ebciem; },
      [](Scene& s) { s.refine[0].centre.x() = 1e-3; },
      [](Scene& s) { s.refine[0].radius = 0.011; },
      [](Scene& s) { s.refine[0].spacing = 0.009; },
      [](Scene& s) { s.refine[0].blend = 0.02; },
      [](Scene& s) { s.refine.clear(); },
      [](Scene& s) { s.materials[0].kind = MaterialSpec::Kind::Ogden; },
      [](Scene& s) { s.materials[0].young = 3001; },
      [](Scene& s) { s.materials[0].poisson = 0.47; },
      [](Scene& s) { s.materials[0].density = 1001; },
      [](Scene& s) { s.materials[0].ogden_mu = {1}; },
      [](Scene& s) { s.materials[0].ogden_alpha = {1}; },
      [](Scene& s) { s.materials[0].ogden_D1 = 1; },
      [](Scene& s) { s.materials[0].barrier_strength = 1; },
      [](Scene& s) { s.materials[0].barrier_J0 = 0.4; },
      [](Scene& s) { s.materials[0].everywhere = false; },
      [](Scene& s) { s.materials[0].region.radius = 1; },
      [](Scene& s) { s.materials.push_back(s.materials[0]); },
      [](Scene& s) { s.boundaries[0].region.kind = Region::Kind::Shell; },
      [](Scene& s) { s.boundaries[0].region.point.z() = 0.001; },
      [](Scene& s) { s.boundaries[0].region.normal = Vec3::UnitX(); },
      [](Scene& s) { s.boundaries[0].region.min.x() = 1; },
      [](Scene& s) { s.boundaries[0].region.max.x() = 1; },
      [](Scene& s) { s.boundaries[0].region.height = 1; },
      [](Scene& s) { s.boundaries[0].region.distance = 2e-6; },
      [](Scene& s) { s.boundaries[0].component[1] = false; },
      [](Scene& s) { s.boundaries[0].surface_only = true; },
      [](Scene& s) { s.boundaries[0].translation.x() = 1e-3; },
      [](Scene& s) { s.boundaries[0].angle = 0.1; },
      [](Scene& s) { s.boundaries[0].axis = Vec3::UnitX(); },
      [](Scene& s) { s.boundaries[0].axis_point.x() = 1; },
      [](Scene& s) { s.boundaries[0].duration = 2; },
      [](Scene& s) { s.boundaries[0].curve.kind = LoadCurve::Kind::Linear; },
      [](Scene& s) { s.boundaries[0].curve.time[1] = 2; },
      [](Scene& s) { s.boundaries[0].curve.fraction[1] = 0.5; },
      [](Scene& s) { s.tool.radius = 0.011; },
  };
  std::vector<std::string> keys{key};
  for (std::size_t k = 0; k < std::size(relevant); ++k) {
    INFO("setting " << k);
    Scene scene = plain;
    relevant[k](scene);
    const std::string other = preparationKey(scene, organSurface(k == 0 ? scene : plain));
    CHECK(std::find(keys.begin(), keys.end(), other) == keys.end());
    CHECK(hashOf(other) != hashOf(key));
    keys.push_back(other);
  }
  TriangleSurface surface = organSurface(plain);
  surface.vertices[3].y() = std::nextafter(surface.vertices[3].y(), 1.0);
  CHECK(preparationKey(plain, surface) != key);
  surface = organSurface(plain);
  std::swap(surface.triangles[0], surface.triangles[1]);
  CHECK(preparationKey(plain, surface) != key);

  const std::function<void(Scene&)> irrelevant[] = {
      [](Scene& s) { s.name = "x"; },
      [](Scene& s) { s.camera_target.x() = 1; },
      [](Scene& s) { s.camera_azimuth_deg = 1; },
      [](Scene& s) { s.tissue_colour.x() = 1; },
      [](Scene& s) { s.place.file = "elsewhere.toml"; },
      [](Scene& s) { s.boundaries[0].name = "base"; },
      [](Scene& s) { s.rate_hz = 1000; },
      [](Scene& s) { s.damping = 1; },
      [](Scene& s) { s.threads = 2; },
      [](Scene& s) { s.solve.tolerance = 1e-5; },
      [](Scene& s) { s.friction = 1; },
  };
  for (const auto& change : irrelevant) {
    Scene scene = plain;
    change(scene);
    CHECK(keyOf(scene) == key);
  }
}

TEST_CASE("A damaged file is never trusted: it is told of, made again and replaced", "[model_cache]") {
  OwnCache own;
  const Scene scene = test::blockScene(0.02);
  REQUIRE(own.made(scene));
  const std::string key = keyOf(scene), path = own.cache.fileOf(key), sound = readAll(path);
  REQUIRE(sound.size() > 10000);

  const auto refuses = [&](const std::string& bytes) {
    replaceBytes(path, bytes);
    own.told.clear();
    return !own.cache.find(key) && own.told.size() == 1 && own.told[0].find("damaged") != std::string::npos;
  };
  std::mt19937 random(7);
  for (int k = 0; k < 300; ++k) {  // one bit anywhere; the first 600 bytes are the header
    const std::size_t at = random() % (k % 3 == 0 ? 600 : sound.size());
    std::string bytes = sound;
    bytes[at] = static_cast<char>(bytes[at] ^ (1u << random() % 8));
    INFO("byte " << at);
    REQUIRE(refuses(bytes));
  }
  for (int k = 0; k < 60; ++k) REQUIRE(refuses(sound.substr(0, random() % sound.size())));
  CHECK(refuses(""));
  CHECK(refuses(sound + "x"));
  CHECK(refuses(std::string(sound.size(), '\0')));
  CHECK(refuses("not a set-up at all"));
  std::string newer = sound;
  newer[8] = 99;  // the layout's version
  CHECK(refuses(newer));

  own.told.clear();
  CHECK(own.made(scene));
  CHECK(own.told.size() == 1);
  CHECK(readAll(path) == sound);
  CHECK_FALSE(own.made(scene));
}

TEST_CASE("Another scene's file under this scene's name is refused", "[model_cache]") {
  OwnCache own;
  Scene scene = test::blockScene(0.02), other = scene;
  other.seed = 2;
  REQUIRE(own.made(scene));
  REQUIRE(own.made(other));
  replaceBytes(own.cache.fileOf(keyOf(scene)), readAll(own.cache.fileOf(keyOf(other))));
  CHECK_FALSE(own.cache.find(keyOf(scene)));
  CHECK(own.made(scene));
}

TEST_CASE("Without a folder that can be written, models are built and one line says why", "[model_cache]") {
  TempFolder folder;
  const Scene scene = test::blockScene(0.02);
  std::vector<std::string> told;
  const auto tell = [&](const std::string& line) { told.push_back(line); };
  const ModelCache under_a_file(folder.write("file", "x") + "/cache", tell);
  const Model built = buildModel(scene, organSurface(scene));
  test::requireSameModel(loadModel(scene, {}, under_a_file), built);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Catch::Contains("not kept") && Catch::Contains("can't write"));
  told.clear();
  test::requireSameModel(loadModel(scene, {}, ModelCache("", tell)), built);
  CHECK(told.empty());
}

TEST_CASE("Beyond its bound the cache drops what was not used for longest", "[model_cache]") {
  TempFolder folder;
  Scene scene = test::blockScene(0.02);
  const ModelCache roomy(folder.path("cache"));
  std::vector<std::string> files;
  std::uintmax_t size = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    scene.seed = seed;
    loadModel(scene, {}, roomy);
    files.push_back(roomy.fileOf(keyOf(scene)));
    size = std::max(size, fs::file_size(files.back()));
    fs::last_write_time(files.back(), fs::file_time_type::clock::now() - std::chrono::hours(10 - seed));
  }
  scene.seed = 1;
  REQUIRE(roomy.find(keyOf(scene)));  // used now: the second is the oldest
  const ModelCache narrow(folder.path("cache"), {}, 3 * size + size / 2);
  scene.seed = 4;
  loadModel(scene, {}, narrow);
  CHECK(fs::exists(files[0]));
  CHECK_FALSE(fs::exists(files[1]));
  CHECK(fs::exists(files[2]));
  CHECK(fs::exists(narrow.fileOf(keyOf(scene))));
}

TEST_CASE("The user's cache folder follows the environment", "[model_cache]") {
  const auto set = [](const char* name, const char* value) { value ? ::setenv(name, value, 1) : ::unsetenv(name); };
  const char* const names[] = {"PALPATE_CACHE_DIR", "XDG_CACHE_HOME", "HOME"};
  std::vector<std::optional<std::string>> before;
  for (const char* name : names)
    before.push_back(std::getenv(name) ? std::optional<std::string>(std::getenv(name)) : std::nullopt);
  set("PALPATE_CACHE_DIR", "/a");
  set("XDG_CACHE_HOME", "/b");
  set("HOME", "/c");
  CHECK(ModelCache::userFolder() == "/a");
  set("PALPATE_CACHE_DIR", nullptr);
  CHECK(ModelCache::userFolder() == "/b/palpate");
  set("XDG_CACHE_HOME", "not absolute");
  CHECK(ModelCache::userFolder() == "/c/.cache/palpate");
  set("HOME", nullptr);
  CHECK(ModelCache::userFolder().empty());
  for (std::size_t k = 0; k < std::size(names); ++k) set(names[k], before[k] ? before[k]->c_str() : nullptr);
}
