// The list of solvers of `tandem query --list-solvers`.
#include "solver_list.h"

#include <algorithm>
#include <array>
#include <iomanip>
#include <sstream>
#include <vector>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {
namespace {

constexpr std::array requests = {Request::collide, Request::distance, Request::contacts};

/// The kinds that have the same solvers with a given kind.
struct Partners {
  std::string names;
  std::array<std::string, requests.size()> answers;  ///< by request: the solver and its accuracy
};

std::vector<Partners> partners_of(const NarrowPhase& narrow_phase, ShapeKind a) {
  std::vector<Partners> rows;
  for (std::size_t k = static_cast<std::size_t>(a); k < shape_kinds; ++k) {
    const auto b = static_cast<ShapeKind>(k);
    Partners partners{std::string(name(b)), {}};
    for (std::size_t i = 0; i < requests.size(); ++i) {
      const SolverRow row = narrow_phase.solver_for(a, b, requests[i]);
      partners.answers[i] = std::string(row.solver) + ", " + std::string(name(row.exactness));
      if (row.exactness == Exactness::refused) partners.answers[i] = "refused";
    }
    const auto same = std::find_if(rows.begin(), rows.end(),
                                   [&](const Partners& other) { return other.answers == partners.answers; });
    if (same == rows.end())
      rows.push_back(std::move(partners));
    else
      same->names += ", " + partners.names;
  }
  return rows;
}

}  // namespace

std::string solver_list() {
  std::ostringstream text;
  for (const SolverInfo& solver : NarrowPhase::solvers())
    text << std::setw(16) << std::left << solver.name << solver.description << '\n';
  text << "\n| kind | with | collide | distance | contacts |\n|---|---|---|---|---|\n";
  const NarrowPhase narrow_phase;
  for (std::size_t k = 0; k < shape_kinds; ++k) {
    const auto a = static_cast<ShapeKind>(k);
    for (const Partners& row : partners_of(narrow_phase, a)) {
      text << "| " << name(a) << " | " << row.names;
      for (const std::string& answer : row.answers) text << " | " << answer;
      text << " |\n";
    }
  }
  text << "\n| within a tolerance of | kinds | request | solver | run with | ns |\n|--:|---|---|---|--:|--:|\n";
  for (const SolverRow& row : NarrowPhase::table())
    text << "| " << row.error << " | " << name(row.a) << ", " << name(row.b) << " | " << name(row.request) << " | "
         << row.solver << " | " << row.tolerance << " | " << row.nanoseconds << " |\n";
  return std::move(text).str();
}

}  // namespace tandem
