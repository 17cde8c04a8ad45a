#pragma once

namespace palpate {

/// How the real-time kernel stores gradients (kernel_layout.h).
enum class GradientPrecision {
  Float32,
  Int16,  // 16-bit integers times a scale for each point and component: half the memory, for large models
};

}  // namespace palpate
