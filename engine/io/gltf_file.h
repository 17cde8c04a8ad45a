#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/types.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// A surface that deforms over time.
struct GltfSurface {
  std::string name;
  TriangleSurface rest;
  Vec3 colour = Vec3(0.5, 0.5, 0.5);       // linear light, 0..1
  std::vector<std::vector<Vec3f>> frames;  // (frame_count)(vertex_count) where its vertices are, m
};

/// A rigid thing that moves.
struct GltfBody {
  std::string name;
  TriangleSurface surface;  // in its own frame
  Vec3 colour = Vec3(0.5, 0.5, 0.5);
  std::vector<Pose> poses;  // (frame_count)
};

/// What programs for pictures and films open: a run as one animation.
struct GltfRun {
  std::vector<double> time_s;  // (frame_count) ascending
  GltfSurface surface;
  std::vector<GltfBody> bodies;
  std::vector<std::pair<std::string, std::vector<double>>> curves;  // kept beside it as `extras`, (frame_count) each
};

/// Writes a run as glTF 2.0, whole or not at all (output_file.h): the surface as morph targets, one for each frame, of
/// which the animation shows now this, now the next; between frames all moves evenly. Palpate's z is up, as glTF's y.
///
/// @param path  *.glb: binary; else JSON with its arrays in it
/// Throws std::runtime_error with file and reason where it can't be written, std::invalid_argument where lengths do not
/// fit, there is no frame, or a number is not finite.
/// Test: io/gltf_file_test.cpp reads it back with assimp.
void writeGltf(const std::string& path, const GltfRun& run);

}  // namespace palpate
