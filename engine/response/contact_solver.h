#pragma once
#include <cstdint>
#include <vector>

#include "response/parallel_blocks.h"
#include "tandem/engine/response.h"

namespace tandem {

/// What the solver knows of a body; a fixed one has no inverse mass, and its velocity stays.
struct SolverBody {
  Vec3 velocity = Vec3::Zero();  ///< of the centre of mass
  Vec3 angular_velocity = Vec3::Zero();
  double inverse_mass = 0;
  Mat3 inverse_inertia = Mat3::Zero();  ///< world axes, at the beginning of the step
  Vec3 moved = Vec3::Zero();            ///< since the beginning of the step
  Vec3 turned = Vec3::Zero();           ///< the same, as a rotation vector, to first order
  Vec3 centre = Vec3::Zero();           ///< of mass, at the beginning of the step
  double radius = 0;
  bool is_sensor = false;  ///< pushes nothing
};

/// Contacts as constraints on velocities, solved by sequential impulses. Pairs are given colours, in the order of the
/// contact list, so that no moving body meets two pairs of one colour: colours are solved one after the other, the
/// pairs of one in parallel. The order depends on the contacts alone, and so does the motion.
class ContactSolver {
 public:
  /// `parallel` counts what threads may share.
  explicit ContactSolver(ParallelTime& parallel) : parallel_(parallel) {}
  /// Takes over a step's contacts; impulses of those that were there in the step before are kept.
  void prepare(const ContactList& contacts, const std::vector<SolverBody>& bodies, const ResponseOptions& options);
  /// `h`: length of a sub-step.
  void begin_substeps(double h, const ResponseOptions& options);
  void warm_start(std::vector<SolverBody>& bodies);
  enum class Overlap { push_out, leave };
  void solve(std::vector<SolverBody>& bodies, Overlap overlap);

 private:
  struct Point {
    Vec3 arm_a, arm_b;  // from the centres of mass
    Vec3 normal, tangent, bitangent;
    double gap = 0;
    double normal_mass = 0;
    double tangent_mass = 0, mixed_mass = 0, bitangent_mass = 0;
    double normal_impulse = 0, tangent_impulse = 0, bitangent_impulse = 0;
    std::uint32_t feature = 0;
    bool keeps = false, kept = false;  // impulses of the step before; its own, in the next
  };
  struct Pair {
    std::uint32_t a = 0, b = 0;
    std::uint32_t first = 0, end = 0;  // of its points
    Mat3 rolling_mass;
    Vec3 rolling_impulse;
    double rolling_radius = 0;
  };

  /// A pair of the contact list that takes part, in the list's order.
  struct Entry {
    std::uint64_t key = 0;  // a, b
    std::uint32_t found = 0;
    std::uint32_t colour = 0, points = 0;
    std::uint32_t place = 0;  // in pairs_
  };
  // A body's colours are bits of a word; pairs that find none left are solved one by one at the end.
  static constexpr std::uint32_t colours = 64;

  void give_colours(const ContactList& contacts, const std::vector<SolverBody>& bodies);
  void prepare_pair(const Entry& entry, const ContactList& contacts, const std::vector<SolverBody>& bodies);
  void prepare_point(Point& point, const Contact& contact, const SolverBody& a, const SolverBody& b) const;
  void keep_impulses(Pair& pair, const Pair& before);
  static void keep_impulse(Point& point, Point& before);
  template <class Body>
  void for_each_pair(std::vector<SolverBody>& bodies, const Body& body) const;
  void solve_pair(Pair& pair, SolverBody& a, SolverBody& b, Overlap overlap);

  ParallelTime& parallel_;
  std::vector<Entry> entries_, entries_before_;
  std::vector<std::uint64_t> taken_;  // colours, a body
  std::vector<std::uint32_t> colour_ends_;
  // In the colours' order.
  std::vector<Point> points_, points_before_;
  std::vector<Pair> pairs_, pairs_before_;
  double friction_ = 0, rolling_resistance_ = 0, max_push_out_ = 0;
  double inverse_h_ = 0;
  double bias_rate_ = 0, mass_scale_ = 1, impulse_scale_ = 0;
};

}  // namespace tandem
