// From linear light to the picture's sRGB values.

const float knee = 0.62;

// Leaves what is below the knee as it is and rolls off above, so that highlights keep their
// hue and colour maps their colours.
vec3 toneMap(vec3 c) {
  vec3 over = max(c - knee, 0.0) / (1.0 - knee);
  return min(c, vec3(knee)) + (1.0 - knee) * (1.0 - exp(-over));
}

// sRGB's transfer function (IEC 61966-2-1). Roots in place of the power 1/2.4: a minimax fit,
// within 0.1 of an 8-bit step, and several times quicker where shaders run on a CPU.
vec3 srgb(vec3 c) {
  vec3 r = sqrt(c);
  vec3 power = 0.83372815 * r + 0.29812780 * sqrt(r) - 0.05530703 * c - 0.07690760;
  return mix(12.92 * c, power, step(vec3(0.0031308), c));
}

// A pattern without low frequencies, one 8-bit step wide: gradients show no bands.
float dither(vec2 pixel) {
  return (fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5) / 255.0;
}

vec4 encode(vec3 linear, float alpha) { return vec4(srgb(toneMap(linear)) + dither(gl_FragCoord.xy), alpha); }

// The same for light that is known to stay below the knee.
vec4 encodeDim(vec3 linear) { return vec4(srgb(linear) + dither(gl_FragCoord.xy), 1.0); }
