#include "discretization/cells/delaunay.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace palpate {
namespace {

/// Volumes below this fraction of the cube of a tetrahedron's longest edge are rounding (~1e-16) or
/// so flat that their shape functions mean nothing.
constexpr double flat = 1e-9;

/// One run of qhull: its state, and the memory stream that takes its messages.
class Qhull {
 public:
  Qhull() : messages_(open_memstream(&text_, &text_size_)) { qh_zero(&qh_, messages_); }
  ~Qhull() {
    qh_freeqhull(&qh_, !qh_ALL);
    int memory_left = 0, total_left = 0;
    qh_memfreeshort(&qh_, &memory_left, &total_left);
    std::fclose(messages_);
    std::free(text_);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  /// `coordinates` must outlive this object: qhull keeps pointing at it.
  void delaunay(std::vector<double>& coordinates) {
    // Qbb: scale the lifted coordinate, Qc: keep coplanar points, Qz: a point at infinity (for cospherical
    // input), Qt: tetrahedra only. No joggling (QJ): it would dent flat faces.
    char command[] = "qhull d Qbb Qc Qz Qt";
    const int failed = qh_new_qhull(&qh_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False,
                                    command, nullptr, messages_);
    if (failed) {
      std::fflush(messages_);
      const std::string text(text_, text_size_);
      // The first line says what; a page of advice on qhull's options follows, which nobody can follow here.
      throw std::runtime_error("Delaunay tetrahedra: " + text.substr(0, text.find('\n')));
    }
  }

  std::vector<std::array<int, 4>> tetrahedra() {
    qhT* const qh = &qh_;  // the name that qhull's macros expect
    std::vector<std::array<int, 4>> result;
    facetT* facet = nullptr;
    const int point_count = qh->num_points - (qh->ATinfinity ? 1 : 0);
    FORALLfacets {
      if (facet->upperdelaunay) continue;
      std::array<int, 4> tetrahedron;
      int k = 0;
      vertexT *vertex = nullptr, **vertexp = nullptr;
      FOREACHvertex_(facet->vertices) {
        const int id = qh_pointid(qh, vertex->point);  // -1 or beyond the input: the point at infinity
        if (k < 4 && id >= 0 && id < point_count) tetrahedron[k] = id;
        ++k;
      }
      if (k == 4) result.push_back(tetrahedron);
    }
    return result;
  }

 private:
  char* text_ = nullptr;
  std::size_t text_size_ = 0;
  FILE* messages_;
  qhT qh_;
};

}  // namespace

double tetrahedronVolume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6;
}

std::vector<std::array<int, 4>> delaunay(const std::vector<Vec3>& X) {
  if (X.size() < 4) throw std::runtime_error("Delaunay tetrahedra need at least 4 points");
  std::vector<double> coordinates;
  coordinates.reserve(3 * X.size());
  for (const Vec3& x : X) coordinates.insert(coordinates.end(), {x.x(), x.y(), x.z()});

  std::vector<std::array<int, 4>> found;
  {
    Qhull qhull;
    qhull.delaunay(coordinates);
    found = qhull.tetrahedra();
  }
  std::vector<std::array<int, 4>> cells;
  cells.reserve(found.size());
  for (std::array<int, 4> cell : found) {
    std::sort(cell.begin(), cell.end());
    const double volume = tetrahedronVolume(X[cell[0]], X[cell[1]], X[cell[2]], X[cell[3]]);
    double longest = 0;
    for (int i : cell) {
      for (int j : cell) longest = std::max(longest, (X[i] - X[j]).norm());
    }
    if (std::abs(volume) < flat * longest * longest * longest) continue;
    if (volume < 0) std::swap(cell[2], cell[3]);
    cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

}  // namespace palpate
