#include "io/gltf_file.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/build_info.h"
#include "io/base64.h"
#include "io/output_file.h"

namespace palpate {

namespace {

using Gltf = nlohmann::json;  // any part of the file

static_assert(std::endian::native == std::endian::little, "the arrays are written as they lie in memory");

// Of the glTF 2.0 specification, sections 3.6.2 and 3.7.2.
constexpr int float_type = 5126, index_type = 5125;  // 32 bits each
constexpr int vertex_buffer = 34962, index_buffer = 34963;
constexpr std::uint32_t glb_magic = 0x46546C67, glb_json = 0x4E4F534A, glb_bytes = 0x004E4942;
constexpr double shine = 0.35, steel = 0.9;  // roughness of the tissue, metalness of tools

void require(bool holds, const std::string& problem) {
  if (!holds) throw std::invalid_argument("glTF: " + problem);
}

/// The file's JSON and its one buffer, which grow together.
class Document {
 public:
  Gltf root;
  std::string bytes;

  /// @param values  (count, components); min and max are given where `bounded`
  int addFloats(std::span<const float> values, int components, const char* type, bool bounded, int target = 0) {
    Gltf accessor{
        {"componentType", float_type}, {"count", values.size() / static_cast<std::size_t>(components)}, {"type", type}};
    for (const float value : values) require(std::isfinite(value), "a number is not finite");
    if (bounded) {
      const auto width = static_cast<std::size_t>(components);
      std::vector<float> low(values.begin(), values.begin() + components), high = low;
      for (std::size_t k = 0; k < values.size(); ++k) {
        low[k % width] = std::min(low[k % width], values[k]);
        high[k % width] = std::max(high[k % width], values[k]);
      }
      accessor["min"] = low;
      accessor["max"] = high;
    }
    return add(accessor, values.data(), values.size_bytes(), target);
  }
  int addVectors(const std::vector<Vec3f>& values, bool bounded) {
    return addFloats({values.front().data(), 3 * values.size()}, 3, "VEC3", bounded, vertex_buffer);
  }
  int addTriangles(const std::vector<std::array<int, 3>>& triangles) {
    Gltf accessor{{"componentType", index_type}, {"count", 3 * triangles.size()}, {"type", "SCALAR"}};
    return add(accessor, triangles.data(), triangles.size() * sizeof triangles[0], index_buffer);
  }

