// The tool: brushed steel (turned, so its grain runs around the axis), a rubber grip, a collar. Also lumps, and rigid
// bodies of matte grey.
#include "encode.glsl"
#include "shadow.glsl"
#include "studio.glsl"

uniform sampler2D ground_shade;  // as in ground.frag

uniform mat4 world_from_local;
uniform float opacity;

in vec3 p;
in vec3 n;
in vec3 local;
flat in float finish;
out vec4 colour;

// Grooves of turned metal: a hash of the height, faded where it would be finer than a pixel.
float groove(float z) {
  float cell = z / (0.012 * tool_begin.w);
  float here = fract(sin(floor(cell) * 12.9898) * 43758.5453);
  float next = fract(sin(floor(cell + 1.0) * 12.9898) * 43758.5453);
  float fade = clamp(1.6 - fwidth(cell), 0.0, 1.0);
  return (mix(here, next, smoothstep(0.0, 1.0, fract(cell))) - 0.5) * fade;
}

// Tall strips of light around the room, which only a standing bar reflects: bright where its
// side turns to them, dark between.
float strips(vec3 d) {
  vec2 flat_d = normalize(d.xy + vec2(1e-5)), side = normalize(key.xy);
  float along = dot(flat_d, side), across = dot(flat_d, vec2(-side.y, side.x));
  float bright =
      smoothstep(0.15, 1.0, along) + 0.5 * smoothstep(0.45, 1.0, -across) + 0.2 * smoothstep(0.3, 1.0, across);
  return bright * smoothstep(1.0, 0.3, abs(d.z));
}

void main() {
  vec3 normal = normalize(n);
  vec3 to_eye = normalize(eye.xyz - p);
  vec3 axis = world_from_local[2].xyz;
  float facing = clamp(dot(normal, to_eye), 0.0, 1.0);
  // Close to the tissue the room is hidden by it and its colour shows instead.
  float above = clamp(local.z / (1.6 * tool_begin.w), 0.0, 1.0);

  if (finish == 3.0) {  // lump: pale, firm tissue
    vec3 light = key_colour * clamp(0.25 + 0.75 * dot(normal, key.xyz), 0.0, 1.0) + ambientLight(normal);
    colour = encode(vec3(0.72, 0.58, 0.24) * light, opacity);
    return;
  }
  if (finish == 4.0) {  // a rigid body, in the shadow of organ and tool; what lies low, in the shade of what is on it
    float low = exp(-max(0.0, p.z - ground.z) / (0.2 * ground.w)) * clamp(normal.z, 0.0, 1.0);
    float taken = low * texture(ground_shade, (p.xy - ground.xy) / (4.0 * ground.w) + 0.5).g;
    float under = groundOcclusion(p, normal) * (1.0 - 0.8 * taken) * toolOcclusion(p, normal);
    // A shadow that goes on beyond the shadow map fades before its border.
    vec2 q = (shadow_from_world * vec4(p, 1.0)).xy, border = min(q, 1.0 - q);
    float visible = mix(1.0, keyVisible(p, normal), smoothstep(0.0, 0.15, min(border.x, border.y)));
    vec3 light = key_colour * visible * clamp(dot(normal, key.xyz), 0.0, 1.0) + ambientLight(normal) * under;
    vec3 sheen = reflectedRoom(reflect(-to_eye, normal), 0.6, 1.0) * fresnel(facing, 0.04) * 0.35 * under;
    colour = encode(vec3(0.21, 0.215, 0.225) * light + sheen, opacity);
    return;
  }
  if (finish == 1.0) {  // grip
    vec3 light = key_colour * clamp(dot(normal, key.xyz), 0.0, 1.0) + ambientLight(normal);
    vec3 glint = reflectedRoom(reflect(-to_eye, normal), 0.55, 1.0) * fresnel(facing, 0.04) * 0.8;
    colour = encode(vec3(0.030, 0.034, 0.040) * light + glint, opacity);
    return;
  }
  // The grain spreads reflections along the axis: three normals tilted that way stand for it.
  vec3 along = axis - normal * dot(normal, axis);
  float jitter = 0.10 * groove(local.z);
  vec3 room = vec3(0.0);
  for (int k = -1; k <= 1; ++k) {
    vec3 tilted = normalize(normal + along * (0.16 * float(k) + jitter));
    vec3 d = reflect(-to_eye, tilted);
    vec3 seen = reflectedRoom(d, 0.22, 1.0) + key_colour * 1.1 * strips(d);
    float towards_tissue = smoothstep(0.25, -0.35, d.z) * (1.0 - above);
    room += mix(seen, tissue.rgb * 0.55, 0.85 * towards_tissue);
  }
  room /= 3.0;
  vec3 metal = finish == 2.0 ? vec3(0.16, 0.34, 0.46) : vec3(0.60, 0.60, 0.61);
  vec3 reflectance = metal + (1.0 - metal) * fresnel(facing, 0.0);
  float tip = mix(0.55, 1.0, smoothstep(0.0, 0.5, above + max(normal.z, 0.0)));
  colour = encode(room * reflectance * tip, opacity);
}
