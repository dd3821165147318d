// Numbers that C++ and GLSL share: this file is included by both.
#ifndef ISOSTRATA_SHADERS_LAYOUT_H
#define ISOSTRATA_SHADERS_LAYOUT_H

// Vertex attributes of a projected tetrahedron or facet (projected_tetrahedra.h has the struct).
#define ATTRIBUTE_POSITION 0    // vec3: pixels right of and above the middle of the picture, nearness; where KIND_HOMOGENEOUS: x, y, w
#define ATTRIBUTE_TENT 1        // vec3
#define ATTRIBUTE_Q_MIN 2       // float
#define ATTRIBUTE_STYLE 3       // uint: style << KIND_BITS | kind
#define ATTRIBUTE_SCALAR 4      // vec2: scalar (times nearness, in perspective), its slope against nearness
#define ATTRIBUTE_ID 5          // uint: the first word of the tent, of kinds that have no tent: which tetrahedron, which facet
#define ATTRIBUTE_SHADE 6       // vec2: the share of the light that is left (times nearness, in perspective), its slope against nearness

// What a vertex belongs to.
#define KIND_BITS 3
#define KIND_MASK 7u
#define KIND_FRONT 0            // a tetrahedron's face towards the eye, with its tent
#define KIND_BACK 1             // a face away from the eye, with its tent
#define KIND_SURFACE 2          // a boundary facet
#define KIND_HOMOGENEOUS 4      // bit: too near the eye or too far aside to be divided by depth here; clipped by OpenGL
#define KIND_WIDE 5             // homogeneous: a back face; entry and exit are found for each fragment from the four points
#define VERTEX_WORDS 8
#define LINEAR_VERTEX_WORDS 10
#define SHADED_VERTEX_WORDS 12

// Uniform block of the drawing programs and of projection.
#define BLOCK_FRAME 1

// Uniform of projection.
#define UNIFORM_BATCH 0         // uvec4: the first tetrahedron of the list, how many, 0, 0

// Uniforms of the resolve program.
#define UNIFORM_BACKGROUND 0    // vec4: rgb, 1 = keep alpha instead
#define UNIFORM_SIZE 1          // vec2: of the tile

// Texture units.
#define UNIT_STYLES 0           // buffer: STYLE_TEXELS a style
#define UNIT_MAPS 1             // 2D: one colour map a row
#define UNIT_TABLES 2           // 2D array: a table over length and mean scalar for each kind of style that is not constant
#define UNIT_ACCUMULATED 0      // of the resolve program

// Texels of a style: (r, g, b, extinction at u = 0), (map row or -1, scale, offset of u, extinction at u = 1), then of its surface
// (r, g, b, 1 = own colour), (opacity, ambient, diffuse, specular), (shininess, silhouette, texture's map row or TEXTURE_..., layer of the
// table), (texture scale, offset, 0, 0).
#define STYLE_TEXELS 6
#define TEXTURE_NONE -2.0
#define TEXTURE_STRIPES -1.0

// Storage buffers of drawing and projection.
#define BUFFER_MESH_POINTS 0    // vec4 per point: (position - centre) / scale, color-by value
#define BUFFER_MESH_CELLS 1     // uvec4 per tetrahedron
#define BUFFER_FACETS 2         // FacetCorner, three a facet
#define BUFFER_PLANES 3         // vec4 per clip plane: view space; keeps dot(xyz, position) >= w
#define BUFFER_DRAWN_ORDER 4    // uint: tetrahedra, back to front
#define BUFFER_INTERVALS 5      // uint per two tetrahedra: their intervals, 16 bits each
#define BUFFER_DRAWN_PARTS 6    // uint per interval: DRAW_... bits
#define BUFFER_VERTICES 7       // what projection writes: a region of GROUP_VERTICES(...) for each group
#define BUFFER_COMMANDS 8       // DrawCommand per group
#define BUFFER_FACET_OF 9       // uint per tetrahedron: its first facet or NO_FACET
#define BUFFER_FACET_CELLS 10   // uvec2 per facet, by tetrahedron: the tetrahedron, its interval * 4 + label
#define BUFFER_SHADES 11        // float per point of the mesh, only where bodies are shaded (picture/body_shading.h)
#define DRAW_VOLUME 1u
#define DRAW_LABEL 2u           // << label
#define NO_FACET 0xffffffffu
#define PROJECT_GROUP 128       // tetrahedra that one work group projects
#define PROJECTED_VERTICES 12   // the most of a tetrahedron: four back faces
#define FACET_VERTICES 12       // the most of its facets

