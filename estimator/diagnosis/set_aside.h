// Outliers: readings that no model of the robot gives, found with the believed model and looked at again with the
// extended one.
#pragma once

#include <set>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

class SetAside {
 public:
  SetAside(double significance, const JointOptions& joint) : significance_(significance), joint_(joint) {}

  // Leaves out of the model what is an outlier to it, the worst first, and refits. Readings of one marker (of all of a
  // station) that are off from some moment on, or up to it, and what most readings of a load do, stay: the evidence has
  // to see them.
  void FromFitted(DiagnosedModel* model);
  // Readings that the extended model explains come back to the baseline; what is an outlier to it leaves, also what
  // came back by a poorer model and is not off with others; the extended model is refitted until no row changes. True:
  // some did. explains_all: nothing without a name is left next to its effects.
  bool FollowExtended(const DiagnosedModel& extended, bool explains_all, DiagnosedModel* baseline);
  // Outliers among untouched rows say nothing of the model: other markers of their shot give them away, or, where the
  // model lacks nothing or fitted rows have outliers, too, a reading that stands alone; no hold-out figure counts them:
  // the models between the two lose the same rows.
  void FromHeldOut(bool lacks_nothing, bool explains_all, DiagnosedModel* baseline, DiagnosedModel* final,
                   DiagnosedModel* lacking, std::vector<DiagnosedModel>* prefixes);

  // Held-out rows between the two fitted visits next to the moment of an effect: on which side of it they are nothing
  // says, so that no model predicts them. Of all models or none; said as a caution.
  void NextToMoments(const std::vector<EffectSpec>& effects, const std::vector<DiagnosedModel*>& models,
                     std::vector<std::string>* cautions) const;

  const std::vector<int>& outliers() const { return outliers_; }
  int held_out() const { return held_out_; }

 private:
  struct Judge {
    bool is_extended = false;  // what came back once may leave again
    bool explains_all = false;
  };
  // The same by any model.
  bool Follow(const DiagnosedModel& judge, const Judge& says, DiagnosedModel* baseline);
  // Judged by the fit without the few configurations that are off most.
  bool FollowWithoutWorst(DiagnosedModel* model);
  std::vector<int> StillOff(const DiagnosedModel& model) const;

  double significance_;
  JointOptions joint_;
  std::vector<int> outliers_;
  std::set<int> returned_;  // that were some once, or would be, had they no cause
  int held_out_ = 0;
};

}  // namespace sagitta
