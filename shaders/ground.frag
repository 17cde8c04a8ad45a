// The table: a pool of light that fades into the backdrop, darkened by the organ.
#include "encode.glsl"
#include "studio.glsl"

uniform sampler2D ground_shade;  // r: share of the key light taken, g: share of the room taken

in vec2 away;
out vec4 colour;

const float shade_extent = 2.0;  // half width of ground_shade in organ radii, as app/render/ground_shade.cpp

void main() {
  float pool = 1.0 - smoothstep(0.5, 3.1, length(away));
  vec2 shade = texture(ground_shade, away / (2.0 * shade_extent) + 0.5).rg;
  vec2 edge = smoothstep(1.0, 0.75, abs(away) / shade_extent);
  shade *= edge.x * edge.y;
  vec3 table = vec3(0.30, 0.315, 0.335);
  vec3 light = 0.7 * key_colour * max(key.z, 0.3) * (1.0 - 0.85 * shade.r) +
               0.9 * ambientLight(vec3(0.0, 0.0, 1.0)) * (1.0 - 0.85 * shade.g);
  float mixed = pool * pool;
  vec3 lit = mix(backdrop(gl_FragCoord.xy), table * light, mixed);
  // Where the pool has faded, the shadow still darkens the backdrop.
  lit *= 1.0 - (1.0 - mixed) * 0.5 * max(shade.r, shade.g);
  colour = encodeDim(lit);
}
