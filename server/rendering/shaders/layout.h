// Numbers that C++ and GLSL share: this file is included by both.
#ifndef ISOSTRATA_SHADERS_LAYOUT_H
#define ISOSTRATA_SHADERS_LAYOUT_H

// Vertex attributes of a projected tetrahedron (projected_tetrahedra.h has the struct).
#define ATTRIBUTE_POSITION 0    // vec3: pixels right of and above the middle of the picture, inverse depth
#define ATTRIBUTE_TENT 1        // vec3
#define ATTRIBUTE_Q_MIN 2       // float
#define ATTRIBUTE_STYLE 3       // uint: 2 * style + (1 where the drawn face is at the back)
#define ATTRIBUTE_SCALAR 4      // vec2: scalar times inverse depth, its slope against inverse depth

// Uniforms of the tetrahedra's program.
#define UNIFORM_CLIP_FROM_PIXELS 0  // vec4: scale x, y, offset x, y
#define UNIFORM_RAY_FROM_FRAGMENT 1 // vec4: scale x, y, offset x, y: the ray (x, y, 1) of gl_FragCoord

// Uniforms of the resolve program.
#define UNIFORM_BACKGROUND 0    // vec4: rgb, 1 = keep alpha instead
#define UNIFORM_SIZE 1          // vec2: of the tile

// Texture units.
#define UNIT_STYLES 0           // buffer: two texels a style: (r, g, b, extinction), (map row or -1, scale, offset, 0)
#define UNIT_MAPS 1             // 2D: one colour map a row
#define UNIT_ACCUMULATED 0      // of the resolve program

// ---- extraction (gl_extraction.h says what each dispatch reads and writes) ----------------------------------------------------------

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
#endif

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

struct IsoRange {               // of the finite values around a brick, as keys (field_keys.h); lower > upper where there is none
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
