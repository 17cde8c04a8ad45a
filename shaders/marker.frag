// Things that explain rather than exist: arrows (opaque) and bubbles (clear but for the rim).
#include "encode.glsl"
#include "studio.glsl"

uniform bool clear;

in vec3 p;
in vec3 n;
in vec4 tinted;
out vec4 colour;

void main() {
  vec3 normal = normalize(n);
  vec3 to_eye = normalize(eye.xyz - p);
  float facing = clamp(dot(normal, to_eye), 0.0, 1.0);
  vec3 light = 0.55 * key_colour * clamp(0.5 + 0.5 * dot(normal, key.xyz), 0.0, 1.0) + 0.6 * ambientLight(normal);
  float rim = 1.0 - facing;
  colour = clear ? encode(tinted.rgb, tinted.a * (0.12 + 0.88 * rim * rim * rim)) : encode(tinted.rgb * light, 1.0);
}
