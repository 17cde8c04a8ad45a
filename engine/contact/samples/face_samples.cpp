#include "contact/samples/face_samples.h"

#include <algorithm>

#include "contact/broad_phase.h"

namespace palpate {
namespace {

/// A point of a triangle is no further from the nearest corner than this part of the longest edge (1 / sqrt 3).
constexpr double kCornerReach = 0.5774;

/// What stretched edges may grow by from one search to the next.
constexpr double kGrowth = 1.1;

/// Part of the reach within which vertices are listed for certain.
constexpr double kInside = 0.999;

// Places are multiples of an eighth of an edge: those of a half, of quarters and of eighths are the three levels.
constexpr int kPieces = 8;
constexpr int kEdgePlaces = kPieces - 1;
constexpr int kFacePlaces = (kPieces - 1) * (kPieces - 2) / 2;

/// Times that a place's numerators can be halved together: 2, 1, 0 for levels 1, 2, 3.
constexpr int halvings(int a, int b, int c) {
  int n = 0;
  for (; a % 2 == 0 && b % 2 == 0 && c % 2 == 0; ++n) a /= 2, b /= 2, c /= 2;
  return n;
}

/// A place inside a face. It is the middle of a piece that is parallel to one of the face's edges.
struct FacePlace {
  std::array<int, 3> eighths = {};  // of the corners; sum 8
  int level = 3;
  int edge = 0;  // the parallel one, named by the corner opposite to it
};

constexpr std::array<FacePlace, kFacePlaces> makeFacePlaces() {
  std::array<FacePlace, kFacePlaces> places;
  int n = 0;
  for (int a = 1; a < kPieces; ++a) {
    for (int b = 1; a + b < kPieces; ++b) {
      const int c = kPieces - a - b, shift = halvings(a, b, c);
      // Two numerators are odd there: half a piece to one side and the other they change, the third does not.
      const int edge = (a >> shift) % 2 == 0 ? 0 : (b >> shift) % 2 == 0 ? 1 : 2;
      places[n++] = {{a, b, c}, 3 - shift, edge};
    }
  }
  return places;
}

constexpr std::array<FacePlace, kFacePlaces> face_places = makeFacePlaces();

/// How far a sample of this level is in, for the stretch of its edge.
float weightOf(int level, float stretch) {
  const float of_piece = stretch / static_cast<float>(1 << (level - 1));
  return std::clamp((of_piece - kStretchLimit) / (kFullStretch - kStretchLimit), 0.0F, 1.0F);
}

/// Share of a face that a sample of this level on its edge stands for, were there only its own level's.
float shareOf(int level) { return 1.0F / static_cast<float>(1 << (2 * level)); }

/// One search.
struct Search {
  const SkinModel& skin;
  const Float4* u;
  const ToolProfile tool;
  const Mat3 local_from_world;
  const Vec3 tool_position;
  const double reach;
  ContactState& contact;
  ContactScratch& scratch;
  FaceSamples& samples = contact.samples;
  const SkinTopology& topology = *skin.topology;
  int found = 0, marked = 0;
  float longest_edge = 0, largest_stretch = 1;
  bool overflow = false;

  float distanceAt(const Vec3f& x) const {
    return static_cast<float>(toolDistance(tool, local_from_world * (x.cast<double>() - tool_position)).distance);
  }

  void markListed() {
    for (int slot = 0; slot < contact.count; ++slot) {
      const int v = contact.vertex[slot];
      scratch.mark[v] = slot + 1;
      scratch.position[v] = skinPosition(skin, v, u).cast<float>();
    }
  }

  /// Takes the mark off vertices at the border of the list: another thread may have moved it by rounding.
  void unmarkBorder() {
    const double inside = kInside * (reach + cornerReach(samples));
    for (int slot = 0; slot < contact.count; ++slot) {
      const int v = contact.vertex[slot];
      if (static_cast<double>(distanceAt(scratch.position[v])) <= inside) continue;
      scratch.mark[v] = -1;
      scratch.marked[marked++] = v;
    }
  }

  void unmark() {
    for (int slot = 0; slot < contact.count; ++slot) scratch.mark[contact.vertex[slot]] = 0;
    for (int k = 0; k < marked; ++k) scratch.mark[scratch.marked[k]] = 0;
  }

