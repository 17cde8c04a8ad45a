#pragma once

#include <Eigen/Core>
#include <functional>

#include "app/render/gl_object.h"
#include "app/render/shader_program.h"
#include "base/types.h"

namespace palpate::app {

/// Draws the bodies that cast shadows, each with its own clip-from-world matrix already chosen.
using DrawCasters = std::function<void(GLint clip_from_local, const Eigen::Matrix4f& clip_from_world)>;

/// Depth as the key light sees it, around the organ.
class ShadowMap {
 public:
  explicit ShadowMap(const std::string& shader_dir);

  /// @param key  unit vector towards the light
  void draw(const Vec3& key, const Vec3& centre, double radius, const DrawCasters& casters);

  GLuint texture() const { return depth_; }
  const Eigen::Matrix4f& mapFromWorld() const { return map_from_world_; }  // 0..1
  float normalOffset() const { return normal_offset_; }                    // m, against self-shadowing

 private:
  ShaderProgram program_;
  GLint clip_from_local_;
  GlFramebuffer framebuffer_;
  GlTexture depth_;
  Eigen::Matrix4f map_from_world_ = Eigen::Matrix4f::Identity();
  float normal_offset_ = 0;
};

/// Clip coordinates of a parallel projection onto the plane of `right` and `up` through
/// `centre`: x and y within +-extent, z from 0 in front at `near` (along -toward) to `far`, m.
Eigen::Matrix4f parallelProjection(const Vec3& right, const Vec3& up, const Vec3& toward, const Vec3& centre,
                                   double extent, double near, double far);

}  // namespace palpate::app
