// Speed against error of the narrow phase, beside FCL, libccd and Bullet.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "benches.h"
#include "narrowphase/pair_solver.h"
#include "narrowphase/player.h"
#include "narrowphase/race.h"
#include "narrowphase/trial.h"
#include "option_text.h"
#include "progress.h"

namespace tandem::bench {
namespace {

using reference::PairClass;
using reference::PairKind;

constexpr Request requests[] = {Request::collide, Request::distance, Request::contacts};

std::vector<std::string> known_kinds() {
  std::vector<std::string> out;
  for (std::size_t k = 0; k < reference::pair_kinds; ++k) out.emplace_back(name(static_cast<PairKind>(k)));
  out.emplace_back(torus_kind);
  return out;
}

std::vector<std::string> chosen_kinds(const Settings& settings) {
  const std::vector<std::string> known = known_kinds();
  for (const std::string& kind : settings.kinds)
    if (std::find(known.begin(), known.end(), kind) == known.end())
      refuse_option("--kind", kind, fmt::format("{}", fmt::join(known, ", ")));
  return settings.kinds.empty() ? known : settings.kinds;
}

/// The result of one contestant in a game.
struct Measured {
  Row row;
  Accuracy accuracy;
  std::string pair_class, request;
};

std::vector<Measured> play(Game game, int rounds) {
  std::vector<Runner> runners;
  for (const Player& player : game.players) runners.push_back({player.pass, player.queries});
  const std::vector<Samples> times = race(runners, rounds);
  std::vector<Measured> out;
  for (std::size_t i = 0; i < game.players.size(); ++i) {
    const Accuracy accuracy = game.players[i].judge();
    Row row{"narrowphase",        fmt::format("{}/{}/{}", game.kind, game.pair_class, game.request),
            game.players[i].name, 1,
            game.queries,         times[i],
            accuracy.hash,        to_json(accuracy)};
    row.more["kind"] = game.kind;
    row.more["class"] = game.pair_class;
    row.more["request"] = game.request;
    // Records are printed for wrong answers of tandem only, up to this length; otherwise kind, class and number suffice
    // to make them anew.
    constexpr std::size_t longest = 6000;
    if (game.record) {
      nlohmann::json worst = game.record(accuracy.worst);
      if (row.contestant != "tandem" || accuracy.right() || worst.dump().size() > longest)
        worst = {{"id", worst["id"]}};
      row.more["worst"] = std::move(worst);
    }
    out.push_back({std::move(row), accuracy, game.pair_class, game.request});
  }
  return out;
}

std::string time_text(double ns) {
  if (ns >= 1e5) return fmt::format("{:.0f}k", 1e-3 * ns);
  return fmt::format("{:.{}f}", ns, ns < 9.95 ? 1 : 0);
}

std::string cell(const Measured& m) {
  const Accuracy& a = m.accuracy;
  std::string text = fmt::format("{}; ", time_text(m.row.time.median()));
  text += a.error_p99 > 0 ? fmt::format("{:.0e}", a.error_p99) : "0";
  text += fmt::format("; {}W", a.wrong);
  if (a.failed > 0) text += fmt::format(" {}F", a.failed);
  if (a.normals > 0) text += fmt::format(" {}N", a.normals);
  return text;
}

/// Keeps texts in the order of their first appearance.
class Order {
 public:
  void add(const std::string& text) {
    if (std::find(texts_.begin(), texts_.end(), text) == texts_.end()) texts_.push_back(text);
  }
  auto begin() const { return texts_.begin(); }
  auto end() const { return texts_.end(); }

