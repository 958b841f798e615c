// Solves the contacts of all ranks, colour by colour.
#include "tandem/mpi/response.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "communicator.h"
#include "home.h"
#include "motion_stops.h"
#include "pipeline_impl.h"
#include "records.h"
#include "response/contact_solver.h"
#include "response/exact_sum.h"
#include "response/parallel_blocks.h"
#include "response/solver_bodies.h"
#include "shared_bodies.h"
#include "tandem/engine/continuous_motion.h"
#include "velocity_exchange.h"

namespace tandem::mpi {
namespace {

double ms_passed(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// The impulses of a pair, as bytes.
struct Impulses {
  std::array<double, 3> rolling{};
  std::vector<KeptPoint> points;

  void write(Message& message) const {
    message.put(rolling);
    message.put(std::uint64_t{points.size()});
    for (const KeptPoint& point : points) message.put(point);
  }
  static Impulses read(Message& message) {
    Impulses out;
    out.rolling = message.take<std::array<double, 3>>();
    for (auto count = message.take<std::uint64_t>(); count > 0; --count)
      out.points.push_back(message.take<KeptPoint>());
    return out;
  }
};

}  // namespace

struct Response::Impl {
  Impl(Pipeline& of, ResponseOptions wanted, PairOfIds allows)
      : pipeline(*of.impl_),
        options(std::move(wanted)),
        stops(pipeline.communicator, pipeline.bodies, std::move(allows)) {
    const tandem::Response checks(options);
    if (options.predicate)
      throw std::invalid_argument("response: predicate is given, allowed: none, as its indices are those of one rank");
    pipeline.bodies.note_removed();
  }

  RankResponseReport step(bool with_contacts);
  void write_untold(Outbox& outbox) const;
  void take_stops(RankResponseReport& report);
  void limit_motion(RankResponseReport& report);
  void move(RankResponseReport& report);
  void forget_removed();
  void list_pairs();
  void find_before();
  void write_before(Outbox& outbox);
  void read_first(RankMessage& message, Outbox& answers);
  void read_second(RankMessage& message);
  void agree(RankResponseReport& report);
  void note_places();
  void solve();
  void put_back(RankResponseReport& report);
  bool may_be_elsewhere(const IdPair& ids) const;

  struct Solved {
    IdPair ids;
    std::uint32_t place = 0;  // in the solver
  };
  struct Left {
    int rank = 0;  // the rank that asks
    std::optional<Impulses> impulses;
  };

