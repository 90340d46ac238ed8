// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/start.hpp"

#include <utility>

#include "core/base/error.hpp"
#include "core/solve/initial_guess.hpp"
#include "core/solve/plugin_guess.hpp"
#include "core/solve/relaxation.hpp"

namespace graft {

namespace {

bool isLower(const Evaluation& a, const Evaluation& b) {
  return a.ok() && (!b.ok() || a.chi2 < b.chi2);
}

class Chooser {
 public:
  Chooser(const StartTools& tools, State given, Evaluation evaluation) : tools_(tools) {
    start_.state = std::move(given);
    start_.evaluation = std::move(evaluation);
  }

  Start run() {
    // Without associations to go by (they failed), no edge can tell where to begin.
    if (!start_.state.associations.empty()) choose();
    return std::move(start_);
  }

 private:
  struct Guess {
    State state;
    Evaluation evaluation;
    std::int64_t placed = 0;
    std::int64_t unplaced = 0;
  };

  void choose() {
    switch (tools_.options.initial_guess) {
      case InitialGuess::kFile:
        return;
      case InitialGuess::kChordal:
        return begin(StartKind::kChordal, relax(true));
      case InitialGuess::kPlugin:
        start_.name = tools_.options.guess_name;
        return begin(StartKind::kPlugin, askPlugin());
      case InitialGuess::kSpanningTree: {
        Guess tree = spread(start_.state);
        if (tree.placed > 0) begin(StartKind::kSpanningTree, std::move(tree));
        return;
      }
      case InitialGuess::kAuto:
        return chooseLowest();
    }
  }

  void chooseLowest() {
    const Evaluation given = start_.evaluation;
    Guess tree = spread(start_.state);
    const bool tree_wins = tree.placed > 0 && isLower(tree.evaluation, given);
    const Evaluation& best = tree_wins ? tree.evaluation : given;
    if (isPoor(best)) {
      Guess chordal = relax(false);
      if (chordal.placed > 0 && isLower(chordal.evaluation, best)) {
        noteUnusable(given, "the chordal relaxation");
        return begin(StartKind::kChordal, std::move(chordal));
      }
    }
    if (!tree_wins) return;
    noteUnusable(given, "a spanning tree");
    begin(StartKind::kSpanningTree, std::move(tree));
  }

  Evaluation evaluateAt(const Values& values, State& state) const {
    Evaluation evaluation = tools_.linearizer.begin(values, state);
    if (!evaluation.ok()) return evaluation;
    return tools_.cost ? tools_.cost(state) : tools_.linearizer.evaluate(state);
  }

  /// Whether a start is so far from what noise explains that a relaxation, which
  /// costs about as much as an iteration, is worth a try.
  bool isPoor(const Evaluation& evaluation) const {
    constexpr double kPoor = 10;
    double errors = 0;
    for (const EdgeGroup& group : tools_.problem.groups()) {
      errors += double(group.count) * group.error_dim;
    }
    return !evaluation.ok() || evaluation.chi2 > kPoor * errors;
  }

  Guess spread(const State& state, const std::vector<VertexRef>& placed = {}) const {
    SpreadResult result = spreadEstimates(tools_.problem, state, placed);
    Guess guess;
    guess.placed = result.placed;
    guess.unplaced = result.unplaced;
    if (guess.placed > 0 || !placed.empty()) {
      guess.evaluation = evaluateAt(result.values, guess.state);
    }
    return guess;
  }

  /// What a guess placed, and a spanning tree for what it left.
  Guess complete(Values values, const std::vector<VertexRef>& placed) const {
    State state = start_.state;
    state.values = std::move(values);
    Guess guess = spread(state, placed);
    guess.placed += std::int64_t(placed.size());
    return guess;
  }

  /// Without a relaxation, or with one that says no more than a tree: throws if it is
  /// required, else the guess has no vertex placed.
  Guess relax(bool required) const {
    RelaxResult result = relaxEstimates(tools_.problem, start_.state, tools_.pool, !required);
    if (result.failure.empty()) return complete(std::move(result.values), result.placed);
    if (!required) return {};
    throw Error(ExitCode::kNoResult, "there is no chordal initial guess: " + result.failure);
  }

  Guess askPlugin() const {
    const graft_guess_type* type = tools_.registry.guess(tools_.options.guess_name);
    if (type == nullptr) {
      throw Error(ExitCode::kUsage,
                  "unknown initial guess " + quoted(tools_.options.guess_name) +
                      "; auto, file, spanning-tree and chordal are built in" +
                      tools_.registry.advice({Kind::kGuess, tools_.options.guess_name}));
    }
    PluginGuessResult result = guessByPlugin(tools_.problem, start_.state, *type);
    if (!result.failed) return complete(std::move(result.values), result.placed);
    throw Error(ExitCode::kNoResult,
                "there is no initial guess " + tools_.options.guess_name + ": " +
                    (result.reason.empty() ? "it gives no reason" : result.reason));
  }

  void noteUnusable(const Evaluation& given, const char* start) {
    if (given.ok()) return;
    start_.notes.push_back("began with " + std::string(start) + ", because " + given.failure);
  }

  void begin(StartKind kind, Guess guess) {
    if (guess.unplaced > 0) {
      start_.notes.push_back("no edge of the spanning tree could place " +
                             std::to_string(guess.unplaced) +
                             " vertices; they begin where they were");
    }
    start_.kind = kind;
    start_.state = std::move(guess.state);
    start_.evaluation = guess.evaluation;
  }

  const StartTools& tools_;
  Start start_;
};

}  // namespace

Start chooseStart(const StartTools& tools, State given, Evaluation evaluation) {
  return Chooser(tools, std::move(given), std::move(evaluation)).run();
}

}  // namespace graft
