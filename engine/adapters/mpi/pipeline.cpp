// The pipeline over ranks: a step from changes to contacts.
#include "tandem/mpi/pipeline.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <sstream>
#include <utility>

#include "answer_sum.h"
#include "answers/word_hash.h"
#include "bodies.h"
#include "communicator.h"
#include "costs.h"
#include "cpu_time.h"
#include "kept_messages.h"
#include "pipeline/pipeline_parts.h"
#include "pipeline_impl.h"
#include "rebalancer.h"
#include "regions.h"
#include "scene/tolerances.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem::mpi {
namespace {

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

void require(bool allowed, const char* option, double value, const char* range) {
  if (allowed) return;
  std::ostringstream message;
  message.precision(17);
  message << option << " is " << value << ", allowed: " << range;
  throw std::invalid_argument(message.str());
}

Options checked(Options options) {
  require(std::isfinite(options.patience) && options.patience >= 0, "patience", options.patience, "finite, >= 0 s");
  require(options.rebalance.longest_control_step >= 1 && options.rebalance.longest_control_step <= 1024,
          "rebalance.longest_control_step", options.rebalance.longest_control_step, "1 to 1024");
  require(options.rebalance.tolerated >= 1 && options.rebalance.tolerated <= 100, "rebalance.tolerated",
          options.rebalance.tolerated, "1 to 100");
  return options;
}

/// A hash of the options that decide which answers there are and what is sent between ranks.
std::uint64_t hash_of(const AnswerOptions& answer) {
  WordHash hash(0);
  for (const double x : {static_cast<double>(answer.request), answer.margin, answer.tolerance, answer.keep_contacts,
                         answer.mesh_margin ? 1.0 : 0.0})
    hash.add(x);
  return hash.value();
}

/// How far a body may be from the pose of its kept answers, as a fraction of its size.
double rest_of(const AnswerOptions& answer) {
  return answer.request == Request::collide ? 0 : tolerance::rest_share * answer.keep_contacts;
}

}  // namespace

Pipeline::Impl::Impl(MPI_Comm of, Options wanted)
    : options(checked(std::move(wanted))),
      communicator(of, options.patience),
      regions(communicator),
      bodies(communicator, regions, options.rank.answer.margin, options.rank.threads, rest_of(options.rank.answer)),
      rebalancer(options.rebalance),
      detection(detecting()),
      kept(detection) {
  if (kept.keeps()) bodies.keep_with(kept);
}

PipelineOptions Pipeline::Impl::detecting() {
  PipelineOptions out = options.rank;
  out.answer.contact_hash = false;  // replaced by the sum of pairs' hashes
  out.predicate = [this](std::span<Pair> candidates) {
    const std::span<Pair> own = candidates.first(take_own(candidates));
    return options.rank.predicate ? count_kept(options.rank.predicate, own) : own.size();
  };
  return out;
}

/// Keeps the pairs that this rank reports, each in the order of its global ids.
std::size_t Pipeline::Impl::take_own(std::span<Pair> candidates) {
  std::size_t kept = 0;
  const bool alone = communicator.ranks() == 1;
  for (Pair pair : candidates) {
    // By selects: half of the branches would be mispredicted.
    const bool turned = bodies.id(pair.a) > bodies.id(pair.b);
    pair = {turned ? pair.b : pair.a, turned ? pair.a : pair.b};
    candidates[kept] = pair;
    const bool is_own = alone || bodies.reports(pair.a, pair.b);
    if (is_own && counts_costs) costs.count(bodies, pair);
    kept += is_own ? 1 : 0;
  }
  pairs.fetch_add(kept, std::memory_order_relaxed);
  return kept;
}

void Pipeline::Impl::note_failure(const std::string& cause) {
  if (!failure.empty()) return;
  failure =
      "rank " + std::to_string(communicator.rank()) + ", step " + std::to_string(communicator.step()) + ": " + cause;
}

void Pipeline::Impl::apply(const Change& change) {
  try {
    bodies.apply(change);
  } catch (const std::invalid_argument& error) {
    note_failure(error.what());
  }
}

bool Pipeline::Impl::check_ahead() {
  try {
    return bodies.check_ahead();
  } catch (const std::exception& error) {
    bodies.check_again();
    note_failure(error.what());
    return false;
  }
}

