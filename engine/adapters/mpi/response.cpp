#include "tandem/mpi/response.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "communicator.h"
#include "pipeline_impl.h"
#include "records.h"

namespace tandem::mpi {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

struct ReportedPair {
  GlobalId a = 0, b = 0;
  std::uint64_t contacts = 0;
};

}  // namespace

struct Response::Impl {
  Impl(Pipeline& of, ResponseOptions options) : pipeline(*of.impl_), options(options), response(options) {
    pipeline.bodies.note_removed();
  }

  RankResponseReport step(bool with_contacts);
  void write_changes(Message& message) const;
  void write_contacts(Message& message) const;
  void read_changes(Message& message, std::vector<BodyRecord>& changed);
  void take_over(std::vector<BodyRecord>& changed);
  void put(const BodyRecord& record);
  void forget(GlobalId id);
  void move_own() const;
  void compact();

  Pipeline::Impl& pipeline;
  ResponseOptions options;
  tandem::Response response;
  // All bodies of all ranks. Places are given in the order of ids, step by step, and never twice: impulses of the step
  // before are found by them. Those of removed bodies are fixed, and in no contact.
  Scene replica;
  std::unordered_map<GlobalId, std::uint32_t> places;
  std::vector<GlobalId> ids;  // by place
  ContactList list;
  std::vector<ContactRecord> records;
};

/// Bodies of this rank that are not as the last response left them.
void Response::Impl::write_changes(Message& message) const {
  const std::vector<GlobalId> removed = pipeline.bodies.take_removed();
  message.put(std::uint64_t{removed.size()});
  for (const GlobalId id : removed) message.put(id);
  Message changed;
  std::uint64_t count = 0;
  const Scene& scene = pipeline.bodies.scene();
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i) || !pipeline.bodies.owns(i)) continue;
    const GlobalId id = pipeline.bodies.id(i);
    const BodyRecord record = BodyRecord::of(id, scene, i);
    if (const auto known = places.find(id); known != places.end()) {
      const BodyRecord before = BodyRecord::of(id, replica, known->second);
      if (std::memcmp(&before, &record, sizeof record) == 0) continue;
    }
    changed.put(record);
    ++count;
  }
  message.put(count);
  message.append(changed);
}

void Response::Impl::write_contacts(Message& message) const {
  const ContactList& found = pipeline.contacts();
  for (const PairResult& pair : found.pairs) {
    if (pair.contact_count == 0) continue;
    message.put(ReportedPair{pipeline.bodies.id(pair.a), pipeline.bodies.id(pair.b), pair.contact_count});
    for (const Contact& contact : found.of(pair)) message.put(ContactRecord::of(contact));
  }
}

void Response::Impl::read_changes(Message& message, std::vector<BodyRecord>& changed) {
  for (auto count = message.take<std::uint64_t>(); count > 0; --count) forget(message.take<GlobalId>());
  for (auto count = message.take<std::uint64_t>(); count > 0; --count) changed.push_back(message.take<BodyRecord>());
}

void Response::Impl::forget(GlobalId id) {
  const auto known = places.find(id);
  if (known == places.end()) return;  // it came and went between two responses
  replica.set_static(replica.id(known->second), true);
  replica.move(known->second, replica.poses()[known->second], Vec3::Zero(), Vec3::Zero());
  places.erase(known);
}

void Response::Impl::put(const BodyRecord& record) {
  const GlobalId id = record.motion.id;
  const auto known = places.find(id);
  const ShapeId shape{record.shape + 1, 1};
  std::uint32_t place = 0;
  if (known == places.end()) {
    place = replica
                .add_body({.shape = shape,
                           .density = record.density,
                           .is_static = record.is_static != 0,
                           .is_sensor = record.is_sensor != 0,
                           .group = record.group,
                           .mask = record.mask})
                .index();
    places[id] = place;
    ids.push_back(id);
  } else {
    place = known->second;
    const BodyId body = replica.id(place);
    replica.set_static(body, true);  // of any shape, meanwhile
    replica.set_shape(body, shape);
    replica.set_static(body, record.is_static != 0);
    replica.set_filter(body, record.group, record.mask);
  }
  replica.move(place, record.motion.pose(), record.motion.speed(), record.motion.spin());
}

