#include "app/render/ground_shade.h"

#include "app/render/texture_units.h"

namespace palpate::app {
namespace {

constexpr GLsizei shade_texels = 128;
constexpr double shade_extent_in_radii = 2.0;           // half width; as shade_extent in shaders/ground.frag
constexpr double depth_in_radii = 4.0;                  // height of what is looked at
constexpr double reach_in_radii = 0.30;                 // height over which a body's hold on the room's light fades
constexpr float key_spread = 0.7F, room_spread = 1.6F;  // texels between taps

void makeTarget(GLuint framebuffer, GLuint texture) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RG8, shade_texels, shade_texels, 0, GL_RG, GL_UNSIGNED_BYTE, nullptr);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_BORDER);
  glBindTexture(GL_TEXTURE_2D, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  requireComplete("ground's shade");
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

/// Moves points along the light onto the plane through `ground`, keeping their height in z
/// (so that the projection from above still sees it).
Eigen::Matrix4f throwAlong(const Vec3& key, const Vec3& ground) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (int k = 0; k < 2; ++k) {
    m(k, 2) = -key[k] / key.z();
    m(k, 3) = key[k] / key.z() * ground.z();
  }
  return m.cast<float>();
}

}  // namespace

GroundShade::GroundShade(const std::string& shader_dir)
    : cast_(shader_dir, "depth.vert", "ground_shade.frag"),
      blur_(shader_dir, "backdrop.vert", "blur.frag"),
      clip_from_local_(cast_.uniform("clip_from_local")),
      taken_(cast_.uniform("taken")),
      reach_(cast_.uniform("reach")),
      direction_(blur_.uniform("direction")),
      spread_(blur_.uniform("spread")) {
  makeTarget(framebuffer_, shade_);
  makeTarget(scratch_framebuffer_, scratch_);
}

void GroundShade::draw(const Vec3& key, const Vec3& ground, double radius, const DrawCasters& casters) {
  // Seen from below: x to the right, y up the texture, heights from 0 on the ground.
  const double depth = depth_in_radii * radius;
  const Eigen::Matrix4f from_below = parallelProjection(Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitZ(), ground,
                                                        shade_extent_in_radii * radius, 0, depth);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, shade_texels, shade_texels);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_DEPTH_CLAMP);  // what dips below the ground or stands high above still takes light
  glEnable(GL_BLEND);
  glBlendEquation(GL_MAX);
  cast_.use();
  glUniform1f(reach_, static_cast<float>(reach_in_radii * radius / depth));
  glUniform2f(taken_, 1, 0);
  casters(clip_from_local_, from_below * throwAlong(key, ground));
  glUniform2f(taken_, 0, 1);
  casters(clip_from_local_, from_below);
  glBlendEquation(GL_FUNC_ADD);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_CLAMP);

  blur_.use();
  glUniform2f(spread_, key_spread, room_spread);
  glBindVertexArray(no_vertices_);
  glActiveTexture(GL_TEXTURE0 + kSourceUnit);
  const auto pass = [&](GLuint from, GLuint to, float x, float y) {
    glBindFramebuffer(GL_FRAMEBUFFER, to);
    glBindTexture(GL_TEXTURE_2D, from);
    glUniform2f(direction_, x / shade_texels, y / shade_texels);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  pass(shade_, scratch_framebuffer_, 1, 0);
  pass(scratch_, framebuffer_, 0, 1);
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE0);
  glEnable(GL_DEPTH_TEST);
}

}  // namespace palpate::app
