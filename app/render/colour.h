#pragma once

#include "base/types.h"

namespace palpate::app {

/// sRGB's transfer function and its inverse (IEC 61966-2-1), 0..1.
float encodeSrgb(float linear);
float decodeSrgb(float encoded);

/// CIELAB under D65, as sRGB has it: L* 0..100, a*, b*. From and to encoded sRGB, 0..1;
/// what lies outside its gamut is clamped.
Vec3f labFromSrgb(const Vec3f& encoded);
Vec3f srgbFromLab(const Vec3f& lab);

}  // namespace palpate::app