/// Applies additions first, so that the other changes of any rank find them; then those, by ranks.
void Pipeline::Impl::apply_changes(Report& report) {
  const auto begin = Clock::now();
  const double cpu = cpu_ms();
  const bool alone = communicator.ranks() == 1;
  const bool asks = std::any_of(changes.begin(), changes.end(), [&](const Change& change) {
    return change.kind == Change::Kind::add || !bodies.owns_id(change.id());
  });
  const bool as_expected = !alone && changes.empty() && !recut && regions.is_cut() && check_ahead();
  const std::uint64_t alike = bodies.shapes_hash() ^ hash_of(options.rank.answer);
  std::array<std::uint64_t, 4> all{asks ? 1u : 0u, alike, ~alike, as_expected ? 0u : 1u};
  const auto checked = Clock::now();
  report.rank.exchange_cpu_ms = cpu_ms() - cpu;
  if (!alone) communicator.largest(std::span<std::uint64_t>(all));
  report.rank.exchange_wait_ms = ms_since(checked);
  record("exchange", begin, checked);
  record("wait", checked, Clock::now());
  expected = all[3] == 0;
  if (all[1] != ~all[2]) {  // all ranks agree to fail: a body must not go to a rank that lacks its shape
    bodies.check_again();
    note_failure(
        "the ranks have different shapes or answer options: all must add the same shapes in the same order, and have "
        "one "
        "request, margin, tolerance, keep_contacts and mesh_margin");
    throw_failure();
  }
  std::vector<Change> own = std::exchange(changes, {});
  if (alone || all[0] == 0) {
    for (const bool adds : {true, false})
      for (const Change& change : own)
        if ((change.kind == Change::Kind::add) == adds) apply(change);
    return;
  }
  add_bodies(own);
  send_changes(own);
}

/// Adds bodies. If several ranks add one id, the directory accepts one owner; the others remove theirs.
void Pipeline::Impl::add_bodies(std::span<const Change> own) {
  const auto update_directory = [&] { bodies.directory().update([&](GlobalId id) { return bodies.owns_id(id); }); };
  update_directory();
  std::vector<GlobalId> ids;
  for (const Change& change : own)
    if (change.kind == Change::Kind::add) ids.push_back(change.id());
  const std::vector<int> before = bodies.directory().owners(ids);
  std::vector<GlobalId> added;
  std::size_t k = 0;
  for (const Change& change : own) {
    if (change.kind != Change::Kind::add) continue;
    if (before[k++] >= 0) {
      note_failure("body " + std::to_string(change.id()) + ": exists already");
    } else {
      const bool twice = bodies.owns_id(change.id());
      apply(change);
      if (!twice) added.push_back(change.id());
    }
  }
  update_directory();
  const std::vector<int> after = bodies.directory().owners(added);
  for (std::size_t i = 0; i < added.size(); ++i) {
    if (after[i] == communicator.rank()) continue;
    note_failure("body " + std::to_string(added[i]) + ": was added by another rank, too");
    bodies.forget(added[i]);
  }
}

void Pipeline::Impl::send_changes(std::span<const Change> own) {
  std::vector<GlobalId> ids;
  for (const Change& change : own)
    if (change.kind != Change::Kind::add) ids.push_back(change.id());
  const std::vector<int> owners = bodies.directory().owners(ids);
  std::vector<RankMessage> messages, received;
  std::vector<Change> here;
  std::size_t k = 0;
  for (const Change& change : own) {
    if (change.kind == Change::Kind::add) continue;
    const int owner = owners[k++];
    if (owner < 0) {
      note_failure("body " + std::to_string(change.id()) + ": does not exist");
    } else if (owner == communicator.rank()) {
      here.push_back(change);
    } else {
      auto to = std::find_if(messages.begin(), messages.end(),
                             [&](const RankMessage& message) { return message.rank == owner; });
      if (to == messages.end()) to = messages.insert(messages.end(), RankMessage{owner, {}});
      to->content.put(change);
    }
  }
  communicator.exchange(messages, received);
  RankMessage& mine = received.emplace_back();
  mine.rank = communicator.rank();
  for (const Change& change : here) mine.content.put(change);
  std::sort(received.begin(), received.end(),
            [](const RankMessage& x, const RankMessage& y) { return x.rank < y.rank; });
  for (RankMessage& message : received)
    while (!message.content.done()) apply(message.content.take<Change>());
}

/// Collective: cuts regions of equal weight.
void Pipeline::Impl::cut(std::span<const float> weights) {
  const auto begin = Clock::now();
  std::vector<Vec3> points;
  std::vector<float> own;
  const Scene& scene = bodies.scene();
  std::size_t k = 0;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i) || !bodies.owns(i)) continue;
    const float weight = weights.empty() ? 1 : weights[k++];
    if (!scene.shape_of(i).is_bounded()) continue;  // an unbounded body is everywhere
    points.push_back(bodies.centre(i));
    own.push_back(weight);
  }
  std::uint64_t all_points[] = {points.size()};
  communicator.sum(std::span<std::uint64_t>(all_points));
  if (all_points[0] == 0) return;
  // The first cut sends all bodies from wherever they were added, so its cost says nothing.
  learns_cost = regions.is_cut();
  if (regions.cut(points, own)) recut = true;
  cut_ms = ms_since(begin);
}