 private:
  std::vector<std::string> texts_;
};

void print_kind(const std::string& kind, const std::vector<Measured>& all) {
  Order requests_asked, contestants, classes;
  std::map<std::array<std::string, 3>, std::string> cells;  // by request, contestant and class
  for (const Measured& m : all) {
    requests_asked.add(m.request), contestants.add(m.row.contestant), classes.add(m.pair_class);
    cells[{m.request, m.row.contestant, m.pair_class}] = cell(m);
  }
  fmt::print("\n{}, {} queries a class\n{:<35}", kind, all.front().row.n, "");
  for (const std::string& c : classes) fmt::print(" {:<21}", c);
  fmt::print("\n");
  for (const std::string& request : requests_asked)
    for (const std::string& contestant : contestants) {
      std::string line;
      bool any = false;
      for (const std::string& c : classes) {
        const auto found = cells.find({request, contestant, c});
        any = any || found != cells.end();
        line += fmt::format(" {:<21}", found == cells.end() ? "" : found->second);
      }
      if (any) fmt::print("{:<10} {:<24}{}\n", request, contestant, line);
    }
}

bool is_rival(const Measured& m) { return !m.row.contestant.starts_with("tandem"); }

/// tandem's time compared with the fastest of the other contestants that are right.
struct Standing {
  double ratio = 0;   ///< below 1: tandem is faster; 0: no other is right
  std::string rival;  ///< empty: no other is right
  bool right = false;
  std::string text() const {
    const std::string mark = right ? "" : "!";
    return rival.empty() ? mark + "alone" : fmt::format("{}{:.2f} {}", mark, ratio, rival.substr(0, rival.find(',')));
  }
};

Standing standing(std::span<const Measured> game, const Measured& own) {
  Standing out;
  out.right = own.accuracy.right();
  double best = 0;
  for (const Measured& m : game)
    if (is_rival(m) && m.accuracy.right() && (out.rival.empty() || m.row.time.median() < best))
      best = m.row.time.median(), out.rival = m.row.contestant;
  if (!out.rival.empty()) out.ratio = own.row.time.median() / best;
  return out;
}

struct SummaryLine {
  std::string kind, request;
  std::map<std::string, std::string> by_class;
};

void print_summary(const std::vector<SummaryLine>& lines) {
  Order classes;
  for (const SummaryLine& line : lines)
    for (const auto& [c, text] : line.by_class) classes.add(c);
  fmt::print(
      "\ntandem's time over that of the fastest other contestant that is right (no wrong verdict, no failure, no error "
      "above 1e-9 of the size).\nBelow 1 tandem is faster; alone: no other is right; !: tandem is not right itself; *: "
      "{}.\n",
      several_at_once);
  fmt::print("{:<20} {:<10}", "", "");
  constexpr const char* order[] = {"separated", "near", "shallow", "deep", "hard", "motion"};
  for (const char* c : order) fmt::print(" {:<20}", c);
  fmt::print("\n");
  for (const SummaryLine& line : lines) {
    fmt::print("{:<20} {:<10}", line.kind, line.request);
    for (const char* c : order) {
      const auto found = line.by_class.find(c);
      fmt::print(" {:<20}", found == line.by_class.end() ? "" : found->second);
    }
    fmt::print("\n");
  }
}

/// Makes every class of the kind with each request, and passes the games to `on_game`.
void for_each_game(const std::string& kind, std::size_t n, const std::function<void(Game)>& on_game) {
  if (kind == torus_kind) {
    for (const PairClass c : reference::all_pair_classes)
      for (Game& game : torus_games(name(c), std::max<std::size_t>(5, n / 8))) on_game(std::move(game));
    return;
  }
  const std::vector<std::string> known = known_kinds();
  const auto k = static_cast<PairKind>(std::find(known.begin(), known.end(), kind) - known.begin());
  for (const PairClass c : reference::all_pair_classes) {
    const Workload work = make_workload(k, c, n);
    for (const Request request : requests) on_game(make_game(work, request));
  }
  const Workload motion = make_motion(k, n);
  for (const Request request : requests) on_game(make_game(motion, request));
}

}  // namespace

std::vector<Row> narrowphase_bench(const Settings& settings) {
  const std::vector<std::string> kinds = chosen_kinds(settings);
  const std::size_t n = settings.poses != 0 ? settings.poses : settings.quick ? 10 : 400;
  const int rounds = settings.repeat != 0 ? settings.repeat : settings.quick ? 3 : 15;
  fmt::print(
      "ns a query; p99 of the error; W wrong verdicts, F failures, N normals more than 1e-3 off.\n"
      "Time is the median of one thread's processor time, contestants in turn. Errors are relative to the size.\n"
      "A wrong verdict's error is the distance that it denies. A failure is an exception, an abort, NaN, or 10 ms.\n"
      "contacts: the error is of the deepest contact's depth. libccd and FCL unsigned measure not every pair.\n");
  const AbortTrap trap;
  std::vector<Row> rows;
  std::vector<SummaryLine> summary;
  Progress progress("narrowphase", kinds.size());
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    std::vector<Measured> all;
    std::map<std::string, std::size_t> lines;  // lines of the summary, by request
    for_each_game(kinds[k], n, [&](Game game) {
      const std::string request = game.request, pair_class = game.pair_class;
      std::vector<Measured> played = play(std::move(game), rounds);
      for (Measured& m : played) {
        const bool at_once = m.row.contestant == several_at_once;
        if (m.row.contestant == "tandem" || at_once) {
          const Standing stands = standing(played, m);
          if (!stands.rival.empty())
            m.row.more["fastest_right_rival"] = stands.rival, m.row.more["ratio_to_rival"] = stands.ratio;
          const std::string line = request + (at_once ? " *" : "");
          if (lines.emplace(line, summary.size()).second) summary.push_back({kinds[k], line, {}});
          summary[lines[line]].by_class[pair_class] = stands.text();
        }
        rows.push_back(m.row);
      }
      std::move(played.begin(), played.end(), std::back_inserter(all));
    });
    print_kind(kinds[k], all);
    progress.at(k + 1);
  }
  print_summary(summary);
  return rows;
}

}  // namespace tandem::bench
