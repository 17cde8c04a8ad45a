// The room around the organ: a large soft lamp (the key light), a rim lamp behind, a bright
// ceiling and a darker floor. Linear light. Reflections, ambient light and the backdrop all
// come from here, so that they agree.
#include "frame.glsl"

const vec3 ceiling = vec3(0.33, 0.355, 0.39);
const vec3 horizon = vec3(0.16, 0.165, 0.18);
const vec3 floor_bounce = vec3(0.085, 0.078, 0.074);
const vec3 key_colour = vec3(0.98, 0.93, 0.86);
const vec3 rim_colour = vec3(0.26, 0.30, 0.37);

// Light that falls on a surface with normal n from the whole room but the lamps.
vec3 ambientLight(vec3 n) {
  float up = n.z * 0.5 + 0.5;
  return mix(floor_bounce, ceiling, up * up * (3.0 - 2.0 * up));
}

vec3 rimDirection() { return normalize(vec3(-key.xy, 0.45)); }

// A rectangular lamp, seen in direction d from its centre line; edges as soft as `blur`.
float lampSeen(vec3 d, vec3 centre, vec2 half_size, float blur) {
  float ahead = dot(d, centre);
  vec3 side = normalize(cross(vec3(0.0, 0.0, 1.0), centre));
  vec2 p = abs(vec2(dot(d, side), dot(d, cross(centre, side)))) / max(ahead, 1e-3);
  vec2 inside = smoothstep(half_size + blur, half_size - blur, p);
  return ahead > 0.0 ? inside.x * inside.y : 0.0;
}

// What is seen in direction d, as a surface of roughness `blur` reflects it.
vec3 reflectedRoom(vec3 d, float blur, float key_visible) {
  float up = smoothstep(-0.35 - blur, 0.55 + blur, d.z);
  vec3 room = d.z > 0.0 ? mix(horizon, ceiling, up) : mix(floor_bounce, horizon, up * 2.0);
  vec3 lamps = 15.0 * key_colour * key_visible * lampSeen(d, key.xyz, vec2(0.34, 0.24), blur) +
               9.0 * rim_colour * lampSeen(d, rimDirection(), vec2(0.7, 0.12), blur);
  return room + lamps / (1.0 + 40.0 * blur * blur);
}

float fresnel(float facing, float at_normal) {
  float m = 1.0 - facing;
  float m2 = m * m;
  return at_normal + (1.0 - at_normal) * m2 * m2 * m;
}

// Share of the room that the tool's body leaves open to a point with normal n: the tool as
// a capsule, by the solid angle of the sphere of it that is nearest.
float toolOcclusion(vec3 p, vec3 n) {
  float r = tool_begin.w;
  if (r <= 0.0) return 1.0;
  vec3 axis = tool_end.xyz - tool_begin.xyz;
  float t = clamp(dot(p - tool_begin.xyz, axis) / dot(axis, axis), 0.0, 1.0);
  vec3 to = tool_begin.xyz + t * axis - p;
  float d = length(to);
  float covered = min(1.0, r * r / (d * d));
  return 1.0 - 0.85 * covered * clamp(0.35 + 0.65 * dot(n, to) / d, 0.0, 1.0);
}

// Share of the room that the ground takes from a point near it.
float groundOcclusion(vec3 p, vec3 n) {
  float height = max(0.0, p.z - ground.z) / (0.35 * ground.w);
  return 1.0 - 0.75 * exp(-height * 2.5) * clamp(0.55 - 0.75 * n.z, 0.0, 1.0);
}

vec3 backdrop(vec2 pixel) {
  vec2 p = pixel / picture.xy - vec2(0.5, 0.58);
  float away = smoothstep(0.0, 0.95, length(p * vec2(1.15, 1.0)));
  return mix(vec3(0.115, 0.127, 0.145), vec3(0.017, 0.020, 0.026), away);
}