  const Vec3f& positionOf(int v) {
    if (scratch.mark[v] == 0) {
      scratch.position[v] = skinPosition(skin, v, u).cast<float>();
      scratch.mark[v] = -1;
      scratch.marked[marked++] = v;
    }
    return scratch.position[v];
  }

  bool anyStretched() const {
    for (int slot = 0; slot < contact.count; ++slot) {
      const int v = contact.vertex[slot];
      const Vec3f& x = scratch.position[v];
      for (int e = topology.edge_begin[v]; e < topology.edge_begin[v + 1]; ++e) {
        const int w = topology.edge[e][1];
        const float limit = kStretchLimit * topology.edge_length[e];
        if (scratch.mark[w] > 0 && (scratch.position[w] - x).squaredNorm() > limit * limit) return true;
      }
    }
    return false;
  }

  void add(int id, const SkinPoint& point, float weight, float area, const std::array<float, 3>& corner_distance) {
    Vec3f x = Vec3f::Zero();
    float average = 0;
    for (int c = 0; c < point.corners; ++c) {
      x += point.share[c] * scratch.position[point.vertex[c]];
      average += point.share[c] * corner_distance[c];
    }
    const float distance = distanceAt(x);
    if (!(distance <= reach)) return;
    if (found == static_cast<int>(scratch.sample.size())) {
      overflow = true;
      return;
    }
    scratch.sample[found++] = {id, point, weight * area, (1.0F - weight) * std::max(0.0F, average - distance)};
  }

  /// Area of a face as it is now, m^2.
  float areaOf(const std::array<int, 3>& corner) const {
    const Vec3f& origin = scratch.position[corner[0]];
    return 0.5F * (scratch.position[corner[1]] - origin).cross(scratch.position[corner[2]] - origin).norm();
  }

  void addFace(int f) {
    const std::array<int, 3>& corner = skin.surface.triangles[f];
    std::array<float, 3> stretch{}, distance{};
    float longest = 0, largest = 0;
    for (int c = 0; c < 3; ++c) {
      const int e = topology.face_edge[f][c];
      const float length = (positionOf(corner[(c + 1) % 3]) - positionOf(corner[(c + 2) % 3])).norm();
      stretch[c] = length / topology.edge_length[e];
      longest = std::max(longest, length);
      largest = std::max(largest, stretch[c]);
    }
    if (!(largest > kStretchLimit)) return;
    for (int c = 0; c < 3; ++c) distance[c] = distanceAt(scratch.position[corner[c]]);
    if (!(*std::min_element(distance.begin(), distance.end()) <= reach + longest)) return;
    const float area = areaOf(corner);
    longest_edge = std::max(longest_edge, longest);
    largest_stretch = std::max(largest_stretch, largest);

    for (int c = 0; c < 3; ++c) {
      const int e = topology.face_edge[f][c], first = (c + 1) % 3, second = (c + 2) % 3;
      const bool swapped = corner[first] != topology.edge[e][0];
      const int a = swapped ? second : first, b = swapped ? first : second;
      for (int t = 1; t < kPieces; ++t) {
        const int level = 3 - halvings(t, kPieces - t, 0);
        const float weight = weightOf(level, stretch[c]), along = static_cast<float>(t) / kPieces;
        if (weight > 0.0F)
          add(e * kEdgePlaces + t - 1, {2, {corner[a], corner[b], 0}, {1.0F - along, along, 0.0F}}, weight,
              shareOf(level) * area, {distance[a], distance[b], 0.0F});
      }
    }
    const int base = topology.edgeCount() * kEdgePlaces + f * kFacePlaces;
    for (int k = 0; k < kFacePlaces; ++k) {
      const FacePlace& place = face_places[k];
      const float weight = weightOf(place.level, stretch[place.edge]);
      if (weight == 0.0F) continue;
      SkinPoint point{3, corner, {}};
      for (int c = 0; c < 3; ++c) point.share[c] = static_cast<float>(place.eighths[c]) / kPieces;
      add(base + k, point, weight, 2.0F * shareOf(place.level) * area, distance);
    }
  }