  Pipeline::Impl& pipeline;
  ResponseOptions options;
  ParallelTime parallel;
  ContactSolver solver{parallel};
  SolverBodies bodies{parallel};
  SharedBodies shared{pipeline.communicator, pipeline.bodies};
  VelocityExchange velocities{pipeline.communicator};
  MotionStops stops;
  std::vector<Pose> ends;  // one for each index, if there are continuous bodies
  // The reported contacts and those of bodies that were stopped in the step before.
  const ContactList* list = nullptr;
  const ContactList* found = nullptr;          // the reported contacts alone
  std::vector<OwnPair> pairs;                  // ascending by ids
  std::vector<std::uint32_t> colours, before;  // one for each pair of the list
  std::vector<Solved> solved;                  // in the last response, ascending by ids
  std::map<IdPair, Left> left;                 // data that ranks have sent to this one as the home of pairs
  bool moved_after = false;                    // a copy was moved after the pipeline's step
  std::uint64_t pipeline_steps = 0;            // number of steps after the last response
  std::unique_ptr<tbb::task_arena> arena;      // if the caller's has another number of threads
};

/// Forgets the impulses of removed bodies: an id may be used for another body at once, whose pairs had no impulses.
void Response::Impl::forget_removed() {
  const std::vector<GlobalId> removed = pipeline.bodies.take_removed();
  const std::uint64_t steps = std::exchange(pipeline_steps, pipeline.steps);
  if (pipeline.steps <= steps + 1) return;
  Message own;
  for (const GlobalId id : removed) own.put(id);
  std::vector<GlobalId> all;
  for (Message& message : pipeline.communicator.to_all(own))
    while (!message.done()) all.push_back(message.take<GlobalId>());
  std::sort(all.begin(), all.end());
  const auto is_gone = [&](GlobalId id) { return std::binary_search(all.begin(), all.end(), id); };
  std::erase_if(solved, [&](const Solved& pair) { return is_gone(pair.ids.a) || is_gone(pair.ids.b); });
  stops.forget(is_gone);
}

void Response::Impl::list_pairs() {
  pairs.clear();
  for (std::uint32_t i = 0; i < list->pairs.size(); ++i) {
    const PairResult& pair = list->pairs[i];
    if (!ContactSolver::takes_part(pair, bodies.all())) continue;
    pairs.push_back({{pipeline.bodies.id(pair.a), pipeline.bodies.id(pair.b)},
                     i,
                     {pair.a, pair.b},
                     {bodies.moves(pair.a), bodies.moves(pair.b)}});
  }
  std::sort(pairs.begin(), pairs.end(), [](const OwnPair& x, const OwnPair& y) { return x.ids < y.ids; });
}

/// Finds the impulses of the step before for pairs that were solved on this rank.
void Response::Impl::find_before() {
  before.assign(list->pairs.size(), ContactSolver::none);
  auto old = solved.begin();
  for (const OwnPair& pair : pairs) {
    old = std::find_if(old, solved.end(), [&](const Solved& one) { return one.ids >= pair.ids; });
    if (old != solved.end() && old->ids == pair.ids) before[pair.found] = old->place;
  }
}

/// True if impulses of a pair may be on another rank. All contacts of a body in this rank's own region (of the last
/// exchange: it may have been cut anew since) are reported here.
bool Response::Impl::may_be_elsewhere(const IdPair& ids) const {
  if (stops.any() && stops.is_elsewhere(ids)) return true;
  const auto a = pipeline.bodies.place(ids.a), b = pipeline.bodies.place(ids.b);
  return !a || !b || !(pipeline.bodies.is_inside(*a) || pipeline.bodies.is_inside(*b));
}

/// Sends impulses to the rank that now reports their pair, by way of the pair's home rank.
void Response::Impl::write_before(Outbox& outbox) {
  const int ranks = pipeline.communicator.ranks();
  for (const OwnPair& pair : pairs) {
    if (before[pair.found] != ContactSolver::none) continue;
    Message& message = outbox.to(home(pair.ids, ranks));
    message.put(ResponseItem::wanted);
    message.put(pair.ids);
  }
  auto still = pairs.begin();
  for (const Solved& one : solved) {
    still = std::find_if(still, pairs.end(), [&](const OwnPair& pair) { return pair.ids >= one.ids; });
    if ((still != pairs.end() && still->ids == one.ids) || !may_be_elsewhere(one.ids)) continue;
    Message& message = outbox.to(home(one.ids, ranks));
    message.put(ResponseItem::left);
    message.put(one.ids);
    Impulses impulses;
    const Vec3 rolling = solver.kept(one.place, impulses.points);
    impulses.rolling = {rolling.x(), rolling.y(), rolling.z()};
    impulses.write(message);
  }
}

void Response::Impl::read_first(RankMessage& message, Outbox& answers) {
  const auto answer = [&](const IdPair& ids, const Left& pair) {
    Message& message = answers.to(pair.rank);
    message.put(ResponseItem::kept);
    message.put(ids);
    pair.impulses->write(message);
  };
  while (!message.content.done()) switch (message.content.take<ResponseItem>()) {
      case ResponseItem::moved:
        pipeline.bodies.move_copy(message.content.take<MotionRecord>());
        moved_after = true;
        break;
      case ResponseItem::use:
        shared.read_use(message.content, message.rank);
        break;
      case ResponseItem::left: {
        const auto ids = message.content.take<IdPair>();
        const auto [pair, first] = left.try_emplace(ids);
        pair->second.impulses = Impulses::read(message.content);
        if (!first) answer(ids, pair->second);
        break;
      }
      case ResponseItem::wanted: {
        const auto ids = message.content.take<IdPair>();
        const auto [pair, first] = left.try_emplace(ids);
        pair->second.rank = message.rank;
        if (!first) answer(ids, pair->second);
        break;
      }
      default:
        throw std::logic_error("an answer came among questions");
    }
}

void Response::Impl::read_second(RankMessage& message) {
  while (!message.content.done()) switch (message.content.take<ResponseItem>()) {
      case ResponseItem::order:
        shared.read_order(message.content, message.rank);
        break;
      case ResponseItem::kept: {
        const auto ids = message.content.take<IdPair>();
        const Impulses impulses = Impulses::read(message.content);
        const auto pair = std::lower_bound(pairs.begin(), pairs.end(), ids,
                                           [](const OwnPair& x, const IdPair& y) { return x.ids < y; });
        if (pair == pairs.end() || pair->ids != ids)
          throw std::logic_error("impulses came for a pair that nobody asked for");
        before[pair->found] = solver.take_in(Eigen::Map<const Vec3>(impulses.rolling.data()), impulses.points);
        break;
      }
      default:
        throw std::logic_error("a question came among answers");
    }
}

/// Writes bodies that a host has moved after the pipeline's step.
void Response::Impl::write_untold(Outbox& outbox) const {
  pipeline.bodies.each_untold([&](std::uint32_t index, std::span<const int> ranks) {
    for (const int rank : ranks) {
      outbox.to(rank).put(ResponseItem::moved);
      outbox.to(rank).put(MotionRecord::of(pipeline.bodies.id(index), pipeline.bodies.scene(), index));
    }
  });
}

/// Adds the contacts of pairs that were stopped in the step before.
void Response::Impl::take_stops(RankResponseReport& report) {
  if (!stops.any()) return;
  Outbox outbox(pipeline.communicator.ranks());
  write_untold(outbox);
  for (RankMessage& message : pipeline.communicator.exchange(outbox, report.bytes_sent, report.messages_sent))
    while (!message.content.done()) {
      if (message.content.take<ResponseItem>() != ResponseItem::moved)
        throw std::logic_error("something else came among bodies that were moved");
      pipeline.bodies.move_copy(message.content.take<MotionRecord>());
    }
  list = &stops.with_contacts(*list);
}

/// Determines which rank solves which pairs, in which colours, and from which impulses.
void Response::Impl::agree(RankResponseReport& report) {
  list_pairs();
  find_before();
  shared.begin(pairs);
  left.clear();
  moved_after = false;
  if (pipeline.communicator.ranks() > 1) {
    Outbox questions(pipeline.communicator.ranks()), answers(pipeline.communicator.ranks());
    write_untold(questions);
    shared.write_uses(questions);
    write_before(questions);
    for (RankMessage& message : pipeline.communicator.exchange(questions, report.bytes_sent, report.messages_sent))
      read_first(message, answers);
    shared.write_orders(answers);
    for (RankMessage& message : pipeline.communicator.exchange(answers, report.bytes_sent, report.messages_sent))
      read_second(message);
    if (moved_after) bodies.begin_step(pipeline.bodies.scene(), options.max_speed);
  }
  colours.assign(list->pairs.size(), ContactSolver::none);
  shared.give_colours(colours);
  velocities.plan(shared.shared());
}

void Response::Impl::note_places() {
  std::vector<std::uint32_t> places(list->pairs.size());
  solver.each_place([&](std::uint32_t found, std::uint32_t place) { places[found] = place; });
  solved.clear();
  for (const OwnPair& pair : pairs) solved.push_back({pair.ids, places[pair.found]});
}

void Response::Impl::solve() {
  const Scene& scene = pipeline.bodies.scene();
  const double h = scene.dt / options.substeps;
  solver.begin_substeps(h, options);
  std::vector<SolverBody>& all = bodies.all();
  const ContactSolver::AfterColour after = [&](std::uint32_t colour) { velocities.after(colour, all); };
  for (int substep = 0; substep < options.substeps; ++substep) {
    bodies.accelerate(h * scene.gravity);
    solver.warm_start(all, after);
    velocities.end_pass(all);
    solver.solve(all, ContactSolver::Overlap::push_out, after);
    velocities.end_pass(all);
    bodies.advance(h);
    solver.solve(all, ContactSolver::Overlap::leave, after);
    velocities.end_pass(all);
  }
}

/// Limits the end poses of continuous bodies.
void Response::Impl::limit_motion(RankResponseReport& report) {
  ends.clear();
  stops.forget();
  if (!pipeline.has_continuous) return;
  const Scene& scene = pipeline.bodies.scene();
  bodies.find_ends(scene, ends);
  report.response.stops = stops.limit(ends);
}

/// Writes back the bodies that this rank owns; others learn of them in the pipeline's next step.
void Response::Impl::put_back(RankResponseReport& report) {
  const Scene& scene = pipeline.bodies.scene();
  const std::vector<std::uint32_t>& moving = bodies.moving();
  std::vector<ExactSum> energies((moving.size() + response_bodies_a_block - 1) / response_bodies_a_block);
  for_blocks(moving.size(), response_bodies_a_block, parallel, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t i : std::span(moving).subspan(begin, end - begin)) {
      if (!pipeline.bodies.owns(i)) continue;
      const Pose pose = ends.empty() ? bodies.end_of(scene, i) : ends[i];
      const SolverBodies::End its = bodies.end_at(scene, i, pose);
      pipeline.bodies.move(i, pose, its.velocity, its.angular_velocity);
      energies[begin / response_bodies_a_block].add(its.kinetic_energy);
    }
  });
  ExactSum all;
  for (const ExactSum& some : energies) all.add(some);
  double depth[] = {0};
  for (const Contact& contact : found->contacts) depth[0] = std::max(depth[0], contact.depth);
  if (pipeline.communicator.ranks() > 1) {
    pipeline.communicator.sum(all.words());
    pipeline.communicator.largest(std::span<double>(depth));
  }
  report.response.kinetic_energy = all.value();
  report.response.max_depth = depth[0];
}