// ---- extraction (gl_extractor.h says what each dispatch reads and writes) ----------------------------------------------------------

#define BRICK_GROUP 64          // invocations for a brick of 8^3 cells: one for each of its 64 rows of 8
#define SCAN_GROUP 256          // invocations of a scan's work group
#define SCAN_TILE 1024          // elements of a scan that one work group adds up
#define RECORD_GROUP 64         // records that one work group expands
#define COUNTED_IN_GROUP 32     // intervals that are counted in a work group before they are added up in memory
#define ISO_VERTICES 32         // of a hexahedron
#define HEXAHEDRON_CASES 6561

// A case's word in the tables: where its tetrahedra begin, and how many.
#define CASE_COUNT_BITS 5
// A record's second word: the case, which way the cell is turned (0 not known, 1 right-handed, 2 left-handed), the interval.
#define RECORD_CASE_MASK 0x1fffu
#define RECORD_HAND_SHIFT 13
#define RECORD_INTERVAL_SHIFT 16
// An isovertex's word: its owner's offset from the cell's first point (1 bit each for x, y, z), the edge's axis (3: none), 1 if on the upper isovalue.
#define ISO_AXIS_SHIFT 3
#define ISO_UPPER_SHIFT 5

#define BLOCK_GRID 0            // uniform block

// Storage buffers. OpenGL 4.5 promises 8 of them to a compute program; all drivers met give 16 or more, and fewer than
// STORAGE_BUFFERS are refused.
#define STORAGE_BUFFERS 15
#define BUFFER_FIELD 0          // the values of one part of the grid, as they are in memory
#define BUFFER_RANGES 1         // IsoRange per brick
#define BUFFER_RULES 2          // IsoKeys per interval, by lower end
#define BUFFER_COUNTERS 3       // ExtractionCounters
#define BUFFER_BRICKS 4         // uint per active brick: which
#define BUFFER_ROWS 5           // uint per row of bricks, and one more: active bricks before it
#define BUFFER_GROUPS 6         // WorkGroups per slice of an indirect dispatch
#define BUFFER_SUMS 7           // uvec2 per element: counts, then sums of all before
#define BUFFER_PARTIALS 8       // uvec2 per tile of a scan
#define BUFFER_TABLES 9         // uint: ISO_VERTICES, HEXAHEDRON_CASES words, then four isovertices a tetrahedron
#define BUFFER_RECORDS 10       // CellRecord
#define BUFFER_FIRST 11         // uint per record: tetrahedra before it
#define BUFFER_TALLY 12         // IntervalTally per interval
#define BUFFER_ABSENT 13        // 512 bits per brick: cells that are hidden or not finite
#define BUFFER_POINTS 14        // positions of one part of a curvilinear grid
// The bindings of expansion, in buffers that classification does not need at the same time.
#define BUFFER_RANKS 1          // uint per brick: active bricks before it
#define BUFFER_SLOTS 7          // SLOT_WORDS uints per point of an active brick: the mesh points that it owns
#define BUFFER_OWNED 8          // uvec2 per active brick: x is the mesh points of all bricks before
#define BUFFER_ISOVALUES 2      // IsoLevel per isovalue, then per interval its pair of isovalues
#define BUFFER_AXES 9           // double: anchor x, y, z; then the axes of a rectilinear grid
#define BUFFER_RULES_OF_POINTS 1 // IsoKeys per interval
#define BUFFER_POSITIONS 10     // vec4 per mesh point: position less anchor, value
#define BUFFER_ORIGINS 11       // MeshPointOrigin per mesh point
#define BUFFER_TETRAHEDRA 12    // uvec4