void Response::Impl::take_over(std::vector<BodyRecord>& changed) {
  const auto shapes = pipeline.bodies.scene().shapes();
  for (std::size_t k = replica.shapes().size(); k < shapes.size(); ++k) replica.add_shape(shapes[k]);
  std::sort(changed.begin(), changed.end(),
            [](const BodyRecord& x, const BodyRecord& y) { return x.motion.id < y.motion.id; });
  for (const BodyRecord& record : changed) put(record);
  compact();
}

/// Once most places are removed bodies': the same step on any number of ranks. Impulses are lost.
void Response::Impl::compact() {
  if (replica.indices() < 2 * places.size() + 1024) return;
  Scene fresh;
  for (const Shape& shape : replica.shapes()) fresh.add_shape(shape);
  std::vector<BodyRecord> all;
  for (std::uint32_t place = 0; place < ids.size(); ++place)
    if (const auto known = places.find(ids[place]); known != places.end() && known->second == place)
      all.push_back(BodyRecord::of(ids[place], replica, place));
  replica = std::move(fresh);
  places.clear();
  ids.clear();
  for (const BodyRecord& record : all) put(record);
  response = tandem::Response(options);
}

void Response::Impl::move_own() const {
  const Scene& scene = pipeline.bodies.scene();
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i) || scene.is_static()[i] != 0 || !pipeline.bodies.owns(i)) continue;
    const std::uint32_t place = places.at(pipeline.bodies.id(i));
    pipeline.bodies.move(i, replica.poses()[place], replica.velocities()[place], replica.angular_velocities()[place]);
  }
}

RankResponseReport Response::Impl::step(bool with_contacts) {
  RankResponseReport report;
  const auto begin = Clock::now();
  Message own;
  write_changes(own);
  if (with_contacts) write_contacts(own);
  report.bytes_sent = own.size() * static_cast<std::uint64_t>(pipeline.communicator.ranks() - 1);
  std::vector<Message> messages = pipeline.communicator.to_all(own);
  report.gather_ms = ms_since(begin);

  std::vector<BodyRecord> changed;
  for (Message& message : messages) read_changes(message, changed);
  take_over(changed);
  list.pairs.clear();
  list.contacts.clear();
  records.clear();
  for (Message& message : messages)
    while (!message.done()) {
      const auto pair = message.take<ReportedPair>();
      list.pairs.push_back({places.at(pair.a),
                            places.at(pair.b),
                            static_cast<std::uint32_t>(records.size()),
                            static_cast<std::uint32_t>(pair.contacts),
                            {}});
      for (std::uint64_t k = 0; k < pair.contacts; ++k) records.push_back(message.take<ContactRecord>());
    }
  std::sort(list.pairs.begin(), list.pairs.end(),
            [](const PairResult& x, const PairResult& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  for (PairResult& pair : list.pairs) {
    const auto first = std::exchange(pair.first_contact, static_cast<std::uint32_t>(list.contacts.size()));
    for (std::uint32_t k = 0; k < pair.contact_count; ++k) list.contacts.push_back(records[first + k].contact());
  }
  replica.dt = pipeline.bodies.scene().dt;
  replica.gravity = pipeline.bodies.scene().gravity;
  report.response = response.step(replica, list);
  move_own();
  return report;
}

Response::Response(Pipeline& pipeline, ResponseOptions options) : impl_(std::make_unique<Impl>(pipeline, options)) {}
Response::~Response() = default;
Response::Response(Response&&) noexcept = default;
Response& Response::operator=(Response&&) noexcept = default;
void Response::begin_anew() {
  impl_->replica = Scene();
  impl_->places.clear();
  impl_->ids.clear();
  impl_->response = tandem::Response(impl_->options);
}
RankResponseReport Response::step(bool with_contacts) { return impl_->step(with_contacts); }

}  // namespace tandem::mpi
