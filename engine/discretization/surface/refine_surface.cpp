#include "discretization/surface/refine_surface.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace palpate {

namespace {

using Edge = std::pair<int, int>;  // low vertex, high vertex

Edge edgeOf(int v, int w) { return {std::min(v, w), std::max(v, w)}; }

struct EdgeHash {
  std::size_t operator()(const Edge& e) const {
    const auto key = (static_cast<std::uint64_t>(e.first) << 32) | static_cast<std::uint32_t>(e.second);
    return static_cast<std::size_t>((key ^ (key >> 29)) * 0x9E3779B97F4A7C15ull);
  }
};

/// The faces of a surface while edges are being halved.
class Splitter {
 public:
  Splitter(TriangleSurface surface, const EdgeLengthAt& longest_at, int max_triangles)
      : surface_(std::move(surface)), longest_at_(longest_at), max_triangles_(max_triangles) {
    faces_of_.reserve(2 * surface_.triangles.size());
    for (int t = 0; t < static_cast<int>(surface_.triangles.size()); ++t) {
      const auto& [a, b, c] = surface_.triangles[t];
      for (const Edge& e : {edgeOf(a, b), edgeOf(b, c), edgeOf(c, a)}) faces_of_[e].push_back(t);
    }
  }

  TriangleSurface run() {
    // Depth first from each given face; halving an edge re-examines the four faces that it leaves.
    std::vector<int> open(surface_.triangles.size());
    for (std::size_t t = 0; t < open.size(); ++t) open[t] = static_cast<int>(open.size() - 1 - t);
    while (!open.empty()) {
      const int t = open.back();
      const auto& [a, b, c] = surface_.triangles[t];
      if (tooLong(edgeOf(a, b)) || tooLong(edgeOf(b, c)) || tooLong(edgeOf(c, a))) {
        halve(terminalEdge(t), open);
      } else {
        open.pop_back();
      }
    }
    return std::move(surface_);
  }

 private:
  double squaredLength(const Edge& e) const {
    return (surface_.vertices[e.second] - surface_.vertices[e.first]).squaredNorm();
  }

  bool tooLong(const Edge& e) const {
    const Vec3 &a = surface_.vertices[e.first], &b = surface_.vertices[e.second];
    const double longest = std::min({longest_at_(a), longest_at_(b), longest_at_(0.5 * (a + b))});
    if (!(longest > 0)) throw std::invalid_argument("refineSurface: the edge length wanted is not positive");
    return squaredLength(e) > longest * longest;
  }

  /// The longest edge of a face; ties by vertex numbers, so that both faces of an edge agree.
  Edge longestEdge(int t) const {
    const auto& [a, b, c] = surface_.triangles[t];
    Edge longest = edgeOf(a, b);
    for (const Edge& e : {edgeOf(b, c), edgeOf(c, a)}) {
      if (std::pair(squaredLength(e), e) > std::pair(squaredLength(longest), longest)) longest = e;
    }
    return longest;
  }

  /// Walks from face to face across longest edges, which grow, to one that is the longest of all its faces.
  Edge terminalEdge(int t) const {
    Edge edge = longestEdge(t);
    for (;;) {
      bool terminal = true;
      for (int other : faces_of_.at(edge)) {
        const Edge longer = longestEdge(other);
        if (longer != edge) {
          edge = longer;
          terminal = false;
          break;
        }
      }
      if (terminal) return edge;
    }
  }

  void halve(const Edge& edge, std::vector<int>& open) {
    const std::vector<int> faces = std::move(faces_of_.at(edge));
    faces_of_.erase(edge);
    const int middle = static_cast<int>(surface_.vertices.size());
    surface_.vertices.push_back(0.5 * (surface_.vertices[edge.first] + surface_.vertices[edge.second]));
    for (int t : faces) {
      if (static_cast<int>(surface_.triangles.size()) >= max_triangles_) {
        throw std::length_error("refineSurface: more than " + std::to_string(max_triangles_) +
                                " faces would be needed");
      }
      // t keeps its vertex that the halved edge has first; `half` takes the other part.
      const int half = static_cast<int>(surface_.triangles.size());
      std::array<int, 3> other = surface_.triangles[t];
      std::replace(other.begin(), other.end(), edge.first, middle);
      std::replace(surface_.triangles[t].begin(), surface_.triangles[t].end(), edge.second, middle);
      surface_.triangles.push_back(other);
      int apex = -1;
      for (int v : other) {
        if (v != middle && v != edge.second) apex = v;
      }
      auto& moved = faces_of_.at(edgeOf(apex, edge.second));
      std::replace(moved.begin(), moved.end(), t, half);
      faces_of_[edgeOf(apex, middle)] = {t, half};
      faces_of_[edgeOf(edge.first, middle)].push_back(t);
      faces_of_[edgeOf(edge.second, middle)].push_back(half);
      open.push_back(t);
      open.push_back(half);
    }
  }

  TriangleSurface surface_;
  const EdgeLengthAt& longest_at_;
  int max_triangles_;
  std::unordered_map<Edge, std::vector<int>, EdgeHash> faces_of_;
};

}  // namespace

TriangleSurface refineSurface(const TriangleSurface& surface, const EdgeLengthAt& longest_at, int max_triangles) {
  return Splitter(surface, longest_at, max_triangles).run();
}

TriangleSurface refineSurface(const TriangleSurface& surface, double longest) {
  return refineSurface(surface, [longest](const Vec3&) { return longest; });
}

}  // namespace palpate
