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

#endif
