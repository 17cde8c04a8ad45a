#pragma once

#include <optional>
#include <vector>

#include "app/render/camera.h"
#include "model/body.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

struct SkinHit {
  int vertex = -1;               // of the hit triangle, the one nearest to the ray's hit
  Vec3 position = Vec3::Zero();  // m
  double distance = 0;           // m, along the ray
};

/// The first triangle that the ray meets from outside.
/// @param positions  skin's vertices, m, e.g. Renderer::skinPositions()
std::optional<SkinHit> pickSkin(const TriangleSurface& surface, const std::vector<Vec3f>& positions, const Ray& ray);

/// Whether any of the skin faces the eye within this part of the picture, px, and is large enough there to be seen.
bool isSeen(const TriangleSurface& surface, const std::vector<Vec3f>& positions, const Camera& camera,
            const Eigen::AlignedBox2d& part, int width, int height);

/// The integration point that stands nearest to the ray in the present state, or -1 when
/// none is within `tolerance`, m.
int pickPoint(const Body& model, const Snapshot& snapshot, const Ray& ray, double tolerance);

}  // namespace palpate::app
