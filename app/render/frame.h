#pragma once

#include <Eigen/Core>

namespace palpate::app {

/// The uniform block "Frame" of shaders/frame.glsl, in its std140 layout; meanings are there.
struct Frame {
  // Packed as std140 wants them, whatever vector width the build aligns to.
  using Mat4 = Eigen::Matrix<float, 4, 4, Eigen::DontAlign>;
  using Vec4 = Eigen::Matrix<float, 4, 1, Eigen::DontAlign>;

  Mat4 clip_from_world = Mat4::Identity();
  Mat4 shadow_from_world = Mat4::Identity();
  Vec4 eye = Vec4::Zero();
  Vec4 key = Vec4::Zero();
  Vec4 tool_begin = Vec4::Zero();
  Vec4 tool_end = Vec4::Zero();
  Vec4 ground = Vec4::Zero();
  Vec4 picture = Vec4::Zero();
  Vec4 tissue = Vec4::Zero();
};
static_assert(sizeof(Frame) == (2 * 16 + 7 * 4) * sizeof(float), "std140 packs these without gaps");

}  // namespace palpate::app