  /// The faces around the listed vertices, each once.
  void addFaces() {
    for (int slot = 0; slot < contact.count; ++slot) {
      const int v = contact.vertex[slot];
      for (int k = topology.face_begin[v]; k < topology.face_begin[v + 1]; ++k) {
        const int f = topology.face_of[k];
        if (scratch.mark[v] < 0) break;
        const auto before = [&](int w) { return scratch.mark[w] > 0 && scratch.mark[w] <= slot; };
        const auto& corner = skin.surface.triangles[f];
        if (std::none_of(corner.begin(), corner.end(), before)) addFace(f);
      }
    }
  }

  /// The side of the tool that a new sample's corners touch; zero if none does.
  Vec3f sideOfCorners(const SkinPoint& point) const {
    Vec3f sum = Vec3f::Zero();
    for (int c = 0; c < point.corners; ++c) {
      const int slot = scratch.mark[point.vertex[c]] - 1;
      if (slot >= 0) sum += point.share[c] * contact.normal[slot];
    }
    const float size = sum.norm();
    return size > 0.0F ? Vec3f(sum / size) : sum;
  }

  /// Merges what was found with the old list; both ascend.
  void merge() {
    const auto begin = scratch.sample.begin();
    std::sort(begin, begin + found, [](const auto& a, const auto& b) { return a.id < b.id; });
    // An edge's samples were found by the faces on both of its sides, each with its own area.
    int different = 0;
    for (int k = 0; k < found; ++k) {
      if (different > 0 && begin[different - 1].id == begin[k].id)
        begin[different - 1].area += begin[k].area;
      else
        begin[different++] = begin[k];
    }
    const int capacity = static_cast<int>(samples.id.size());
    const int count = std::min(different, capacity);
    overflow = overflow || different > capacity;
    scratch.keepOld(samples.count, samples.id, samples.force, samples.normal, samples.side);
    int old = 0;
    for (int k = 0; k < count; ++k) {
      const ContactScratch::SampleCandidate& c = begin[k];
      while (old < samples.count && scratch.old_id[old] < c.id) ++old;
      const bool stays = old < samples.count && scratch.old_id[old] == c.id;
      samples.id[k] = c.id;
      samples.point[k] = c.point;
      samples.area[k] = c.area;
      samples.lift[k] = c.lift;
      samples.force[k] = stays ? scratch.old_force[old] : Float4{};
      samples.normal[k] = stays ? scratch.old_normal[old] : sideOfCorners(c.point);
      samples.side[k] = stays ? scratch.old_side[old] : Vec3f(Vec3f::Zero());
    }
    samples.count = count;
  }
};

}  // namespace

void findFaceSamples(const SkinModel& skin, const Float4* u, const ToolShape& tool, const Pose& tool_pose,
                     double margin, ContactState& contact, ContactScratch& scratch) {
  Search search{skin,
                u,
                toolProfile(tool),
                tool_pose.orientation.conjugate().toRotationMatrix(),
                tool_pose.position,
                margin + kTissueTravel * tool.radius,
                contact,
                scratch};
  search.markListed();
  FaceSamples& samples = contact.samples;
  if (search.anyStretched()) {
    search.unmarkBorder();
    search.addFaces();
    search.merge();
    contact.overflow = contact.overflow || search.overflow;
  } else {
    samples.count = 0;
  }
  samples.longest_edge = search.longest_edge;
  samples.largest_stretch = search.largest_stretch;
  search.unmark();
}

double cornerReach(const FaceSamples& samples) {
  return kGrowth * kCornerReach * static_cast<double>(samples.longest_edge);
}

double expectedStretch(const FaceSamples& samples) { return kGrowth * static_cast<double>(samples.largest_stretch); }

Vec3 skinPosition(const SkinModel& skin, const SkinPoint& point, const Float4* u) {
  Vec3 x = Vec3::Zero();
  for (int c = 0; c < point.corners; ++c)
    x += static_cast<double>(point.share[c]) * skinPosition(skin, point.vertex[c], u);
  return x;
}

Eigen::Vector4f interpolate(const SkinModel& skin, const SkinPoint& point, const Float4* field) {
  Eigen::Vector4f sum = Eigen::Vector4f::Zero();
  for (int c = 0; c < point.corners; ++c) sum += point.share[c] * interpolateAtVertex(skin, point.vertex[c], field);
  return sum;
}

}  // namespace palpate
