// What `tandem run` and `tandem-mpi run` write alike: lines of JSON, contacts, medians, hashes as text.
#pragma once
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "formats/json_writer.h"
#include "formats/output_file.h"
#include "tandem/flowgraph/options.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Sixteen digits.
std::string hex(std::uint64_t x);

/// X-Y, as --split takes it.
std::string written(Split split);

/// The upper one of two; of one value at least.
double median(std::vector<double> values);

double ms_since(std::chrono::steady_clock::time_point begin);

/// A contact of bodies a and b as an object of --contacts.
void write_contact(JsonWriter& out, std::uint64_t a, std::uint64_t b, const Contact& contact);

/// A line of --contacts: of a step all contacts, gaps among them only where they are asked for. `contacts_of` names
/// those of a pair, which has bodies a and b.
template <class Pairs, class ContactsOf>
void write_contacts(JsonWriter& out, std::uint64_t step, const Pairs& pairs, bool gaps, ContactsOf&& contacts_of) {
  out.begin_object().member("step", step).key("contacts").begin_array();
  for (const auto& pair : pairs)
    for (const Contact& contact : contacts_of(pair))
      if (contact.depth >= 0 || gaps) write_contact(out, pair.a, pair.b, contact);
  out.end_array().end_object();
}

/// Appends what was written and a line's end, and empties the writer.
void append_line(OutputFile& file, JsonWriter& line);

/// Those that are there get their names, all or none: the first when the last is known to be complete.
void commit_all(std::initializer_list<std::optional<OutputFile>*> files);

}  // namespace tandem
