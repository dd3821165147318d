// surface_shading.h, line by line. Needs optics.glsl.
float mirrored(float periods) {
  float s = periods - 2.0 * floor(0.5 * periods);
  return 1.0 - abs(1.0 - s);
}

float stripe(float periods) {
  float s = periods - floor(periods);
  return saturate(0.5 + 16.0 * (0.25 - abs(s - 0.5)));
}

// base: the interval's colour there; normal, facet, view: of one space; view towards the eye. Premultiplied.
vec4 shade_surface(int style, vec3 base, vec3 normal, vec3 facet, vec3 view, float texture_value) {
  vec4 own = texelFetch(styles, STYLE_TEXELS * style + 2);
  vec4 light = texelFetch(styles, STYLE_TEXELS * style + 3);     // opacity, ambient, diffuse, specular
  vec4 finish = texelFetch(styles, STYLE_TEXELS * style + 4);    // shininess, silhouette, texture
  vec4 pattern = texelFetch(styles, STYLE_TEXELS * style + 5);
  vec3 color = own.w > 0.5 ? own.rgb : base;
  if (finish.z > TEXTURE_NONE + 0.5) {
    float periods = pattern.x * texture_value + pattern.y;
    if (abs(periods) < 1e6) {
      if (finish.z > TEXTURE_STRIPES + 0.5)
        color = map_color(finish.z, mirrored(periods));
      else
        color *= 1.0 - 0.8 * stripe(periods);
    }
  }
  float nn = dot(normal, normal);
  float trust = saturate((nn - 0.0625) * (1.0 / 0.1875));
  float carried = trust > 0.0 ? abs(dot(normal, view)) / sqrt(nn) : 0.0;
  float facing = dot(facet, facet) > 0.25 ? abs(dot(facet, view)) : 1.0;
  float c = saturate(trust * carried + (1.0 - trust) * facing);
  float lit = light.y + light.z * c;
  float glint = light.w > 0.0 ? light.w * pow(c, finish.x) : 0.0;
  float e = (1.0 - c) * (1.0 - c);
  float edge = finish.y * e * e;
  float alpha = light.x + (1.0 - light.x) * edge;
  float keep = alpha * (1.0 - edge);
  return vec4(saturate(keep) * clamp(color * lit + glint, 0.0, 1.0), saturate(alpha));
}
