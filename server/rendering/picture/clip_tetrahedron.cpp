#include "rendering/picture/clip_tetrahedron.h"

namespace isostrata {
namespace {

ClipVertex cut(const ClipVertex& inside, double d_inside, const ClipVertex& outside, double d_outside) {
  const double t = d_inside / (d_inside - d_outside);
  return {lerp(inside.position, outside.position, t), inside.scalar + (outside.scalar - inside.scalar) * t,
          inside.shade + (outside.shade - inside.shade) * t};
}

/// The prism between the triangles p and q as three tetrahedra.
void add_prism(const std::array<ClipVertex, 3>& p, const std::array<ClipVertex, 3>& q, std::vector<ClipTetrahedron>& out) {
  out.push_back({p[0], p[1], p[2], q[2]});
  out.push_back({p[0], p[1], q[1], q[2]});
  out.push_back({p[0], q[0], q[1], q[2]});
}

}  // namespace

void clip_tetrahedra(std::vector<ClipTetrahedron>& pieces, Vec3d normal, double offset) {
  std::vector<ClipTetrahedron> kept;
  for (const ClipTetrahedron& piece : pieces) {
    std::array<int, 4> inside{}, outside{};
    std::array<double, 4> d{};
    int in = 0, out = 0;
    for (int v = 0; v < 4; ++v) {
      d[static_cast<std::size_t>(v)] = dot(normal, piece[static_cast<std::size_t>(v)].position) - offset;
      if (d[static_cast<std::size_t>(v)] >= 0)
        inside[static_cast<std::size_t>(in++)] = v;
      else
        outside[static_cast<std::size_t>(out++)] = v;
    }
    const auto vertex = [&](int v) { return piece[static_cast<std::size_t>(v)]; };
    const auto between = [&](int a, int b) {
      return cut(vertex(a), d[static_cast<std::size_t>(a)], vertex(b), d[static_cast<std::size_t>(b)]);
    };
    if (in == 4) {
      kept.push_back(piece);
    } else if (in == 3) {
      const int o = outside[0];
      add_prism({vertex(inside[0]), vertex(inside[1]), vertex(inside[2])},
                {between(inside[0], o), between(inside[1], o), between(inside[2], o)}, kept);
    } else if (in == 2) {
      const int a = inside[0], b = inside[1], c = outside[0], e = outside[1];
      add_prism({vertex(a), between(a, c), between(a, e)}, {vertex(b), between(b, c), between(b, e)}, kept);
    } else if (in == 1) {
      const int a = inside[0];
      kept.push_back({vertex(a), between(a, outside[0]), between(a, outside[1]), between(a, outside[2])});
    }
  }
  pieces.swap(kept);
}

}  // namespace isostrata