void Pipeline::Impl::exchange(Report& report) {
  if (communicator.ranks() == 1) return hand_over(report);
  if (!regions.is_cut()) cut({});
  const Bodies::Sent sent = bodies.exchange(recut, expected);
  report.rank.moved_away = sent.moved_away;
  report.rank.bytes_sent = sent.bytes;
  report.rank.messages_sent = sent.messages;
  report.rank.exchange_cpu_ms += sent.cpu_ms;
  report.rank.exchange_wait_ms += std::chrono::duration<double, std::milli>(sent.got - sent.packed).count();
  record("exchange", sent.begin, sent.packed);
  record("wait", sent.packed, sent.got);
  record("exchange", sent.got, sent.end);
  hand_over(report);
}

/// Sends the kept answers of pairs to the ranks that report them from now on.
void Pipeline::Impl::hand_over(Report& report) {
  if (!kept.keeps()) return;
  const auto begin = Clock::now();
  double cpu = cpu_ms();
  std::vector<KeptRecord> arrived;
  if (communicator.ranks() > 1) {
    const auto leaves = [this](Pair pair) {
      const int to = bodies.reporter(pair);
      return to >= 0 && to != communicator.rank();
    };
    Outbox outbox(communicator.ranks());
    for (const KeptRecord& record : kept.leaving(leaves))
      write_kept(outbox.to(bodies.reporter(record.pair)),
                 {bodies.last_id(record.pair.a), bodies.last_id(record.pair.b)}, record);
    report.rank.exchange_cpu_ms += cpu_ms() - cpu;
    const auto packed = Clock::now();
    std::vector<RankMessage> received =
        communicator.exchange(outbox, report.rank.bytes_sent, report.rank.messages_sent);
    report.rank.exchange_wait_ms += ms_since(packed);
    record("exchange", begin, packed);
    record("wait", packed, Clock::now());
    cpu = cpu_ms();
    for (RankMessage& message : received)
      while (!message.content.done()) {
        const auto [ids, taken] = take_kept(message.content);
        const auto a = bodies.place(ids.a), b = bodies.place(ids.b);
        if (!a || !b) continue;  // one was removed
        arrived.push_back(taken);
        arrived.back().pair = {*a, *b};
      }
  }
  kept.take_in(bodies.scene(), bodies.arrivals(), std::move(arrived));
  bodies.forget_past();
  report.rank.exchange_cpu_ms += cpu_ms() - cpu;
}

void Pipeline::Impl::begin_anew() {
  kept.begin_anew();
  bodies.forget_past();
}

void Pipeline::Impl::detect(Report& report) {
  pairs.store(0, std::memory_order_relaxed);
  counts_costs = communicator.ranks() > 1 && rebalancer.counts_next();
  if (counts_costs) costs.begin(bodies);
  const double cpu = cpu_ms();
  try {
    report.rank.detection = detection.step(bodies.scene());
    report.rank.detection.step = communicator.step();
    const auto cut_short = bit(StepIssue::ended_early) | bit(StepIssue::incomplete);
    if ((report.rank.detection.execution.issues & cut_short) != 0) note_failure("detection was cancelled");
  } catch (const std::exception& error) {
    note_failure(error.what());
  } catch (...) {
    note_failure("what was thrown is no std::exception");
  }
  report.rank.detect_cpu_ms = cpu_ms() - cpu;
  found = failure.empty();
  if (!found || !options.rank.answer.contact_hash) return;
  const ContactList& list = detection.contacts();
  std::uint64_t sum = 0;
  for (const PairResult& pair : list.pairs)
    sum += hash_of_pair(bodies.id(pair.a), bodies.id(pair.b), pair.answer, list.of(pair));
  report.rank.detection.contact_hash = sum;
}

