#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>

#include "io/load_model.h"
#include "io/model_cache.h"
#include "io/preparation_file.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "setup/imposed_nodes.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/block_text.h"
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

std::optional<Preparation> found(const ModelCache& cache, const std::string& key, const Scene& scene) {
  return cache.find(key, scene.materials.size(), scene.boundaries.size());
}

/// A scene that can be kept: made by program, it says itself what its preparation depends on.
Scene keptScene(const std::string& what, double spacing = 0.012) {
  Scene scene = test::blockScene(spacing);
  scene.set_up_values = what;
  return scene;
}

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
  const double deep = model.tools.first().first_contact_travel + 0.003;
  test::moveAlong(model, state, workspace, ticks, [&](int) { return deep; });
  return stateHash(model, state);
}

}  // namespace

TEST_CASE("A model from the cache has the bits of one that was built", "[model_cache]") {
  Scene scene = keptScene("this");
  SECTION("as it is") {}
  SECTION("with tractions over facets and a second material") {
    scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].material.set("young", 9000);
    scene.materials[1].everywhere = false;
    scene.materials[1].region.normal = -Vec3::UnitX();
  }
  SECTION("plain") { scene.discretization.formulation = Formulation::paper(); }
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
  Scene scene = keptScene("this");
  REQUIRE(own.made(scene));
  scene.name = "another";
  scene.dynamics.rate_hz = 250;
  scene.dynamics.damping = 5;
  scene.tools[0].friction = 0.3;
  scene.tools[0].position.x() = 0.004;
  scene.dynamics.step_safety = 0.3;
  scene.camera.distance = 1;
  CHECK_FALSE(own.made(scene));
  test::requireSameModel(own.model, buildModel(scene, organSurface(scene)));
  CHECK(own.model.scene.name == "another");
  scene.tools[0].position.z() = 0.02;  // and is still checked
  CHECK_THROWS_WITH(own.made(scene), Catch::Contains("inside the organ"));
}

TEST_CASE("The key has the organ's surface and the scene's values", "[model_cache]") {
  const Scene plain = keptScene("a");
  const std::string key = keyOf(plain);
  CHECK(keyOf(plain) == key);
  CHECK(keyOf(keptScene("b")) != key);
  CHECK(hashOf(keyOf(keptScene("b"))) != hashOf(key));
  TriangleSurface surface = organSurface(plain);
  surface.vertices[3].y() = std::nextafter(surface.vertices[3].y(), 1.0);
  CHECK(preparationKey(plain, surface) != key);
  surface = organSurface(plain);
  std::swap(surface.triangles[0], surface.triangles[1]);
  CHECK(preparationKey(plain, surface) != key);
}

TEST_CASE("A set-up is another's where the tissue relaxes: that moves the stable step", "[model_cache]") {
  const TempFolder folder;
  const std::string elastic = replaced(test::touched_block_text, "poisson = 0.45", "poisson = 0.49"),
                    relaxing = replaced(elastic, "poisson = 0.49", "poisson = 0.49\nrelaxation = [[0.5, 0.1]]");
  const Scene a = readScene(folder.write("a.toml", elastic)), b = readScene(folder.write("b.toml", relaxing));
  CHECK(keyOf(a) != keyOf(b));
}

TEST_CASE("A scene that no file was read for is not kept", "[model_cache]") {
  OwnCache own;
  const Scene scene = test::blockScene(0.02);
  REQUIRE(scene.set_up_values.empty());
  CHECK(own.made(scene));
  CHECK(own.made(scene));
  CHECK_FALSE(fs::exists(own.folder.path("cache")));
}

