// What the tile renderer's programs and C++ share (gl_tiles.h says what each dispatch reads and writes): this file is included by both.
#ifndef ISOSTRATA_SHADERS_TILE_LAYOUT_H
#define ISOSTRATA_SHADERS_TILE_LAYOUT_H

#define TILE_SIDE_SHIFT 4       // a tile is 16 x 16 pixels
#define TILE_GROUP 256          // invocations of every work group; pixels of a tile; tetrahedra of a chunk
#define TILE_SCAN_TILE 2048     // elements of a scan that one work group adds up
#define TILE_SORT_TILE 2048     // pairs that one work group sorts
#define TILE_SORT_BITS 4        // of a digit
#define TILE_SORT_DIGITS 16
#define TILE_ROW_GROUPS 32768   // work groups along x; the rest goes along y

#define TILE_BLOCK_FRAME 0      // uniform block

// Storage buffers of all programs.
#define TILE_POSITIONS 0        // float: x, y, z per point, less the middle of the bounds, in units of their diagonal
#define TILE_TETRAHEDRA 1       // uvec4
#define TILE_INFO 2             // uint per tetrahedron: TILE_INFO_...
#define TILE_STYLES 3           // vec4: TILE_STYLE_ROWS per interval
#define TILE_COUNTERS 4         // uint: TILE_COUNT_...
#define TILE_CLIP_PLANES 5      // vec4: view space normal, offset: keeps dot(normal, p) >= offset
#define TILE_RUNS 6             // uint per tetrahedron: its run; then two uints per run: i | j << 16, k of its cell
// Of one program or the other.
#define TILE_ORDER 7            // uint: tetrahedra, nearest first
#define TILE_SUMS 8             // uint: counts, then sums of all before
#define TILE_PARTIALS 9         // uint per tile of a scan
#define TILE_PAIRS 10           // uvec2: key, tetrahedron
#define TILE_SORTED 11          // uvec2
#define TILE_GROUPS 12          // uvec4 per indirect dispatch
#define TILE_RANGES 13          // uvec2 per tile: its pairs' first and end
// Of blending, in place of the above.
#define TILE_BATCHES 8          // uint per tile, and one more: batches of all tiles before
#define TILE_LIGHT 9            // vec4 per pixel of a batch: premultiplied colour, what is let through
#define TILE_NEAREST 11         // float per pixel of a batch: the nearest u, only if depth is wanted; vec2, with mean depth, if that is
#define TILE_VALUES 7           // float per point: the color-by array
#define TILE_NORMALS 12         // float: x, y, z per point
#define TILE_TEXTURE 14         // float per point
#define TILE_SHADES 15          // float per point: of the light inside that is left (picture/body_shading.h)
// Of merging.
#define TILE_PICTURE 7          // uint or vec4 per pixel, row 0 the top row
#define TILE_DEPTH 10           // float per pixel; then the mean depths, if they are wanted

#define TILE_BUFFERS 15         // without TILE_SHADES, which is bound only where bodies are shaded

#define TILE_INFO_INTERVAL 0xffffu
#define TILE_INFO_TURNED 0x10000u // left-handed
#define TILE_INFO_FLAT 0x20000u   // of no volume: never drawn
#define TILE_FLAT 1e-12           // that is: six volumes over the longest edge's cube; below, single precision knows no normal
#define TILE_INFO_LABELS 18       // two bits for the facet opposite each point: 0 inside, 1 lower, 2 upper, 3 domain

// Rows of a style.
#define TILE_STYLE_COLOR 0      // rgb, extinction where the color-by value is color_lower
#define TILE_STYLE_LIGHT 1      // extinction at color_upper, first colour of the map or -1, colours less 1, group (0 is in front)
#define TILE_STYLE_RANGE 2      // color_lower, 1 / range, 0 hidden 1 sorted 2 needs no order, surfaces (1 lower, 2 upper, 4 domain)
#define TILE_STYLE_SURFACE 3    // rgb, opacity
#define TILE_STYLE_SHADING 4    // ambient, diffuse, specular, shininess
#define TILE_STYLE_TEXTURE 5    // silhouette, own colour, 0 none 1 stripes 2 map, first colour of the map
#define TILE_STYLE_TEXTURED 6   // scale, offset, colours less 1
#define TILE_STYLE_ROWS 7       // the maps' colours follow the last style

#define TILE_ORDER_NONE 0u
#define TILE_ORDER_INDEX 1u     // index distance of the cells from the eye's
#define TILE_ORDER_LIST 2u      // a list from the CPU

#define TILE_COUNT_PAIRS 0
#define TILE_COUNT_BATCHES 1
#define TILE_COUNT_FRAGMENTS 2  // and 3: the higher word
#define TILE_COUNT_LATE 4       // fragments that came after one that they hide
#define TILE_COUNT_BLENDED 5    // and 6: fragments that order was looked at of
#define TILE_COUNTER_WORDS 8

// Rows of the indirect dispatches.
#define TILE_GROUPS_SORT 0
#define TILE_GROUPS_SORT_SCAN 1
#define TILE_GROUPS_BLEND 2     // and one a slice
#define TILE_MOST_SLICES 64     // of blending: another program may draw between two of them

// Uniforms beside the block.
#define TILE_UNIFORM_SHIFT 0    // uint: of a sort: where the digit is
#define TILE_UNIFORM_ELEMENTS 1 // uint: of a scan; 0: the digits of all blocks of the sort
#define TILE_UNIFORM_TOTAL 2    // uint: of a scan: the counter that the total goes to, or TILE_COUNTER_WORDS
#define TILE_UNIFORM_PLAN 3     // uint: 0 plans the sort, 1 blending
#define TILE_UNIFORM_SLICES 4   // uint: of blending and its plan
#define TILE_UNIFORM_SLICE 5    // uint: of blending: which
// Of adopt_layers.comp, which is an extraction program as well (gl/layout.h): beside its UNIFORM_...
#define TILE_UNIFORM_TETRAHEDRA 6
#define TILE_UNIFORM_PLACE 7

#ifdef __cplusplus
namespace isostrata::shaders {
#define TILE_VEC4 struct { float x, y, z, w; }
#define TILE_UVEC4 struct { unsigned int x, y, z, w; }
#else
#define TILE_VEC4 vec4
#define TILE_UVEC4 uvec4
#endif

// Rows of four only, so that std140 and C++ agree.
struct TileFrame {
  TILE_VEC4 right, down, forward; // axes of view space, and what is added to a turned position
  TILE_VEC4 lens;               // pixels for a slope (perspective) or a length (orthographic) of 1; 1 / that; the middle of the picture in the part's pixels
  TILE_VEC4 limits;             // least depth, what is let through when a pixel is full, 1 perspective or 0 orthographic, 1 count fragments
  TILE_VEC4 background;         // rgb, 1 = keep alpha instead
  TILE_UVEC4 part;              // width, height, tiles along x, tiles along y
  TILE_UVEC4 keys;              // TILE_ORDER_..., bits below the group, bits below the tile, clip planes
  TILE_UVEC4 eye_cell;          // i, j, k; tetrahedra of the mesh
  TILE_UVEC4 room;              // tetrahedra to go through, pairs that there is room for, batches that there is room for, pairs in a batch
};

#ifdef __cplusplus
}  // namespace isostrata::shaders
#endif

#endif
