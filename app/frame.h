#pragma once

#include <Eigen/Core>

namespace palpate {

/// The uniform block "Frame" of shaders/frame.glsl, in its std140 layout; meanings are there.
struct Frame {
  Eigen::Matrix4f clip_from_world = Eigen::Matrix4f::Identity();
  Eigen::Matrix4f shadow_from_world = Eigen::Matrix4f::Identity();
  Eigen::Vector4f eye = Eigen::Vector4f::Zero();
  Eigen::Vector4f key = Eigen::Vector4f::Zero();
  Eigen::Vector4f tool_begin = Eigen::Vector4f::Zero();
  Eigen::Vector4f tool_end = Eigen::Vector4f::Zero();
  Eigen::Vector4f ground = Eigen::Vector4f::Zero();
  Eigen::Vector4f picture = Eigen::Vector4f::Zero();
  Eigen::Vector4f tissue = Eigen::Vector4f::Zero();
};
static_assert(sizeof(Frame) == (2 * 16 + 7 * 4) * sizeof(float), "std140 packs these without gaps");

}  // namespace palpate