TEST_CASE("A damaged file is never trusted: it is told of, made again and replaced", "[model_cache]") {
  OwnCache own;
  const Scene scene = keptScene("this", 0.02);
  REQUIRE(own.made(scene));
  const std::string key = keyOf(scene), path = own.cache.fileOf(key), sound = readAll(path);
  REQUIRE(sound.size() > 10000);

  const auto refuses = [&](const std::string& bytes) {
    replaceBytes(path, bytes);
    own.told.clear();
    return !found(own.cache, key, scene) && own.told.size() == 1 && own.told[0].find("damaged") != std::string::npos;
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

TEST_CASE("A forged file whose checksums hold is refused for every size, index and number that is wrong",
          "[model_cache]") {
  Scene scene = keptScene("this", 0.02);
  scene.discretization.quadrature.cells_per_point = 1.3;  // so that no array is empty
  scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].everywhere = false;
  scene.materials[1].region.normal = -Vec3::UnitX();
  OwnCache own;
  REQUIRE(own.made(scene));
  const std::string key = keyOf(scene);
  const std::optional<Preparation> sound = found(own.cache, key, scene);
  REQUIRE(sound);
  REQUIRE_FALSE(sound->point_other_cell.empty());
  REQUIRE_FALSE(sound->essential.facets.empty());

  using P = Preparation;
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const int nodes = sound->nodeCount(), vertices = static_cast<int>(sound->skin.surface.vertices.size()),
            cells = static_cast<int>(sound->cells.size());
  const std::pair<const char*, std::function<void(P&)>> forgeries[] = {
      {"a cell's node too high", [&](P& p) { p.cells[3][2] = nodes; }},
      {"a cell's node negative", [&](P& p) { p.cells.back()[0] = -1; }},
      {"no cells", [&](P& p) { p.cells.clear(); }},
      {"a skin corner too high", [&](P& p) { p.skin.surface.triangles[1][0] = vertices; }},
      {"a skin corner negative", [&](P& p) { p.skin.surface.triangles[1][0] = -7; }},
      {"a skin vertex missing", [&](P& p) { p.skin.surface.vertices.pop_back(); }},
      {"a skin vertex not finite", [&](P& p) { p.skin.surface.vertices[0].x() = nan; }},
      {"a material too high", [&](P& p) { p.point_material[5] = 2; }},
      {"a material negative", [&](P& p) { p.point_material[5] = -1; }},
      {"a material missing", [&](P& p) { p.point_material.pop_back(); }},
      {"a point's cell too high", [&](P& p) { p.point_cell[0] = cells; }},
      {"a point's cell negative", [&](P& p) { p.point_cell[0] = -1; }},
      {"a point's second cell too high", [&](P& p) { p.point_other_cell[0] = cells; }},
      {"a point's second cell below none", [&](P& p) { p.point_other_cell[0] = -2; }},
      {"a second cell missing", [&](P& p) { p.point_other_cell.pop_back(); }},
      {"an imposed node too high", [&](P& p) { p.essential.nodes[0].node = nodes; }},
      {"an imposed node negative", [&](P& p) { p.essential.nodes[0].node = -2; }},
      {"an imposed node twice", [&](P& p) { p.essential.nodes[1].node = p.essential.nodes[0].node; }},
      {"a boundary too high", [&](P& p) { p.essential.nodes[0].boundary[1] = 1; }},
      {"a boundary below none", [&](P& p) { p.essential.nodes[0].boundary[1] = -2; }},
      {"a facet's node too high", [&](P& p) { p.essential.facets[0][0] = nodes; }},
      {"a facet's node negative", [&](P& p) { p.essential.facets[0][0] = -1; }},
      {"a facet at a free node",
       [&](P& p) {
         const auto imposed = imposedComponents(p.essential.nodes, p.X.size());
         p.essential.facets[0][0] = static_cast<int>(std::find(imposed.begin(), imposed.end(), 0) - imposed.begin());
       }},
      {"a facet too many", [&](P& p) { p.essential.facets.push_back(p.essential.facets[0]); }},
      {"a facet's weight missing", [&](P& p) { p.essential.facet_weight.pop_back(); }},
      {"a facet's weight not finite", [&](P& p) { p.essential.facet_weight[0].z() = infinite; }},
      {"a facet's support node too high", [&](P& p) { p.essential.facet_phi.node.back() = nodes; }},
      {"a support node negative", [&](P& p) { p.point_shape.node[0] = -1; }},
      {"a support node twice", [&](P& p) { p.point_shape.node[1] = p.point_shape.node[0]; }},
      {"rows out of order", [&](P& p) { std::swap(p.point_shape.begin[1], p.point_shape.begin[2]); }},
      {"rows beyond the entries", [&](P& p) { ++p.skin.begin.back(); }},
      {"a row missing", [&](P& p) { p.node_shape.begin.pop_back(); }},
      {"a shape value missing", [&](P& p) { p.node_shape.N.pop_back(); }},
      {"a shape value not finite", [&](P& p) { p.node_shape.N[0] = nan; }},
      {"a gradient missing", [&](P& p) { p.point_shape.gradN.pop_back(); }},
      {"a gradient not finite", [&](P& p) { p.point_shape.gradN[2].y() = nan; }},
      {"a node too many", [&](P& p) { p.X.push_back(p.X[0]); }},
      {"a node not finite", [&](P& p) { p.X[1].x() = infinite; }},
      {"a mass missing", [&](P& p) { p.mass.pop_back(); }},
      {"a mass of zero", [&](P& p) { p.mass[0] = 0; }},
      {"a radius negative", [&](P& p) { p.support_radius[0] = -1; }},
      {"a point not finite", [&](P& p) { p.point_X[0].z() = nan; }},
      {"a volume missing", [&](P& p) { p.point_volume.pop_back(); }},
      {"a volume not finite", [&](P& p) { p.point_volume[0] = nan; }},
      {"no points", [&](P& p) { p.point_X.clear(); }},
      {"no step", [&](P& p) { p.limit.dt = 0; }},
      {"a step that is not finite", [&](P& p) { p.limit.dt = nan; }},
      {"the stiffest row too high", [&](P& p) { p.limit.worst_node = nodes; }},
      {"the stiffest row negative", [&](P& p) { p.limit.worst_node = -1; }},
      {"no volume", [&](P& p) { p.cell_volume = 0; }},
      {"own mass not finite", [&](P& p) { p.own_mass[0] = infinite; }},
  };
  for (const auto& [name, forge] : forgeries) {
    INFO(name);
    Preparation forged = *sound;
    forge(forged);
    own.cache.keep(key, forged);
    own.told.clear();
    CHECK_FALSE(found(own.cache, key, scene));
    REQUIRE(own.told.size() == 1);
    CHECK_THAT(own.told[0], Catch::Contains("damaged"));
  }
  // The same file is sound for its own scene only: one with fewer materials or boundaries can't be meant.
  own.cache.keep(key, *sound);
  CHECK(own.cache.find(key, 2, 1));
  CHECK_FALSE(own.cache.find(key, 1, 1));
  CHECK_FALSE(own.cache.find(key, 2, 0));
  CHECK_FALSE(own.made(scene));
}

TEST_CASE("Another scene's file under this scene's name is refused", "[model_cache]") {
  OwnCache own;
  Scene scene = keptScene("seed 1", 0.02), other = scene;
  other.discretization.seed = 2;
  other.set_up_values = "seed 2";
  REQUIRE(own.made(scene));
  REQUIRE(own.made(other));
  replaceBytes(own.cache.fileOf(keyOf(scene)), readAll(own.cache.fileOf(keyOf(other))));
  CHECK_FALSE(found(own.cache, keyOf(scene), scene));
  CHECK(own.made(scene));
}

TEST_CASE("Without a folder that can be written, models are built and one line says why", "[model_cache]") {
  TempFolder folder;
  const Scene scene = keptScene("this", 0.02);
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
  Scene scene = keptScene("this", 0.02);
  const ModelCache roomy(folder.path("cache"));
  std::vector<std::string> files;
  std::uintmax_t size = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    scene.discretization.seed = seed;
    scene.set_up_values = "seed " + std::to_string(seed);
    loadModel(scene, {}, roomy);
    files.push_back(roomy.fileOf(keyOf(scene)));
    size = std::max(size, fs::file_size(files.back()));
    fs::last_write_time(files.back(), fs::file_time_type::clock::now() - std::chrono::hours(10 - seed));
  }
  scene.set_up_values = "seed 1";
  REQUIRE(found(roomy, keyOf(scene), scene));  // used now: the second is the oldest
  const ModelCache narrow(folder.path("cache"), {}, 3 * size + size / 2);
  scene.discretization.seed = 4;
  scene.set_up_values = "seed 4";
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
