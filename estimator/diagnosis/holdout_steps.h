// What each of the named effects, strongest first, does to untouched rows: the lacking model with none, one, two, … of
// them. An effect is judged together with what needs it: a compliance without its spring may be anything.
#pragma once

#include <vector>

#include "estimator/diagnosis/selected_effects.h"

namespace sagitta {

class HoldoutSteps {
 public:
  // Fits what is not yet fitted. final: with all effects. list: of the evidence that the effects are of.
  void Measure(const DiagnosedModel& lacking, const DiagnosedModel& final, const std::vector<SelectedEffect>& effects,
               const std::vector<Explanation>& list, const JointOptions& joint);
  // Forgets what is with effect `out`; `left` effects stay.
  void Drop(size_t out, size_t left);

  // An effect that makes untouched rows worse beyond chance, or, where all since the best step do together, the one of
  // these that makes them worst; -1 where none does.
  int Worst() const;
  // Of each effect, as of HoldoutGain; infinity where a model with or without it has no optimum.
  std::vector<double> Gains() const;
  // With the first `count` of the effects.
  const DiagnosedModel& With(size_t count) const { return models_[count]; }
  std::vector<DiagnosedModel>* models() { return &models_; }

 private:
  // Whether the models without and with an effect have an optimum.
  bool AreUsable(size_t effect) const;

  std::vector<DiagnosedModel> models_;
  std::vector<size_t> up_to_;  // of each effect, how many hold it and what needs it
};

// The last of the effects that needs this one, which goes before that does; -1: of none.
int GoesFirst(const std::vector<Explanation>& list, const std::vector<SelectedEffect>& effects, int place);

}  // namespace sagitta