/// Combines the results of all ranks.
void Pipeline::Impl::put_together(Report& report) {
  const StepReport& own = report.rank.detection;
  report.rank.owned = bodies.owned();
  report.rank.copies = bodies.copies();
  const double load = own.execution.busy_ms / std::max(1, own.execution.threads);
  const double exchanged = recut ? cut_ms + report.rank.exchange_ms : 0;
  Communicator::Totals totals{
      {report.rank.owned, pairs.load(std::memory_order_relaxed), own.colliding_pairs, own.contacts, own.gaps,
       own.contact_hash, report.rank.moved_away, report.rank.copies, report.rank.bytes_sent, report.rank.messages_sent,
       failure.empty() ? 0u : 1u, static_cast<std::uint64_t>(1e6 * load), own.kept_pairs,
       bodies.scene().has_continuous() ? 1u : 0u},
      {own.max_depth, load, exchanged, report.rank.exchange_cpu_ms, report.rank.detect_cpu_ms, own.kept_error_bound}};
  const auto begin = Clock::now();
  if (communicator.ranks() > 1) communicator.combine(totals);
  const auto& [sums, most] = totals;
  report.rank.wait_ms = ms_since(begin);
  record("wait", begin, Clock::now());
  report.bodies = sums[0];
  report.pairs = sums[1];
  report.colliding_pairs = sums[2];
  report.contacts = sums[3];
  report.gaps = sums[4];
  report.contact_hash = sums[5];
  report.moved_away = sums[6];
  report.copies = sums[7];
  report.bytes_sent = sums[8];
  report.messages_sent = sums[9];
  report.mean_load_ms = static_cast<double>(sums[11]) / (1e6 * communicator.ranks());  // ns
  report.kept_pairs = sums[12];
  has_continuous = sums[13] != 0;
  report.max_depth = most[0];
  report.kept_error_bound = most[5];
  report.slowest_load_ms = most[1];
  report.slowest_exchange_cpu_ms = most[3];
  report.slowest_detect_cpu_ms = most[4];
  if (std::exchange(recut, false) && learns_cost) rebalancer.learn_cost(most[2]);
  cut_ms = 0;
  if (sums[10] == 0) return;
  found = false;
  begin_anew();  // ranks that did not fail have more to keep
  throw_failure();
}

void Pipeline::Impl::throw_failure() {
  const std::string own = std::exchange(failure, {});
  if (communicator.ranks() == 1) throw StepError(own);
  for (const std::string& text : communicator.texts(own))
    if (!text.empty()) throw StepError(text);
  throw StepError("a step failed");  // not reached: one rank has a text
}

void Pipeline::Impl::rebalance(Report& report) {
  if (communicator.ranks() == 1) return;
  report.rebalance = rebalancer.after_step(report.slowest_load_ms, report.mean_load_ms);
  if (report.rebalance.action == BalanceAction::change) {
    cut(counts_costs ? costs.weights(bodies, report.rank.detection.execution) : std::vector<float>{});
  } else if (report.rebalance.action == BalanceAction::revert) {
    regions.take_back();
    recut = true;
  }
}

void Pipeline::Impl::rebalance_now() {
  if (communicator.ranks() == 1 || !regions.is_cut()) return;
  const bool known = costs.known(bodies);
  std::uint64_t all_known[] = {known ? 0u : 1u};
  communicator.largest(std::span<std::uint64_t>(all_known));
  cut(all_known[0] == 0 ? costs.weights(bodies, last) : std::vector<float>{});
  rebalancer.note_cut();
}

Report Pipeline::Impl::step() {
  const auto begin = Clock::now();
  Report report;
  report.step = steps++;
  communicator.at_step(report.step);
  found = false;
  try {
    apply_changes(report);
    exchange(report);
    report.rank.exchange_ms = ms_since(begin);
    detect(report);
    put_together(report);
    rebalance(report);
  } catch (const StepError&) {
    throw;
  } catch (...) {
    // The others wait for messages that this rank will not send.
    if (communicator.ranks() > 1) communicator.abort_for_exception();
    throw;
  }
  last = report.rank.detection.execution;
  report.rank.step_ms = ms_since(begin);
  return report;
}

void Pipeline::Impl::record(std::string_view slice, Clock::time_point begin, Clock::time_point end) {
  if (timeline != nullptr && communicator.ranks() > 1)
    timeline->lane().slices.push_back({.name = slice, .begin = begin, .end = end, .step = communicator.step()});
}

Pipeline::Pipeline(MPI_Comm communicator, Options options)
    : impl_(std::make_unique<Impl>(communicator, std::move(options))) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

int Pipeline::rank() const { return impl_->communicator.rank(); }
int Pipeline::ranks() const { return impl_->communicator.ranks(); }
ShapeId Pipeline::add_shape(Shape shape, std::string name) {
  return impl_->bodies.add_shape(std::move(shape), std::move(name));
}

