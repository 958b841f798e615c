#include "pairs/methods.h"

#include <utility>

#include "shapes/pair_order.h"
#include "shapes/support.h"

namespace tandem {

bool is_built(Method method) {
#ifdef TANDEM_PEER_SOLVERS
  constexpr bool with_peers = true;
#else
  constexpr bool with_peers = false;
#endif
  return with_peers || (method != Method::fcl && method != Method::libccd && method != Method::mpr);
}

std::optional<Method> find_method(std::string_view solver) {
  for (std::size_t i = 0; i < method_names.size(); ++i)
    if (method_names[i] == solver && is_built(static_cast<Method>(i))) return static_cast<Method>(i);
  return std::nullopt;
}

namespace {

constexpr bool has_point_distance(ShapeKind kind) {
  return kind != ShapeKind::ellipsoid && kind != ShapeKind::convex && kind != ShapeKind::mesh;
}

constexpr bool covered(Method method, ShapeKind a, ShapeKind b) {
  if (a == ShapeKind::mesh || b == ShapeKind::mesh) return method == Method::bvh;
  if (rank(a) > rank(b)) std::swap(a, b);
  switch (method) {
    case Method::closed:
      return a == ShapeKind::halfspace || (a == ShapeKind::sphere && has_point_distance(b)) ||
             (a == ShapeKind::box && b == ShapeKind::capsule) || (a == ShapeKind::capsule && b == ShapeKind::capsule);
    case Method::sat:
      return (a == ShapeKind::box && (b == ShapeKind::box || b == ShapeKind::triangle)) ||
             (a == ShapeKind::triangle && b == ShapeKind::triangle);
    case Method::newton:
      if (a == ShapeKind::sphere) return b == ShapeKind::ellipsoid;
      return a != ShapeKind::halfspace && !(is_polytope(a) && is_polytope(b));
    case Method::bvh:
      return false;
    default:
      return a != ShapeKind::halfspace;
  }
}

constexpr auto best_methods = [] {
  std::array<std::array<Method, shape_kinds>, shape_kinds> table{};
  for (std::size_t a = 0; a < shape_kinds; ++a)
    for (std::size_t b = 0; b < shape_kinds; ++b) {
      const auto ka = static_cast<ShapeKind>(a), kb = static_cast<ShapeKind>(b);
      table[a][b] = covered(Method::closed, ka, kb)   ? Method::closed
                    : covered(Method::sat, ka, kb)    ? Method::sat
                    : covered(Method::newton, ka, kb) ? Method::newton
                                                      : Method::gjk;
    }
  return table;
}();

}  // namespace

bool covers(Method method, ShapeKind a, ShapeKind b) { return covered(method, a, b); }

Method best_method(ShapeKind a, ShapeKind b) {
  return best_methods[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
}

}  // namespace tandem
