// From linear light to the picture's sRGB values.

// Leaves what is below the knee as it is and rolls off above, so that highlights keep their
// hue and colour maps their colours.
vec3 toneMap(vec3 c) {
  const float knee = 0.62;
  vec3 over = max(c - knee, 0.0) / (1.0 - knee);
  return min(c, vec3(knee)) + (1.0 - knee) * (1.0 - exp(-over));
}

// A pattern without low frequencies, one 8-bit step wide: gradients show no bands.
float dither(vec2 pixel) {
  return (fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5) / 255.0;
}

vec4 encode(vec3 linear, float alpha) {
  vec3 c = toneMap(linear);
  vec3 srgb = mix(12.92 * c, 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055,
                  step(vec3(0.0031308), c));
  return vec4(srgb + dither(gl_FragCoord.xy), alpha);
}
