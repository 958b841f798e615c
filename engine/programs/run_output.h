// Output that `tandem run` and `tandem-mpi run` have in common: lines of JSON, contacts, medians, hashes as text.
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

/// A hash as sixteen hexadecimal digits.
std::string hex(std::uint64_t x);

/// A split as X-Y, the form that --split reads.
std::string written(Split split);

/// The median, of an even number the upper one; needs at least one value.
double median(std::vector<double> values);

double ms_since(std::chrono::steady_clock::time_point begin);

/// Writes a contact of bodies a and b as an object of --contacts.
void write_contact(JsonWriter& out, std::uint64_t a, std::uint64_t b, const Contact& contact);

/// Writes a line of --contacts: all contacts of a step, those of negative depth only where asked for. `contacts_of`
/// returns those of a pair, which has bodies a and b.
template <class Pairs, class ContactsOf>
void write_contacts(JsonWriter& out, std::uint64_t step, const Pairs& pairs, bool gaps, ContactsOf&& contacts_of) {
  out.begin_object().member("step", step).key("contacts").begin_array();
  for (const auto& pair : pairs)
    for (const Contact& contact : contacts_of(pair))
      if (contact.depth >= 0 || gaps) write_contact(out, pair.a, pair.b, contact);
  out.end_array().end_object();
}

/// Appends the writer's text and a line end, and empties the writer.
void append_line(OutputFile& file, JsonWriter& line);

/// Renames the files that exist to their names, all or none: the first only when the last is complete.
void commit_all(std::initializer_list<std::optional<OutputFile>*> files);

}  // namespace tandem
