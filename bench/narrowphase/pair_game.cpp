// The contestants on one workload and request: pairs of convex shapes and half-spaces.
#include <memory>

#include "player.h"
#include "trial.h"

namespace tandem::bench {

Game make_game(const Workload& work, Request request) {
  Game game{work.kind, work.pair_class, std::string(name(request)), work.pairs.size(), {}, {}};
  game.record = [&work, request](std::size_t i) { return query_record(work, request, i); };
  const Question question{work.pairs, request, work.tracks};
  std::vector<Entrant> entrants = tandem_entrants();
  for (const auto& list : {fcl_entrants(), ccd_entrants(),
#ifdef TANDEM_HAS_BULLET
                           bullet_entrants()
#endif
       })
    entrants.insert(entrants.end(), list.begin(), list.end());
  for (const Entrant& entrant : entrants) {
    const std::shared_ptr<PairSolver> solver = entrant.enter(question);
    if (!solver) continue;
    solver->leave_out(deadly_queries(work.pairs.size(), [&](std::size_t i) { solver->answer_one(i); }));
    const auto found = std::make_shared<std::vector<Found>>(work.pairs.size());
    game.players.push_back({entrant.name, [solver, &work] { return work.pairs.size() - solver->left_out(); },
                            [solver, found] { solver->answer(*found); },
                            [found, &work, request] { return judge(work, request, *found); }});
  }
  return game;
}

}  // namespace tandem::bench
