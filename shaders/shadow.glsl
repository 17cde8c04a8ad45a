// Share of the key light that reaches a point, from the shadow map; 1 outside of it.
#include "frame.glsl"

uniform sampler2DShadow shadow_map;

float keyVisible(vec3 p, vec3 n) {
  vec3 q = (shadow_from_world * vec4(p + key.w * n, 1.0)).xyz;
  if (any(lessThan(q, vec3(0.0))) || any(greaterThan(q, vec3(1.0)))) return 1.0;
  // Each lookup blends four texels; two rings of them make a penumbra about 7 texels wide.
  const float texel = 1.0 / 1024.0;
  const vec2 inner = vec2(1.3, 0.5) * texel, outer = vec2(2.9, 1.2) * texel;
  float s = texture(shadow_map, q);
  s += texture(shadow_map, q + vec3(inner.x, inner.y, 0.0));
  s += texture(shadow_map, q + vec3(-inner.y, inner.x, 0.0));
  s += texture(shadow_map, q + vec3(-inner.x, -inner.y, 0.0));
  s += texture(shadow_map, q + vec3(inner.y, -inner.x, 0.0));
  s += texture(shadow_map, q + vec3(outer.y, outer.x, 0.0));
  s += texture(shadow_map, q + vec3(-outer.x, outer.y, 0.0));
  s += texture(shadow_map, q + vec3(-outer.y, -outer.x, 0.0));
  s += texture(shadow_map, q + vec3(outer.x, -outer.y, 0.0));
  return s / 9.0;
}