void Pipeline::add_body(GlobalId id, const BodyOptions& body) {
  impl_->change(Change::Kind::add, id) = impl_->bodies.checked(id, body);
}
void Pipeline::remove_body(GlobalId id) { impl_->change(Change::Kind::remove, id); }
void Pipeline::set_pose(GlobalId id, const Pose& pose) {
  require_valid(pose, "body " + std::to_string(id));
  impl_->change(Change::Kind::pose, id).motion =
      MotionRecord::of(id, orthonormalized(pose), Vec3::Zero(), Vec3::Zero());
}
void Pipeline::set_velocity(GlobalId id, const Vec3& velocity, const Vec3& angular_velocity) {
  if (!velocity.allFinite() || !angular_velocity.allFinite())
    throw std::invalid_argument("body " + std::to_string(id) + ": a velocity is not finite, allowed: finite numbers");
  impl_->change(Change::Kind::velocity, id).motion = MotionRecord::of(id, {}, velocity, angular_velocity);
}
void Pipeline::set_shape(GlobalId id, ShapeId shape) {
  const std::size_t shapes = impl_->bodies.scene().shapes().size();
  if (shape.index_plus_one == 0 || shape.index_plus_one > shapes || shape.generation != 1)
    throw std::invalid_argument("body " + std::to_string(id) + ": shape is number " +
                                std::to_string(shape.index_plus_one) + ", allowed: 1 to " + std::to_string(shapes) +
                                ", the shapes added");
  impl_->change(Change::Kind::shape, id).shape = shape.index_plus_one - 1;
}
void Pipeline::set_filter(GlobalId id, std::uint32_t group, std::uint32_t mask) {
  BodyRecord& body = impl_->change(Change::Kind::filter, id);
  body.group = group;
  body.mask = mask;
}
void Pipeline::set_static(GlobalId id, bool is_static) {
  impl_->change(Change::Kind::is_static, id).is_static = is_static ? 1 : 0;
}
void Pipeline::set_density(GlobalId id, double density) {
  require(std::isfinite(density) && density > 0, ("body " + std::to_string(id) + ": density").c_str(), density,
          "finite, > 0 kg/m^3");
  impl_->change(Change::Kind::density, id).density = density;
}
void Pipeline::set_sensor(GlobalId id, bool is_sensor) {
  impl_->change(Change::Kind::is_sensor, id).is_sensor = is_sensor ? 1 : 0;
}
void Pipeline::set_continuous(GlobalId id, bool continuous) {
  impl_->change(Change::Kind::continuous, id).is_continuous = continuous ? 1 : 0;
}

void Pipeline::rebalance() { impl_->rebalance_now(); }
void Pipeline::begin_anew() { impl_->kept.begin_anew(); }
Report Pipeline::step() { return impl_->step(); }

const Scene& Pipeline::scene() const { return impl_->bodies.scene(); }
GlobalId Pipeline::id(std::uint32_t index) const { return impl_->bodies.id(index); }
bool Pipeline::owns(std::uint32_t index) const { return scene().alive(index) && impl_->bodies.owns(index); }
bool Pipeline::has(GlobalId id) const { return impl_->bodies.has(id); }
BodyId Pipeline::local(GlobalId id) const {
  const auto index = impl_->bodies.place(id);
  if (!index) throw std::invalid_argument("body " + std::to_string(id) + ": is not on this rank");
  return scene().id(*index);
}
void Pipeline::move(std::uint32_t index, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity) {
  impl_->bodies.move(index, pose, velocity, angular_velocity);
}

void Pipeline::set_gravity(const Vec3& gravity) {
  if (!(gravity.array().abs() <= tolerance::largest_of_response).all())
    throw std::invalid_argument("gravity: a component that is too large or no number, allowed: at most 1e30 m/s^2");
  impl_->bodies.scene().gravity = gravity;
}
void Pipeline::set_dt(double dt) {
  require(dt > 0 && dt <= tolerance::longest_time_step, "dt", dt, tolerance::time_step_range);
  impl_->bodies.scene().dt = dt;
}

const ContactList& Pipeline::Impl::contacts() const {
  static const ContactList none;
  return found ? detection.contacts() : none;
}
const ContactList& Pipeline::contacts() const { return impl_->contacts(); }
GatheredContacts Pipeline::gather(int root) const {
  return impl_->gather([root](GlobalId) { return root; });
}
GatheredContacts Pipeline::share() const { return impl_->share(); }
std::uint64_t Pipeline::list_hash(const GatheredContacts& share) const { return impl_->list_hash(share); }
void Pipeline::record_to(Timeline* timeline) {
  impl_->timeline = timeline;
  impl_->detection.record_to(timeline);
}

}  // namespace tandem::mpi