// Uniforms of all compute programs.
#define UNIFORM_SLICE 0         // uint: of an indirect dispatch: which WorkGroups
#define UNIFORM_PART_LAYER 1    // uint: the first layer of points in the part
#define UNIFORM_FIRST 2         // uint: of a direct dispatch: its first group; of a scan: which counter; of a plan: its first slice
#define UNIFORM_COUNT 3         // uint: of a scan: elements per count; of a plan: its slices
#define UNIFORM_SPAN 4          // uvec4: of a plan: groups a slice, items a group, first row of bricks or the counter, end of rows or 0

// Which counter a scan's or a plan's length comes from, in the order of ExtractionCounters.
#define COUNT_BRICKS 0
#define COUNT_RECORDS 1
#define COUNT_POINTS 3
#define COUNT_TILES 8

#ifdef __cplusplus
namespace isostrata::shaders {
typedef unsigned int uint;
struct vec4 {
  float x, y, z, w;
};
struct uvec4 {
  uint x, y, z, w;
};
#endif

struct RasterFrame {            // uniform block. View space: x right, y up, z away from the eye, in units of the data's scale
  vec4 view_x, view_y, view_z;  // rows: view = dot(row.xyz, point) + row.w
  vec4 screen;                  // focal length in pixels (orthographic: pixels a unit), near depth, base of nearness, q_min of all
  vec4 picture;                 // half width and height in pixels; where pixel centres lie against whole numbers, x and y
  vec4 clip_from_pixels;        // scale x, y, offset x, y
  vec4 ray_from_fragment;       // scale x, y, offset x, y: the ray (x, y, 1) of gl_FragCoord; orthographic: its x and y
  vec4 table;                   // unit distance of the tables' lengths; guard in pixels; largest depth ratio; 0
  uvec4 counts;                 // clip planes, 0, 0, 1 = points have normals
  vec4 axis;                    // where the axis of view meets the picture: pixels right of and above its middle; 0, 0
};

struct FacetCorner {
  vec4 position_scalar;         // as the mesh's points
  vec4 normal_texture;          // normal in the mesh's space
};

struct DrawCommand {            // glMultiDrawArraysIndirect
  uint count, instances, first, base_instance;
};

struct ExtractionGrid {         // uniform block
  uint points_x, points_y, points_z;
  uint bricks_x, bricks_y, bricks_z;
  uint rules;                   // intervals that some value of the field's type can be in
  uint isovalues;
  uint brick_capacity, record_capacity, tetrahedron_capacity, point_capacity;
};

struct ExtractionCounters {
  uint bricks;                  // active
  uint records;
  uint tetrahedra;              // 2^32 - 1 stands for that or more, as it does for records and points
  uint points;
  uint active_cells;            // in at least one interval
  int balance;                  // right-handed less left-handed active cells
  uint any_absent;              // some cell is absent for its values or positions
  uint unused;
  uint tiles;                   // of bricks
};

struct IsoRange {               // of the finite values around a brick, as keys (field_keys.h); lower > upper if there is none
  uint lower_high, lower_low, upper_high, upper_low;
};

struct IsoKeys {                // one interval
  uint lower_high, lower_low;   // the smallest key that is not below
  uint last_high, last_low;     // the largest key that is not above
  uint reach_high, reach_low;   // the largest `last` of this and all earlier ones
  uint interval;                // in the request
  uint unused;
};

struct IsoLevel {               // one isovalue: keys above `below` are on its upper side
  uint below_high, below_low;
  uint value_high, value_low;   // the double
};

struct CellRecord {
  uint cell;
  uint case_interval;
};

struct IntervalTally {
  uint records;
  uint tetrahedra;
};

struct WorkGroups {
  uint x, y, z;                 // what an indirect dispatch reads
  uint first;                   // group of the list that the slice begins with
};

struct MeshPointOrigin {
  uint point;                   // of the grid, that owns it
  uint slot;                    // 0: the point itself; 1 + axis * isovalues + i: where its edge along the axis crosses isovalue i
};

#ifdef __cplusplus
}  // namespace isostrata::shaders
#endif

#endif
