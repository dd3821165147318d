// What the extraction programs left, in the form that the tile renderer draws (tile_layout.h). POINTS: one mesh point an invocation. Else, after
// those: one record, which is a cell in one interval, with all of its tetrahedra.
layout(local_size_x = TILE_GROUP) in;
layout(location = UNIFORM_FIRST) uniform uint first_group;
layout(location = UNIFORM_COUNT) uniform uint count;  // of points, or of records
layout(location = TILE_UNIFORM_TETRAHEDRA) uniform uint tetrahedron_count;
layout(location = TILE_UNIFORM_PLACE) uniform vec4 place;  // the middle of the bounds less the anchor; units of their diagonal in one of the world

#ifdef POINTS
layout(std430, binding = BUFFER_POSITIONS) readonly restrict buffer FoundBuffer { vec4 found[]; };
layout(std430, binding = TILE_POSITIONS) writeonly restrict buffer PositionBuffer { float positions[]; };
layout(std430, binding = TILE_VALUES) writeonly restrict buffer ValueBuffer { float values[]; };
#else
layout(std430, binding = BUFFER_RECORDS) readonly restrict buffer RecordBuffer { CellRecord records[]; };
layout(std430, binding = BUFFER_FIRST) readonly restrict buffer FirstBuffer { uint first_tetrahedron[]; };
layout(std430, binding = TILE_POSITIONS) readonly restrict buffer PositionBuffer { float positions[]; };
layout(std430, binding = TILE_TETRAHEDRA) readonly restrict buffer TetrahedronBuffer { uvec4 tetrahedra[]; };
layout(std430, binding = TILE_INFO) writeonly restrict buffer InfoBuffer { uint infos[]; };
layout(std430, binding = TILE_RUNS) writeonly restrict buffer RunBuffer { uint runs[]; };

dvec3 point(uint p) { return dvec3(positions[3u * p], positions[3u * p + 1u], positions[3u * p + 2u]); }

// As TileMesh tells of a mesh from the CPU: which way it is turned, and whether single precision knows its normals.
uint shape_of(uvec4 corners) {
  dvec3 a = point(corners.x), edges[3] = dvec3[3](point(corners.y) - a, point(corners.z) - a, point(corners.w) - a);
  double volumes = dot(cross(edges[0], edges[1]), edges[2]);
  double longest = max(max(dot(edges[0], edges[0]), dot(edges[1], edges[1])), dot(edges[2], edges[2]));
  for (int i = 0; i < 3; ++i) {
    dvec3 across = edges[(i + 1) % 3] - edges[i];
    longest = max(longest, dot(across, across));
  }
  uint shape = volumes < 0.0 ? TILE_INFO_TURNED : 0u;
  return abs(volumes) > TILE_FLAT * longest * sqrt(longest) ? shape : shape | TILE_INFO_FLAT;
}
#endif

void main() {
  uint i = (first_group + gl_WorkGroupID.x) * TILE_GROUP + gl_LocalInvocationIndex;
  if (i >= count) return;
#ifdef POINTS
  vec4 p = found[i];
  vec3 at = (p.xyz - place.xyz) * place.w;
  positions[3u * i] = at.x;
  positions[3u * i + 1u] = at.y;
  positions[3u * i + 2u] = at.z;
  values[i] = p.w;
#else
  CellRecord record = records[i];
  uint end = i + 1u < count ? first_tetrahedron[i + 1u] : tetrahedron_count;
  for (uint t = first_tetrahedron[i]; t < end; ++t) {
    infos[t] = (record.case_interval >> RECORD_INTERVAL_SHIFT) | shape_of(tetrahedra[t]);
    runs[t] = i;
  }
  uint cells_x = max(grid.points_x, 2u) - 1u, cells_y = max(grid.points_y, 2u) - 1u, row = record.cell / cells_x;
  runs[tetrahedron_count + 2u * i] = (record.cell - row * cells_x) | (row % cells_y) << 16;
  runs[tetrahedron_count + 2u * i + 1u] = row / cells_y;
#endif
}
