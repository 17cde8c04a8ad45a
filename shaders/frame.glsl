// What all shaders know about the picture; app/render/frame.h fills it. Lengths in m, world coordinates.
layout(std140) uniform Frame {
  mat4 clip_from_world;
  mat4 shadow_from_world;  // key light's shadow map, 0..1
  vec4 eye;                // xyz
  vec4 key;                // xyz: unit vector towards the key light; w: offset along the normal for shadow lookups
  vec4 tool_begin;         // xyz: centre of the tool's tip; w: its radius, 0 without a tool
  vec4 tool_end;           // xyz: other end of the axis; w: the tissue's imposed-region hint, 0 or 1
  vec4 ground;             // xyz: where the organ stands; w: its radius
  vec4 picture;            // width, height, pixel ratio; w: 1 where the skin shows a field, 2 where it does on paper
  vec4 tissue;             // rgb: albedo, linear; w: patterns per m
};
