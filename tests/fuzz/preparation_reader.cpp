#include <algorithm>
#include <cstring>

#include "base/input_error.h"
#include "fuzz/memory_file.h"
#include "fuzz/reader.h"
#include "io/preparation_file.h"

namespace palpate::fuzz {

namespace {

/// An input is a list of these, which forge a small preparation. Its file then has checksums that hold: damaged bytes
/// of a file would hardly pass them.
struct Forgery {
  std::uint8_t array = 0, action = 0;  // action 0: sets an entry; 1: makes the array so long
  std::uint16_t entry = 0;
  std::int32_t value = 0;
};
static_assert(sizeof(Forgery) == 8);

/// A tetrahedron with one integration point and a skin, held at a node.
Preparation tetrahedron() {
  Preparation p;
  p.X = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  p.support_radius = {2, 2, 2, 2};
  p.mass = {1, 1, 1, 1};
  p.own_mass = {1, 1, 1, 1};
  p.cloud = {p.X, {1, 1, 1, 0}, {1, 1, 1, 2}};
  p.cells = {{0, 1, 2, 3}};
  p.point_X = {Vec3::Constant(0.25)};
  p.point_volume = {1.0 / 6};
  p.point_material = p.point_cell = {0};
  const auto row = [](int rows) {
    ShapeTable table;
    table.begin = {0};
    for (int r = 0; r < rows; ++r) {
      table.begin.push_back(4 * (r + 1));
      table.node.insert(table.node.end(), {0, 1, 2, 3});
      table.N.insert(table.N.end(), {0.25, 0.25, 0.25, 0.25});
      for (const Vec3& x : {Vec3(-1, -1, -1), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) table.gradN.push_back(x);
    }
    return table;
  };
  p.point_shape = row(1);
  p.node_shape = row(4);
  p.node_shape.gradN.clear();
  setRows(p.node_shape, p.skin);
  p.skin.surface = {p.X, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  p.essential.nodes = {{0, {0, 0, 0}}};
  p.end_node = {4};
  p.end_point = {1};
  p.limit = {1e-3, 5e-4, 0, 1};
  p.surface_volume = p.cell_volume = 1.0 / 6;
  return p;
}

template <class T>
void forge(std::vector<T>& array, const Forgery& forgery) {
  static_assert(sizeof(T) % sizeof(int) == 0);
  constexpr std::size_t wide = sizeof(T) / sizeof(int);
  if (forgery.action % 2 == 1) array.resize(static_cast<std::uint32_t>(forgery.value) % 64);
  const std::size_t entry = forgery.entry % std::max<std::size_t>(array.size() * wide, 1);
  if (forgery.action % 2 == 0 && !array.empty())
    std::memcpy(reinterpret_cast<char*>(array.data()) + entry * sizeof(int), &forgery.value, sizeof(int));
}

void forge(Preparation& p, const Forgery& forgery) {
  switch (forgery.array % 19) {
    case 0:
      return forge(p.cells, forgery);
    case 1:
      return forge(p.skin.surface.triangles, forgery);
    case 2:
      return forge(p.point_material, forgery);
    case 3:
      return forge(p.point_cell, forgery);
    case 4:
      return forge(p.point_other_cell, forgery);
    case 5:
      return forge(p.essential.nodes, forgery);
    case 6:
      return forge(p.essential.facets, forgery);
    case 7:
      return forge(p.essential.facet_weight, forgery);
    case 8:
      return forge(p.point_shape.begin, forgery);
    case 9:
      return forge(p.point_shape.node, forgery);
    case 10:
      return forge(p.skin.begin, forgery);
    case 11:
      return forge(p.skin.node, forgery);
    case 12:
      return forge(p.essential.facet_phi.begin, forgery);
    case 13:
      return forge(p.mass, forgery);
    case 14:
      return forge(p.own_mass, forgery);
    case 15:
      return forge(p.cloud.X, forgery);
    case 16:
      return forge(p.end_node, forgery);
    case 17:
      return forge(p.end_point, forgery);
    default:
      return forge(p.cloud.coarsest, forgery);
  }
}

std::vector<std::string> preparationSeeds() {
  const Forgery material{2, 0, 0, 0}, cell{0, 0, 1, 1}, skin{1, 0, 4, 1}, none{4, 1, 0, 0};
  std::vector<std::string> seeds{""};
  for (const Forgery& forgery : {material, cell, skin, none})
    seeds.push_back(seeds.back() + std::string(reinterpret_cast<const char*>(&forgery), sizeof forgery));
  return seeds;
}

template <std::size_t n>
void holdIndices(const std::vector<std::array<int, n>>& rows, std::size_t count, const char* what) {
  for (const auto& row : rows)
    hold(std::all_of(row.begin(), row.end(), [&](int i) { return i >= 0 && static_cast<std::size_t>(i) < count; }),
         what);
}

void readPreparationFrom(const std::string& bytes) {
  static const MemoryFile file;
  Preparation forged = tetrahedron();
  for (std::size_t at = 0; at + sizeof(Forgery) <= std::min<std::size_t>(bytes.size(), 4096); at += sizeof(Forgery)) {
    Forgery forgery;
    std::memcpy(&forgery, bytes.data() + at, sizeof forgery);
    forge(forged, forgery);
  }
  const KeyHash key = hashOf("fuzz");
  file.write("");
  ::lseek(file.descriptor(), 0, SEEK_SET);
  hold(writePreparation(file.descriptor(), key, forged) == 0, "it can't be written");
  Preparation p;
  constexpr std::size_t materials = 1, boundaries = 1;
  if (!readPreparation(file.descriptor(), key, p) || !isSound(p, materials, boundaries))
    throw InputError({}, "refused", "");
  holdIndices(p.cells, p.X.size(), "a cell has a node that is not there");
  holdIndices(p.skin.surface.triangles, p.skin.surface.vertices.size(), "a face has a vertex that is not there");
  for (const int m : p.point_material) hold(m == 0, "a point has a material that is not there");
  for (const int c : p.point_cell)
    hold(c >= 0 && static_cast<std::size_t>(c) < p.cells.size(), "a point lies in a cell that is not there");
  for (const ImposedNode& imposed : p.essential.nodes)
    hold(imposed.node >= 0 && static_cast<std::size_t>(imposed.node) < p.X.size(), "an imposed node is not there");
}

}  // namespace

const Reader preparation_reader = {"preparation", preparationSeeds, readPreparationFrom};

}  // namespace palpate::fuzz
