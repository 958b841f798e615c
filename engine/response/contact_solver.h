// Solves contacts as constraints on velocities.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "response/parallel_blocks.h"
#include "tandem/engine/response.h"

namespace tandem {

/// A body as the solver sees it; a fixed one has no inverse mass, and its velocity stays.
struct SolverBody {
  Vec3 velocity = Vec3::Zero();  ///< of the centre of mass
  Vec3 angular_velocity = Vec3::Zero();
  double inverse_mass = 0;
  Mat3 inverse_inertia = Mat3::Zero();  ///< world axes, at the beginning of the step
  Vec3 moved = Vec3::Zero();            ///< translation since the beginning of the step
  /// Rotation since the beginning of the step, as a rotation vector, to first order.
  Vec3 turned = Vec3::Zero();
  Vec3 centre = Vec3::Zero();  ///< centre of mass at the beginning of the step
  double radius = 0;
  bool is_sensor = false;  ///< collides, but receives and exerts no impulses
};

/// The data of a point of contact that the next step needs, as plain numbers.
struct KeptPoint {
  std::array<double, 3> arm_a{}, arm_b{}, tangent{}, bitangent{};
  double normal_impulse = 0, tangent_impulse = 0, bitangent_impulse = 0;
  std::uint64_t feature = 0;
};

/// The colours that a body's pairs have so far, to find the next free one.
class TakenColours {
 public:
  void take(std::uint32_t colour) {
    if (colour < word)
      taken_ |= std::uint64_t{1} << colour;
    else
      next_ = colour + 1;
  }
  /// The first colour that a pair of two bodies may have.
  static std::uint32_t first_free(const TakenColours& a, const TakenColours& b) {
    const auto colour = static_cast<std::uint32_t>(std::countr_one(a.taken_ | b.taken_));
    return colour < word ? colour : std::max(a.next_, b.next_);
  }

 private:
  static constexpr std::uint32_t word = 64;
  // Bits of the first colours; a pair that finds all taken comes after all colours of either body.
  std::uint64_t taken_ = 0;
  std::uint32_t next_ = word;  // after the last of the other colours
};

/// Contacts as constraints on velocities, solved by sequential impulses. Pairs are given colours, in the order of the
/// contact list, so that no moving body meets two pairs of one colour: colours are solved one after the other, the
/// pairs of one in parallel. The order depends on the contacts alone, and so does the motion.
///
/// Several solvers may share a list: each receives the colours of its own pairs, which were assigned in the order of
/// the whole list, and others change its bodies' velocities after each colour.
class ContactSolver {
 public:
  /// `parallel` measures the time that threads may share.
  explicit ContactSolver(ParallelTime& parallel) : parallel_(parallel) {}
  /// Takes the contacts of a step; impulses of contacts that existed in the step before are kept.
  void prepare(const ContactList& contacts, const std::vector<SolverBody>& bodies, const ResponseOptions& options);
  /// `h`: length of a sub-step.
  void begin_substeps(double h, const ResponseOptions& options);
  /// Called after each colour has been solved, in ascending order.
  using AfterColour = std::function<void(std::uint32_t colour)>;
  void warm_start(std::vector<SolverBody>& bodies, const AfterColour& after = {});
  enum class Overlap { push_out, leave };
  void solve(std::vector<SolverBody>& bodies, Overlap overlap, const AfterColour& after = {});

  static constexpr std::uint32_t none = 0xffffffffu;
  /// The input of a solver of a share of all pairs, one element a pair of its list.
  struct Share {
    std::span<const std::uint32_t> colours;  ///< none: the pair does not take part
    std::span<const std::uint32_t> before;   ///< the pair's place in the step before, or none
  };
  void prepare_share(const ContactList& contacts, const std::vector<SolverBody>& bodies, const ResponseOptions& options,
                     const Share& share);
  /// True if a pair of the list moves a body.
  static bool takes_part(const PairResult& pair, const std::vector<SolverBody>& bodies) {
    const SolverBody &a = bodies[pair.a], &b = bodies[pair.b];
    return pair.contact_count != 0 && (a.inverse_mass != 0 || b.inverse_mass != 0) && !a.is_sensor && !b.is_sensor;
  }
  /// Visits the pairs of the list with their places in the step: visit(pair, place).
  template <class Visit>
  void each_place(const Visit& visit) const {
    for (const Entry& entry : entries_) visit(entry.found, entry.place);
  }
  /// Copies the data of the pair at a place, for the next step in another solver; appends its points. Returns the
  /// impulse against rolling.
  Vec3 kept(std::uint32_t place, std::vector<KeptPoint>& points) const;
  /// Takes the data of a pair from another solver; returns its place, for the next Share.
  std::uint32_t take_in(const Vec3& rolling_impulse, std::span<const KeptPoint> points);

 private:
  struct Point {
    Vec3 arm_a, arm_b;  // from the centres of mass
    Vec3 normal, tangent, bitangent;
    double gap = 0;
    double normal_mass = 0;
    double tangent_mass = 0, mixed_mass = 0, bitangent_mass = 0;
    double normal_impulse = 0, tangent_impulse = 0, bitangent_impulse = 0;
    std::uint32_t feature = 0;
    bool keeps = false, kept = false;  // impulses are kept from the step before; kept for the next step
  };
  struct Pair {
    std::uint32_t a = 0, b = 0;
    std::uint32_t first = 0, end = 0;  // range of its points
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

  void begin(const ResponseOptions& options);
  void give_colours(const ContactList& contacts, const std::vector<SolverBody>& bodies);
  void add_entry(const ContactList& contacts, std::uint32_t found, std::uint32_t colour);
  void arrange();
  void prepare_pair(const Entry& entry, const ContactList& contacts, const std::vector<SolverBody>& bodies);
  void prepare_point(Point& point, const Contact& contact, const SolverBody& a, const SolverBody& b) const;
  void keep_impulses(Pair& pair, const Pair& before);
  static void keep_impulse(Point& point, Point& before);
  template <class Body>
  void for_each_pair(std::vector<SolverBody>& bodies, const AfterColour& after, const Body& body) const;
  void solve_pair(Pair& pair, SolverBody& a, SolverBody& b, Overlap overlap);

  ParallelTime& parallel_;
  std::vector<Entry> entries_, entries_before_;
  std::vector<TakenColours> taken_;  // one for each body
  std::vector<std::uint32_t> colour_ends_, first_points_;
  // In the colours' order.
  std::vector<Point> points_, points_before_;
  std::vector<Pair> pairs_, pairs_before_;
  double friction_ = 0, rolling_resistance_ = 0, max_push_out_ = 0;
  double inverse_h_ = 0;
  double bias_rate_ = 0, mass_scale_ = 1, impulse_scale_ = 0;
};

}  // namespace tandem
