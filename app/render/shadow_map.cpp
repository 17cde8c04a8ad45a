#include "app/render/shadow_map.h"

namespace palpate::app {
namespace {

constexpr GLsizei shadow_texels = 1024;          // shaders/shadow.glsl has its inverse
constexpr double shadow_extent_in_radii = 1.12;  // half width; the organ swells and the tool's tip stands around it

}  // namespace

Eigen::Matrix4f parallelProjection(const Vec3& right, const Vec3& up, const Vec3& toward, const Vec3& centre,
                                   double extent, double near, double far) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = right.transpose() / extent;
  m.block<1, 3>(1, 0) = up.transpose() / extent;
  m.block<1, 3>(2, 0) = -2 * toward.transpose() / (far - near);
  m.block<3, 1>(0, 3) = -m.topLeftCorner<3, 3>() * centre;
  m(2, 3) -= (far + near) / (far - near);
  return m.cast<float>();
}

ShadowMap::ShadowMap(const std::string& shader_dir)
    : program_(shader_dir, "depth.vert", "depth.frag"), clip_from_local_(program_.uniform("clip_from_local")) {
  glBindTexture(GL_TEXTURE_2D, depth_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, shadow_texels, shadow_texels, 0, GL_DEPTH_COMPONENT,
               GL_UNSIGNED_INT, nullptr);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glBindTexture(GL_TEXTURE_2D, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  requireComplete("shadow map");
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void ShadowMap::draw(const Vec3& key, const Vec3& centre, double radius, const DrawCasters& casters) {
  const Vec3 right = Vec3::UnitZ().cross(key).normalized(), up = key.cross(right);
  const double extent = shadow_extent_in_radii * radius;
  // The tool reaches far towards the light; what stands before the near plane is kept by clamping.
  const Eigen::Matrix4f clip_from_world = parallelProjection(right, up, key, centre, extent, -2 * extent, 2 * extent);
  map_from_world_ = clip_from_world;
  map_from_world_.topRows<3>() *= 0.5F;
  map_from_world_.topRightCorner<3, 1>().array() += 0.5F;
  const double texel = 2 * extent / shadow_texels;
  normal_offset_ = static_cast<float>(2.5 * texel);

  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, shadow_texels, shadow_texels);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glEnable(GL_DEPTH_CLAMP);
  glPolygonOffset(2.0F, 2.0F);
  program_.use();
  casters(clip_from_local_, clip_from_world);
  glDisable(GL_DEPTH_CLAMP);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

}  // namespace palpate::app
