#include "app/run/frame_pace.h"

#include <algorithm>
#include <string_view>

namespace palpate::app {

double FramePace::turn(double drawing, std::int64_t overruns) {
  if (!software_) return shortest;
  constexpr double recovery = 0.97;  // of the patience, kept by a frame without a late tick: back in some ten seconds
  patience_ = overruns > overruns_ ? 2 * std::max(patience_, drawing) : recovery * patience_;
  patience_ = std::clamp(patience_, shortest, longest);
  overruns_ = overruns;
  return std::max(std::min(2 * drawing, longest), patience_);
}

bool isSoftwareRenderer(const char* name) {
  const std::string_view text = name ? name : "";
  for (const char* software : {"llvmpipe", "softpipe", "swrast", "Software Rasterizer"})
    if (text.find(software) != std::string_view::npos) return true;
  return false;
}

}  // namespace palpate::app
