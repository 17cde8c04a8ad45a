#pragma once

namespace palpate::app {

/// Which texture unit a sampler reads. A sampler's name in GLSL is its entry here,
/// so that textures are bound once per picture and never per program.
enum TextureUnit { kShadowMapUnit, kNoiseUnit, kColoursUnit, kGroundShadeUnit, kSourceUnit, kTextureUnitCount };

inline constexpr const char* texture_unit_names[kTextureUnitCount] = {"shadow_map", "noise", "colours", "ground_shade",
                                                                      "source"};

}  // namespace palpate::app