 private:
  int add(Gltf& accessor, const void* data, std::size_t size, int target) {
    Gltf view{{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    root["bufferViews"].push_back(view);
    bytes.append(static_cast<const char*>(data), size);
    accessor["bufferView"] = root["bufferViews"].size() - 1;
    root["accessors"].push_back(accessor);
    return static_cast<int>(root["accessors"].size()) - 1;
  }
};

void check(const TriangleSurface& surface, const std::string& name) {
  require(!surface.vertices.empty() && !surface.triangles.empty(), "there is nothing of " + name);
  for (const auto& triangle : surface.triangles)
    for (const int corner : triangle)
      require(corner >= 0 && static_cast<std::size_t>(corner) < surface.vertices.size(),
              "a triangle of " + name + " names vertex " + std::to_string(corner));
}

void check(const GltfRun& run) {
  const std::size_t count = run.time_s.size();
  require(count > 0, "a run without frames");
  for (std::size_t k = 1; k < count; ++k) require(run.time_s[k] > run.time_s[k - 1], "times do not ascend");
  check(run.surface.rest, run.surface.name);
  require(run.surface.frames.size() == count, "frames and times differ in number");
  for (const auto& frame : run.surface.frames)
    require(frame.size() == run.surface.rest.vertices.size(), "a frame has another number of vertices");
  for (const GltfBody& body : run.bodies) {
    check(body.surface, body.name);
    require(body.poses.size() == count, "poses and times differ in number");
  }
  for (const auto& [name, values] : run.curves) require(values.size() == count, "the curve " + name + " has gaps");
}

std::vector<Vec3f> inFloat(const std::vector<Vec3>& values) {
  std::vector<Vec3f> result;
  for (const Vec3& value : values) result.push_back(value.cast<float>());
  return result;
}

/// Unit normals at vertices, by area (vertex_count).
std::vector<Vec3f> normals(const std::vector<Vec3f>& x, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<Vec3f> normal(x.size(), Vec3f::Zero());
  const auto at = [](int v) { return static_cast<std::size_t>(v); };
  for (const auto& [a, b, c] : triangles) {
    const Vec3f area = (x[at(b)] - x[at(a)]).cross(x[at(c)] - x[at(a)]);
    for (const int v : {a, b, c}) normal[at(v)] += area;
  }
  for (Vec3f& n : normal) n = n.isZero(0) ? Vec3f(Vec3f::UnitZ()) : Vec3f(n.stableNormalized());
  return normal;
}

std::vector<Vec3f> minus(std::vector<Vec3f> a, const std::vector<Vec3f>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return a;
}

/// Adds mesh, material and node. Returns the node's number.
int addNode(Document& document, const std::string& name, const TriangleSurface& surface, const Vec3& colour,
            double metal, const std::vector<std::vector<Vec3f>>& frames) {
  const std::vector<Vec3f> X = inFloat(surface.vertices), N = normals(X, surface.triangles);
  Gltf primitive{
      {"attributes", {{"POSITION", document.addVectors(X, true)}, {"NORMAL", document.addVectors(N, false)}}},
      {"indices", document.addTriangles(surface.triangles)}};
  for (const std::vector<Vec3f>& x : frames)
    primitive["targets"].push_back({{"POSITION", document.addVectors(minus(x, X), true)},
                                    {"NORMAL", document.addVectors(minus(normals(x, surface.triangles), N), false)}});
  Gltf& root = document.root;
  primitive["material"] = root["materials"].size();
  root["materials"].push_back({{"name", name},
                               {"pbrMetallicRoughness",
                                {{"baseColorFactor", {colour.x(), colour.y(), colour.z(), 1.0}},
                                 {"metallicFactor", metal},
                                 {"roughnessFactor", shine}}}});
  Gltf mesh{{"name", name}, {"primitives", {primitive}}};
  if (!frames.empty()) mesh["weights"] = std::vector<int>(frames.size(), 0);
  root["nodes"].push_back({{"name", name}, {"mesh", root["meshes"].size()}});
  root["meshes"].push_back(mesh);
  return static_cast<int>(root["nodes"].size()) - 1;
}

void addChannel(Gltf& animation, int node, const char* path, int times, int values) {
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
  animation["samplers"].push_back({{"input", times}, {"output", values}, {"interpolation", "LINEAR"}});
}

void addMotion(Document& document, Gltf& animation, int node, int times, const std::vector<Pose>& poses) {
  std::vector<float> places, turns;
  Quat last = Quat::Identity();
  for (const Pose& pose : poses) {
    for (const double x : pose.position) places.push_back(static_cast<float>(x));
    Quat turn = pose.orientation.normalized();
    if (turn.dot(last) < 0) turn.coeffs() = -turn.coeffs();  // the short way from frame to frame
    last = turn;
    for (const double q : turn.coeffs()) turns.push_back(static_cast<float>(q));
  }
  addChannel(animation, node, "translation", times, document.addFloats(places, 3, "VEC3", false));
  addChannel(animation, node, "rotation", times, document.addFloats(turns, 4, "VEC4", false));
}

void appendWord(std::string& text, std::size_t value) {
  if (value > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("glTF: more than 4 GB; take less time");
  const auto word = static_cast<std::uint32_t>(value);
  text.append(reinterpret_cast<const char*>(&word), sizeof word);
}

std::string binary(Document& document) {
  std::string head = document.root.dump();
  head.resize((head.size() + 3) / 4 * 4, ' ');
  std::string& bytes = document.bytes;  // of 32-bit numbers, so its length is a multiple of 4
  std::string file;
  appendWord(file, glb_magic);
  appendWord(file, 2);
  appendWord(file, 12 + 8 + head.size() + 8 + bytes.size());
  appendWord(file, head.size());
  appendWord(file, glb_json);
  file += head;
  appendWord(file, bytes.size());
  appendWord(file, glb_bytes);
  return file += bytes;
}

}  // namespace

void writeGltf(const std::string& path, const GltfRun& run) {
  check(run);
  Document document;
  Gltf& root = document.root;
  root["asset"] = {{"version", "2.0"}, {"generator", "Palpate " + programVersion()}};
  Gltf animation{{"name", "run"}};
  const std::vector<float> time(run.time_s.begin(), run.time_s.end());
  const int times = document.addFloats(time, 1, "SCALAR", true);

  Gltf children;
  const GltfSurface& surface = run.surface;
  const int tissue = addNode(document, surface.name, surface.rest, surface.colour, 0, surface.frames);
  children.push_back(tissue);
  std::vector<float> weights(time.size() * time.size(), 0);  // at frame k target k alone
  for (std::size_t k = 0; k < time.size(); ++k) weights[k * time.size() + k] = 1;
  addChannel(animation, tissue, "weights", times, document.addFloats(weights, 1, "SCALAR", false));
  for (const GltfBody& body : run.bodies) {
    const int node = addNode(document, body.name, body.surface, body.colour, steel, {});
    children.push_back(node);
    addMotion(document, animation, node, times, body.poses);
  }
  const double half = std::sqrt(0.5);
  root["nodes"].push_back({{"name", "z up"}, {"rotation", {-half, 0, 0, half}}, {"children", children}});
  Gltf extras;
  for (const auto& [name, values] : run.curves) extras[name] = values;
  Gltf scene{{"nodes", {root["nodes"].size() - 1}}};
  if (!extras.is_null()) scene["extras"] = extras;
  root["scenes"] = Gltf::array({scene});
  root["scene"] = 0;
  root["animations"] = Gltf::array({animation});
  root["buffers"] = Gltf::array({{{"byteLength", document.bytes.size()}}});
  if (path.ends_with(".glb")) return writeWholeFile(path, binary(document));
  std::string uri = "data:application/octet-stream;base64,";
  appendBase64(uri, {reinterpret_cast<const unsigned char*>(document.bytes.data()), document.bytes.size()});
  root["buffers"][0]["uri"] = uri;
  writeWholeFile(path, root.dump());
}

}  // namespace palpate
