// Wet soft tissue, or a field's colours in the same light.
#include "encode.glsl"
#include "shadow.glsl"
#include "studio.glsl"

uniform float opacity;       // below 1 the skin is seen through, less so where it turns away
uniform sampler3D noise;     // rgb: gradient, a: value, both 0..1 around 0.5
uniform sampler2D colours;   // a field's colour over its value, linear light
uniform vec3 below, above;   // of stripes where a value lies outside the range, linear light

in vec3 p;
in vec3 n;
in vec3 X;
in vec4 trait;
in vec3 own;  // albedo, linear
out vec4 colour;

// How far light creeps around the terminator under the surface, for what is absorbed most
// and least: in flesh red goes furthest, in a blue gel blue does.
const float min_creep = 0.09, max_creep = 0.34;

vec3 hatched(vec3 albedo, float fixed_share) {
  float s = dot(X, vec3(0.57, 0.57, 0.59)) * tissue.w * 22.0;
  float line = abs(fract(s) - 0.5), width = fwidth(s);
  float stripe = mix(smoothstep(0.25 - width, 0.25 + width, line), 0.5, clamp(2.0 * width - 0.4, 0.0, 1.0));
  float amount = tool_end.w * smoothstep(0.42, 0.58, fixed_share);
  return mix(albedo, vec3(0.10, 0.19, 0.32), amount * mix(0.22, 0.70, stripe));
}

/// Stripes over what lies outside the colours' range, so that no colour vision is needed to see it.
vec3 outside(vec3 albedo, float value) {
  if (value >= -1e-4 && value <= 1.0001) return albedo;
  float s = dot(X, value < 0.0 ? vec3(0.57, 0.57, 0.59) : vec3(0.57, -0.57, 0.59)) * tissue.w * 17.0;
  float line = abs(fract(s) - 0.5), width = fwidth(s);
  float stripe = mix(smoothstep(0.25 - width, 0.25 + width, line), 0.5, clamp(2.0 * width - 0.4, 0.0, 1.0));
  return mix(albedo, value < 0.0 ? below : above, 0.2 + 0.7 * stripe);
}

void main() {
  bool field = picture.w > 0.5, printed = picture.w > 1.5;
  vec3 smooth_n = normalize(n);
  vec3 to_eye = normalize(eye.xyz - p);

  vec4 coarse = texture(noise, X * tissue.w) - 0.5;
  vec4 fine = texture(noise, X * tissue.w * 5.3) - 0.5;
  vec4 finest = texture(noise, X * tissue.w * 21.0) - 0.5;
  vec3 bump = fine.xyz + 0.35 * coarse.xyz + 0.45 * finest.xyz;
  vec3 rough_n = normalize(smooth_n - (field ? 0.0 : 0.34) * (bump - smooth_n * dot(bump, smooth_n)));

  vec3 albedo = own;
  albedo *= 1.0 + 0.75 * coarse.a + 0.35 * fine.a + 0.22 * finest.a;
  vec3 passing = own / max(max(own.r, own.g), max(own.b, 1e-3));  // 1 for what goes furthest
  albedo *= mix(vec3(1.0), mix(vec3(0.62), vec3(0.82), passing), clamp(coarse.r * 1.6, 0.0, 1.0));
  vec3 creep = mix(vec3(min_creep), vec3(max_creep), passing * passing);
  if (field) albedo = outside(texture(colours, vec2(trait.x, 0.5)).rgb, trait.x) * 0.9;
  albedo = mix(albedo, vec3(0.86, 0.60, 0.50), 0.55 * trait.y * (field ? 0.0 : 1.0));
  albedo = hatched(albedo, trait.w);

  float hollow = clamp(1.0 - 0.55 * trait.z, 0.45, 1.12);
  float open = toolOcclusion(p, smooth_n) * groundOcclusion(p, smooth_n) * hollow;
  float visible = printed ? 1.0 : keyVisible(p, smooth_n);

  float facing_key = dot(mix(smooth_n, rough_n, 0.5), key.xyz);
  vec3 key_light = clamp((facing_key + creep) / (1.0 + creep), 0.0, 1.0);
  key_light *= key_light * (3.0 - 2.0 * key_light) * 0.35 + 0.65;
  vec3 visible_under = mix(vec3(visible), vec3(sqrt(visible)), 0.5 * passing * passing);  // shadows' rims glow
  float facing_rim = clamp(dot(smooth_n, rimDirection()), 0.0, 1.0);
  vec3 light = key_colour * key_light * visible_under + rim_colour * facing_rim * open + ambientLight(smooth_n) * open;
  if (field) light = mix(vec3(dot(light, vec3(1.0 / 3.0))), vec3(1.0), 0.25) * 0.85;
  if (printed) {  // colours are compared with a bar beside them: just enough light and shade to see the shape
    colour = vec4(srgb(toneMap(albedo * mix(vec3(1.12), light, 0.52))), opacity);
    return;
  }

  // The wet film: a sharp reflection of the room over a broad sheen of the tissue below.
  vec3 mirrored = reflect(-to_eye, rough_n);
  float facing = clamp(dot(rough_n, to_eye), 0.0, 1.0);
  // Near the ground a reflection that goes down meets the ground's shadow, not the room.
  float film = fresnel(facing, 0.035) * mix(0.25, 1.0, open) * groundOcclusion(p, mirrored);
  float sheen = pow(clamp(dot(smooth_n, normalize(key.xyz + to_eye)), 0.0, 1.0), 26.0) * 0.085 * visible;
  vec3 glint = reflectedRoom(mirrored, 0.14, visible) * film + key_colour * sheen;
  float alpha = opacity < 1.0 ? mix(1.0, opacity, facing * facing) : 1.0;
  colour = encode(albedo * light + (field ? 0.35 : 1.0) * glint, alpha);
}
