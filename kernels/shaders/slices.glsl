// The slices of a volume lie side by side in a texture, in rows: `slices` is their width, their height and how many are in a
// row. Where the texel of `site` is, whose x and y count texels of its slice and whose z counts slices.
vec2 texel_of(vec3 site, vec3 slices) {
  float row = floor((site.z + 0.5) / slices.z);
  return site.xy + slices.xy * vec2(site.z - slices.z * row, row);
}
