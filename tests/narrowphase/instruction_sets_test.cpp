// Kernels are compiled for several instruction sets and chosen at run time: the answers must be the same bits on each.
#include <hwy/targets.h>
#include <cstring>
#include <string>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "one_instruction_set.h"
#include "pair_classes.h"
#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;

namespace {

class Bits {
 public:
  void add(double x) {
    std::uint64_t word;
    std::memcpy(&word, &x, sizeof word);
    words.push_back(word);
  }
  void add(const Vec3& v) {
    for (int k = 0; k < 3; ++k) add(v[k]);
  }
  void add(const PairAnswer& r) {
    add(r.signed_distance), add(r.point_a), add(r.point_b), add(r.normal), add(r.error_bound);
    words.push_back(r.collide), words.push_back(static_cast<std::uint64_t>(r.status));
  }
  void add(const std::vector<Contact>& contacts) {
    for (const Contact& c : contacts) add(c.point), add(c.normal), add(c.depth), words.push_back(c.feature);
  }

  std::vector<std::uint64_t> words;
};

void add_answers(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Bits& bits) {
  const NarrowPhase solver, wide({.tolerance = 0, .margin = 0.05, .solver = {}});
  bits.words.push_back(solver.solve(a, pose_a, b, pose_b, Request::collide).collide);
  bits.add(solver.solve(a, pose_a, b, pose_b, Request::distance));
  std::vector<Contact> contacts;
  bits.add(wide.solve(a, pose_a, b, pose_b, Request::contacts, &contacts));
  bits.add(contacts);
}

/// Answers in which all kernels take part: pairs of convex kinds in all classes, meshes. Except boxes screened several
/// at a time, which wide vectors may separate better.
Bits all_answers() {
  using namespace reference;
  constexpr ShapeRecipe kinds[] = {{ShapeKind::box},        {ShapeKind::capsule},     {ShapeKind::cylinder},
                                   {ShapeKind::cone},       {ShapeKind::ellipsoid},   {ShapeKind::convex, 16},
                                   {ShapeKind::convex, 40}, {ShapeKind::convex, 300}, {ShapeKind::triangle}};
  Bits bits;
  for (std::size_t i = 0; i < std::size(kinds); ++i)
    for (std::size_t j = i; j < std::size(kinds); ++j)
      for (const PairClass c : all_pair_classes)
        for (std::uint64_t k = 0; k < 3; ++k) {
          const PosedPair p = make_pair(kinds[i], kinds[j], c, k);
          add_answers(p.a, p.pose_a, p.b, p.pose_b, bits);
        }
  reference::Random r(3);
  const Shape ring(torus(1, 0.4, 24, 12)), crate(box_mesh({1, 2, 1.5}, 4));
  for (int k = 0; k < 12; ++k) {
    const Pose pose{r.rotation(), r.vec(-1.2, 1.2)};
    add_answers(ring, {}, crate, pose, bits);
    add_answers(ring, {}, Shape(Box{{0.5, 0.75, 1}}), pose, bits);
    for (const auto& [x, y] : NarrowPhase().intersecting_triangles(ring, {}, crate, pose))
      bits.words.push_back(x), bits.words.push_back(y);
  }
  return bits;
}

}  // namespace

TEST_CASE("instruction sets: the answers are the same bits on each that the processor has") {
  const Bits usual = all_answers();
  CHECK(usual.words.size() > 10000);
  const auto targets = hwy::SupportedAndGeneratedTargets();
  REQUIRE(!targets.empty());
  for (const std::int64_t target : targets) {
    CAPTURE(std::string(hwy::TargetName(target)));
    const OneInstructionSet only(target);
    CHECK(hwy::SupportedTargets() == target);
    CHECK((all_answers().words == usual.words));
  }
}
