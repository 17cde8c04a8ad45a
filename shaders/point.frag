// A small ball, lit from above.
#include "encode.glsl"

in vec4 tinted;
in float size;
out vec4 colour;

void main() {
  vec2 q = gl_PointCoord * 2.0 - 1.0;
  float r = length(q);
  float inside = clamp((1.0 - r) * 0.5 * size, 0.0, 1.0);
  if (inside <= 0.0) discard;
  float shade = 0.62 + 0.38 * clamp(0.6 - 0.7 * q.y - 0.3 * q.x, 0.0, 1.0);
  shade *= mix(1.0, 0.6, smoothstep(0.6, 1.0, r));
  colour = encode(tinted.rgb * shade, tinted.a * inside);
}