void Response::Impl::move(RankResponseReport& report) {
  parallel = {};
  const auto begin = Clock::now();
  forget_removed();
  take_stops(report);
  bodies.begin_step(pipeline.bodies.scene(), options.max_speed);
  agree(report);
  solver.prepare_share(*list, bodies.all(), options, {colours, before});
  note_places();
  report.gather_ms = ms_passed(begin);
  solve();
  limit_motion(report);
  put_back(report);
}

RankResponseReport Response::Impl::step(bool with_contacts) {
  static const ContactList none;
  RankResponseReport report;
  const auto begin = Clock::now();
  list = found = with_contacts ? &pipeline.contacts() : &none;
  try {
    if (options.threads == 0 || options.threads == tbb::this_task_arena::max_concurrency()) {
      move(report);
    } else {
      if (!arena) arena = std::make_unique<tbb::task_arena>(options.threads);
      arena->execute([&] { move(report); });
    }
  } catch (...) {
    // The others wait for messages that this rank will not send.
    if (pipeline.communicator.ranks() > 1) pipeline.communicator.abort_for_exception();
    throw;
  }
  stops.count_sent(report.bytes_sent, report.messages_sent);
  report.bytes_sent += shared.bytes_sent() + velocities.bytes_sent();
  report.messages_sent += shared.messages_sent() + velocities.messages_sent();
  report.wait_ms = velocities.wait_ms();
  report.response.ms = ms_passed(begin);
  report.response.serial_ms = report.response.ms - std::chrono::duration<double, std::milli>(parallel.sum).count();
  return report;
}

Response::Response(Pipeline& pipeline, ResponseOptions options, PairOfIds allows)
    : impl_(std::make_unique<Impl>(pipeline, std::move(options), std::move(allows))) {}
Response::~Response() = default;
Response::Response(Response&&) noexcept = default;
Response& Response::operator=(Response&&) noexcept = default;
void Response::begin_anew() {
  impl_->solved.clear();
  impl_->stops.forget();
}
RankResponseReport Response::step(bool with_contacts) { return impl_->step(with_contacts); }

}  // namespace tandem::mpi
